"""The gap of true and of wrong models, over motions that were computed without flexdyn."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.constants import STRAY_SHARE
from flexdyn.diagnose.shooting import matched as matching
from flexdyn.diagnose.shooting import shooter as shooting
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.shooting.starts import window_starts
from flexdyn.diagnose.shooting.windows import Windows
from tests.arms import two_link
from tests.diagnose import slides
from tests.diagnose.truths import ARM, Levels, two_link_recording

Array = NDArray[np.float64]
FINE = Levels(position=1e-7, torque=0.02)
COARSE = Levels(position=1e-4, torque=1e-4)


def shot_of(levels: Levels, seed: int, signals: Sequence[str] = ("q", "theta"), **numbers: Any) -> Shot:
    """The two-link arm's model, with numbers of the shoulder changed, over one noisy recording."""
    model = two_link(ARM).replace(joints={"shoulder": numbers})
    return shoot(model, Windows.of(model, [two_link_recording(levels, seed, signals)], levels.noise()))


@pytest.mark.parametrize("levels", [Levels(), FINE, COARSE], ids=["both", "torque noise", "sensor noise"])
@pytest.mark.parametrize("signals", [("q", "theta"), ("q",), ("theta",)], ids=["both encoders", "link", "motor"])
def test_a_true_model_has_a_gap_of_one(levels: Levels, signals: tuple[str, ...]) -> None:
    """Whatever noise dominates and whichever encoders there are; torque noise leaves few degrees of freedom."""
    shots = [shot_of(levels, seed, signals=signals) for seed in range(6)]
    assert np.sqrt(np.mean([shot.gap**2 for shot in shots])) == pytest.approx(1.0, abs=0.15)
    rows = sum(shot.whitened().size for shot in shots)
    assert sum((shot.whitened() ** 2).sum() for shot in shots) / rows == pytest.approx(1.0, abs=0.15)


def test_windows_that_are_not_asked_for_keep_what_they_did() -> None:
    """Some are simulated, from other first states."""
    shot = shot_of(Levels(), 0)
    shooter = shooting.Shooter(shot.model, shot.windows)
    whole = shooter.run(shot.x0)
    some = np.array([1, 4])
    there = shooter.run(shot.x0 + 1e-3, which=some, others=whole)
    kept = np.setdiff1d(np.arange(len(shot.windows)), some)
    assert len(kept) > 2
    assert np.array_equal(there.q[kept], whole.q[kept])
    assert np.array_equal(there.x[some], shooter.run(shot.x0 + 1e-3).x[some])
    assert (there.q[some] != whole.q[some]).any()


@pytest.mark.filterwarnings("ignore::flexdyn.LimitWarning")
def test_only_windows_that_stray_are_tried_from_rest() -> None:
    """Motors that stick where nobody sees them: two windows begin on the wrong side, and get nearer from rest.

    The other windows stay as they were, to the last bit.
    """
    friction = [fd.effects.CoulombFriction(joint, side="motor", level=3.0) for joint in ("shoulder", "elbow")]
    model, t, levels = two_link(ARM, friction), np.arange(0.0, 12.0, 0.002), Levels(position=1e-6, torque=0.01)
    swell = np.where(np.sin(0.4 * t) > 0.0, 4.0 * np.sin(1.3 * t), 0.0)
    tau = np.stack([swell + np.sin(9.0 * t), 2.5 * np.sin(1.7 * t + 1.0)], axis=1)
    run, draw = fd.simulate(model, fd.Samples(t, tau), rate=250).to_recording(), np.random.default_rng(0)
    noise = {"q": levels.position, "tau": levels.torque}
    names = [f"{signal}.{joint}" for signal in noise for joint in model.joint_names]
    seen = {name: run[name] + noise[name.split(".")[0]] * draw.standard_normal(len(run)) for name in names}
    windows = Windows.of(model, [fd.Recording(run.t, seen)], levels.noise())
    shooter = shooting.Shooter(model, windows)
    starts, used = window_starts(shooter), shoot(model, windows).used
    assert starts.stuck is not None
    alone = matching.Matching(shooter, dataclasses.replace(starts, stuck=None), used).best()
    both = matching.Matching(shooter, starts, used).best()
    strays = alone.stray(used)
    assert 0 < strays.sum() < 5 < len(windows)
    after, before = (each.filter.scaled(each.residual) for each in (both, alone))
    assert (after <= before).all()
    assert (after[strays] < 0.97 * before[strays]).any()
    np.testing.assert_array_equal(both.moved[~strays], alone.moved[~strays])


