"""Friction curves of runs at constant speed: drawn from known laws, named by direction, confirmed at other speeds."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.analysis.steady_curve import DirectionPoints, FrictionCurve

SPEEDS = np.array([0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0])
NOISE = 0.02


def points(
    law: Callable[[float], float], direction: int = 1, seed: int = 0, noise: float = NOISE
) -> list[fd.SteadyPoint]:
    """A point at every speed, the torque's mean drawn about the law."""
    drawn = np.random.default_rng(seed).standard_normal(len(SPEEDS)) * noise
    return [
        fd.SteadyPoint(direction * u, direction * (law(u) + e), noise)
        for u, e in zip(SPEEDS.tolist(), drawn.tolist(), strict=True)
    ]


def plain(u: float) -> float:
    """Coulomb and viscous friction."""
    return 2.0 + 0.5 * u


def stribeck(u: float) -> float:
    """The same with a rise of 0.6 N m towards rest."""
    return plain(u) + 0.6 * float(np.exp(-u / 0.15))


def drag(u: float) -> float:
    """The same with a drag that grows with the square."""
    return plain(u) + 0.3 * u * u


@pytest.mark.parametrize("seed", range(8))
def test_plain_friction_gets_no_other_name(seed: int) -> None:
    """Level and slope within their standard deviations, nothing beside them."""
    found = fd.steady_friction(points(plain, seed=seed))[1]
    assert found.named == ()
    assert found.level[0] == pytest.approx(2.0, abs=4.0 * found.level[1])
    assert found.viscous[0] == pytest.approx(0.5, abs=4.0 * found.viscous[1])
    assert all(each.why for each in found.trials)


@pytest.mark.parametrize("seed", range(4))
def test_a_rise_towards_rest_is_stribeck_with_its_numbers(seed: int) -> None:
    """Excess and velocity within their standard deviations; no drag beside it."""
    found = fd.steady_friction(points(stribeck, seed=seed))[1]
    assert found.named == ("stribeck_friction",)
    numbers = found.trials[0].numbers
    assert numbers["excess"][0] == pytest.approx(0.6, abs=4.0 * numbers["excess"][1])
    assert numbers["velocity"][0] == pytest.approx(0.15, abs=4.0 * numbers["velocity"][1])
    assert found.torque(0.25) == pytest.approx(stribeck(0.25), abs=3.0 * NOISE)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """Of 60 drawn curves, those of excess and velocity hold it in 95 % of cases or so, and none reaches zero."""
    held = []
    for seed in range(60):
        curve = FrictionCurve.fitted(DirectionPoints.of(points(stribeck, seed=seed), 1), ("stribeck_friction",))
        for name, true in (("excess", 0.6), ("velocity", 0.15)):
            low, high = curve.interval(f"stribeck_friction.{name}")
            held.append(low <= true <= high)
            assert low > 0.0
    assert 0.88 < np.mean(held) < 1.0


def test_a_drag_is_a_drag() -> None:
    """The other law of the list, and not a Stribeck curve that imitates it."""
    found = fd.steady_friction(points(drag))[1]
    assert found.named == ("quadratic_drag",)
    assert found.torque(1.5) == pytest.approx(drag(1.5), abs=3.0 * NOISE)


@pytest.mark.parametrize("seed", range(4))
def test_a_slow_fall_of_friction_is_not_called_drag(seed: int) -> None:
    """A drag improves the fit too, but a fall towards the speeds that were recorded explains the runs better."""
    found = fd.steady_friction(points(lambda u: plain(u) + 1.5 * float(np.exp(-u / 0.8)), seed=seed))[1]
    assert "quadratic_drag" not in found.named
    assert found.trials[1].delta_bic < 0.0


def test_directions_are_judged_by_themselves() -> None:
    """One direction with a rise, the other without: only the first gets the name, each with the torque's sign."""
    found = fd.steady_friction([*points(plain), *points(stribeck, -1)])
    assert found[1].named == ()
    assert found[-1].named == ("stribeck_friction",)
    assert found[-1].torque(-0.25) == pytest.approx(-stribeck(0.25), abs=3.0 * NOISE)


def test_a_single_odd_run_is_no_law() -> None:
    """One run of twelve that is far off, the slowest: the other speeds do not confirm a law drawn through it."""
    made = points(plain)
    made[0] = fd.SteadyPoint(made[0].speed, made[0].torque + 0.3, NOISE)
    found = fd.steady_friction(made)[1]
    assert found.named == ()


def test_runs_that_took_no_part_may_speak_against_a_law() -> None:
    """Torque that crept up with the order of the runs looks like a drag; runs of another day know nothing of it."""
    found = fd.steady_friction(points(drag), points(plain, seed=9))[1]
    assert found.named == ()
    assert found.trials[1].why == "runs that were not used in the fit contradict it"
    assert fd.steady_friction(points(drag), points(drag, seed=9))[1].named == ("quadratic_drag",)


def test_scatter_from_run_to_run_counts() -> None:
    """Means that are claimed far too sure: the scatter says so and no name comes of it."""
    made = [fd.SteadyPoint(p.speed, p.torque, NOISE / 20.0) for p in points(plain, seed=3)]
    found = fd.steady_friction(made)[1]
    assert found.scatter > 10.0
    assert found.named == ()


def test_points_come_from_recordings_and_colour_makes_means_less_sure() -> None:
    """Samples that repeat ten times are worth a tenth: the mean's standard deviation is sqrt(10) times as large."""
    draw, t = np.random.default_rng(5), np.arange(3000) * 0.002
    white = 0.3 * draw.standard_normal(3000)
    coloured = np.repeat(0.3 * draw.standard_normal(300), 10)
    runs = [
        fd.Recording(t, {"tau.arm": 2.0 + each, "omega.arm": np.full(3000, speed)}, name=f"{speed}")
        for speed, each in ((0.5, white), (0.2, coloured))
    ]
    slow, fast = fd.steady_points(runs, "arm")
    assert (slow.name, fast.name) == ("0.2", "0.5")
    assert fast.std == pytest.approx(0.3 / np.sqrt(3000), rel=0.1)
    assert slow.std == pytest.approx(0.3 / np.sqrt(300), rel=0.25)


def test_results_pickle() -> None:
    """As everything does."""
    found = fd.steady_friction(points(stribeck))
    assert pickle.loads(pickle.dumps(found)) == found  # noqa: S301 - our own bytes


def test_what_is_missing_is_said_in_one_line() -> None:
    """Too few speeds, no velocity, a mean without a standard deviation."""
    with pytest.raises(fd.InputError, match="too few speeds"):
        fd.steady_friction(points(plain)[:7])
    t = np.arange(0.0, 1.0, 0.01)
    with pytest.raises(fd.InputError, match="no velocity"):
        fd.steady_points([fd.Recording(t, {"tau.arm": np.sin(t)})], "arm")
    with pytest.raises(fd.InputError, match="std"):
        fd.SteadyPoint(1.0, 1.0, 0.0)


def test_a_law_of_the_users_own_is_tried() -> None:
    """A rise that a hyperbola describes: its class declares `steady` and a speed."""
    script = f"""
import numpy as np
import flexdyn as fd
class HyperbolicFriction(fd.effects.JointEffect):
    '''Friction in excess of the kinetic level, which falls as a hyperbola.'''
    sides, stage = ("link", "motor"), "friction"
    law = "excess/(1 + (u/velocity)^2)*sign(u)"
    linear, grids, steady = ("excess",), {{"velocity": ("speed", (0.1,))}}, True
    excess: float = fd.effects.parameter("N m", lower=0.0)
    velocity: float = fd.effects.parameter("rad/s", lower=0.0, strict=True)
    def torque(self, x, u, *, t=0.0, tau=0.0):
        return self.excess * np.sign(u) / (1.0 + (np.asarray(u) / self.velocity) ** 2)
law = HyperbolicFriction("elbow", side="motor", excess=0.6, velocity=0.15)
speeds = np.array({SPEEDS.tolist()})
drawn = 0.004 * np.random.default_rng(0).standard_normal(len(speeds))
torque = 2.0 + 0.5 * speeds + law.torque(0.0, speeds) + drawn
found = fd.steady_friction([fd.SteadyPoint(u, tau, 0.004) for u, tau in zip(speeds, torque, strict=True)])[1]
(trial,) = [each for each in found.trials if each.named]
print(trial.effect, *(f"{{value:.2f}}" for value, _ in trial.numbers.values()))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["hyperbolic_friction", "0.60", "0.15"]