def test_whitened_residuals_of_a_true_model_are_white() -> None:
    """One block knows nothing of the next, though torque noise makes the plain residual a smooth curve."""
    shots = [shot_of(FINE, seed) for seed in range(3)]
    surprises = np.concatenate([each.whitened().reshape(len(each.x0), each.windows.blocks, -1) for each in shots])
    ahead = (surprises[:, 1:] * surprises[:, :-1]).mean(axis=(0, 1))
    np.testing.assert_allclose(ahead, 0.0, atol=0.12)
    scaled = shot_of(FINE, 0).scaled
    assert ((scaled[:, 1:] * scaled[:, :-1]).mean(axis=(0, 1)) > 0.7 * (scaled**2).mean(axis=(0, 1))).all()


def test_the_floor_is_about_one() -> None:
    """A model that is right by construction, with drawn noise."""
    assert shot_of(Levels(), 0).floor() == pytest.approx(1.0, abs=0.25)


def test_a_wrong_number_opens_the_gap_in_proportion() -> None:
    """Twice the error, twice the excess."""
    wrong = [shot_of(COARSE, 0, stiffness=400.0 * (1.0 + error)) for error in (0.0, 0.2, 0.4)]
    excess = [np.sqrt(each.gap**2 - wrong[0].gap ** 2) for each in wrong[1:]]
    assert excess[0] > 1.0
    softer = 1.0 / 1.2 - 1.0, 1.0 / 1.4 - 1.0  # what happens depends on the compliance
    assert excess[1] / excess[0] == pytest.approx(softer[1] / softer[0], rel=0.15)


def test_slopes_lead_back_to_the_true_numbers() -> None:
    """One step of Gauss and Newton on whitened residuals undoes 3 % in rotor inertia and stiffness, within errors."""
    wrong: dict[str, Any] = {"rotor_inertia": 0.1 * 1.03, "stiffness": 400.0 * 0.97}
    shot = shot_of(Levels(), 1, **wrong)
    moved = [shot.model.replace(joints={"shoulder": {key: 1.01 * value}}) for key, value in wrong.items()]
    J = np.stack([(shot.whitened(each) - shot.whitened()).ravel() / 0.01 for each in moved], axis=1)
    factors = 1.0 - np.linalg.lstsq(J, shot.whitened().ravel(), rcond=None)[0]
    std = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    assert (std < 0.01).all()
    np.testing.assert_array_less(np.abs(factors - [1.0 / 1.03, 1.0 / 0.97]), 4.0 * std + 2e-3)


@pytest.mark.parametrize(
    "effect",
    [
        fd.effects.SensorOffset("theta.elbow", offset=0.02),
        fd.effects.SensorGain("q.shoulder", gain=-2.0),
        fd.effects.EncoderEccentricity("q.elbow", amplitude=0.01, harmonic=3.0, phase=0.4),
        fd.effects.SensorGain("tau.shoulder", gain=0.25),
        fd.effects.SensorOffset("tau.elbow", offset=0.3),
        fd.effects.ChannelLag("q.elbow", delay=0.012),
    ],
    ids=lambda effect: f"{effect.name} {effect.channel}",
)
def test_sensor_effects_act_before_the_comparison(effect: fd.effects.SensorEffect) -> None:
    """A sensor that errs opens the gap; a model that knows its error closes it."""
    levels = Levels(position=1e-4)
    clean = two_link_recording(levels, 3)
    channels = dict(clean.channels)
    channels[effect.channel] = effect.measured(channels[effect.channel], clean.t)
    recording = fd.Recording(clean.t, channels)
    ignorant, knowing = two_link(ARM), two_link(ARM, [effect])
    windows = Windows.of(knowing, [recording], levels.noise())
    assert shoot(knowing, windows).gap < 1.4
    assert shoot(ignorant, windows).gap > 3.0


@pytest.mark.parametrize("delay", [0.004, 0.010])
def test_a_delayed_command_begins_before_the_window(delay: float) -> None:
    """The torques of before a window's start still arrive in it, also half-way between two samples."""
    levels = Levels()
    true = two_link_recording(levels, 4)
    ahead = {
        name: np.interp(true.t + delay, true.t, x) if name[:3] == "tau" else x for name, x in true.channels.items()
    }
    if delay == 0.004:  # a whole sample: exactly the torques, early
        ahead |= {name: np.append(true[name][1:], 0.0) for name in ahead if name[:3] == "tau"}
    effects = [fd.effects.CommandDelay(joint, delay=delay) for joint in ("shoulder", "elbow")]
    model = two_link(ARM, effects)
    windows = Windows.of(model, [fd.Recording(true.t[:-5], {k: x[:-5] for k, x in ahead.items()})], levels.noise())
    assert shoot(model, windows).gap < (1.3 if delay == 0.004 else 4.0)
    assert shoot(two_link(ARM), windows).gap > 8.0


def test_a_simulation_that_fails_counts_as_a_bounded_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that breaks down leaves a finite gap, larger than that of any model that can be simulated."""
    monkeypatch.setattr(shooting, "MOST_EVALUATIONS", 20_000)
    levels = Levels()
    windows = Windows.of(two_link(ARM), [two_link_recording(levels, 0)], levels.noise())
    pair = (("elbow", "shoulder"), ("shoulder", "elbow"))
    runaway = [fd.effects.JointCoupling(one, other=two, coefficient=-3e3) for one, two in pair]
    shot = shoot(two_link(ARM, runaway), windows)
    assert np.isfinite(shot.whitened()).all()
    assert 100.0 < shot.gap < np.inf
    assert np.abs(shot.residual).max() <= 1.0 + 3.0 * np.ptp(windows.measured, axis=(0, 1)).max()


def test_a_recording_without_torque_noise_is_judged_by_its_sensors() -> None:
    """No torque noise at all is a level like any other."""
    levels = Levels(position=1e-5, torque=0.0)
    assert shot_of(levels, 2).gap == pytest.approx(1.0, abs=0.15)


def test_the_simulation_is_far_more_exact_than_the_noise() -> None:
    """Steps a hundred times shorter change nothing that a sensor could see."""
    shot = shot_of(FINE, 0)
    shooter = shooting.Shooter(shot.model, shot.windows)
    usual, exact = (shooter.reported(shooter.run(shot.x0, tight)) for tight in (1.0, 0.01))
    assert np.sqrt(((usual - exact) ** 2).mean()) < 0.2 * FINE.position


def test_windows_of_slow_arms_with_dry_friction_take_the_classical_method() -> None:
    """Against Dormand-Prince at tight tolerance, far below the noise though joints stick and break away."""
    friction = [fd.effects.CoulombFriction(joint, side="motor", level=0.4) for joint in ("shoulder", "elbow")]
    model = two_link(ARM, friction).replace(joints={"*": {"stiffness": 80.0}})
    windows = Windows.of(model, [two_link_recording(FINE, 0)], FINE.noise())
    shooter = shooting.Shooter(model, windows)
    x0 = window_starts(shooter).x
    assert isinstance(shooter._solver(x0, 1.0), fd.solvers.RungeKutta4)
    usual = shooter.reported(shooter.run(x0))
    exact = _by(shooter, x0, fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12))
    assert (np.abs(np.diff(usual[:, :, 2:], axis=1)) == 0.0).any()  # some rest
    assert np.sqrt(((usual - exact) ** 2).mean()) < FINE.position


def _by(shooter: shooting.Shooter, x0: Array, solver: fd.solvers.Solver) -> Array:
    """Windows as another solver has them (windows, rows, channels)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shooter, "_solver", lambda *_: solver)
        return shooter.reported(shooter.run(x0))


def test_a_few_stray_windows_do_not_outvote_the_rest() -> None:
    """A tenth of the windows may be off by any amount; one more counts, and then the verdict is no longer noise."""
    levels, model = Levels(), two_link(ARM)
    twice = [two_link_recording(levels, seed, ("q", "theta")) for seed in (0, 1)]
    shot = shoot(model, Windows.of(model, twice, levels.noise()))
    count = len(shot.x0)
    spared = count - math.ceil((1.0 - STRAY_SHARE) * count)
    assert spared > 0
    before = shot.left

    def with_stray(some: int) -> Shot:
        far = shot.residual.copy()
        far[:some] += 100.0 * shot.std[:some]
        return dataclasses.replace(shot, residual=far)

    few, more = with_stray(spared), with_stray(spared + 1)
    assert before == pytest.approx(1.0, abs=0.25)
    assert few.left < 1.5
    assert more.left > 10.0
    assert few.is_mostly_noise()
    assert not more.is_mostly_noise()
    assert more.is_noise()  # the median window says nothing of it


def test_a_warm_up_goes_on_in_the_test_data(tmp_path: Path) -> None:
    """The last fifth of a recording is tested at its own time; the model is right, and the simulation says so."""
    steps = iter(range(10**9))

    def acting(force: float, _x: float, v: float) -> float:
        sample, part = divmod(next(steps), 32)
        t = (sample + (part // 4 + (0.0, 0.5, 0.5, 1.0)[part % 4]) / 8.0) / slides.RATE
        return force - (1.0 + 2.0 * math.exp(-t / 4.0)) * v

    t = np.arange(6000) / slides.RATE
    record = slides.pushed(t, 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t), acting)
    warm = fd.effects.WarmUpFriction("lift", side="motor", coefficient=2.0, time_constant=4.0)
    viscous = fd.effects.ViscousFriction("lift", side="motor", coefficient=1.0)
    found = fd.diagnose(slides.model(tmp_path, [warm, viscous]), [record], progress=False)
    assert found.verdict == "no_discrepancy"
    assert found.gap_test is not None
    assert found.gap_test.before < 1.5
