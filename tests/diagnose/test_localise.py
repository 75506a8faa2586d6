"""Where the gap is: the equation and the regime that a known torque was put into are named."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.localise import localise, traces
from flexdyn.diagnose.equations.regime import Quantity, regime
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_motion, two_link_recording

Array = NDArray[np.float64]
BLOCKS = 1600
NOISE = 0.02


def motion() -> dict[str, Array]:
    """A made-up motion over 40 s, block by block."""
    t = np.linspace(0.0, 40.0, BLOCKS)
    u = np.sin(1.3 * t) * (0.1 + np.abs(np.sin(0.31 * t)))
    return {"t": t, "u": u, "q": np.sin(2.1 * t + 0.4), "load": 20.0 * np.cos(3.7 * t), "other": np.sin(4.3 * t) ** 3}


def quantities() -> list[Quantity]:
    """What it may depend on."""
    m = motion()
    return [
        Quantity("abs(omega) {} rad/s", np.abs(m["u"])),
        Quantity("omega {}", m["u"], signed=True),
        Quantity("abs(tau_s) {} N m", np.abs(m["load"])),
        Quantity("q {} rad", m["q"]),
        Quantity("t {} s", m["t"]),
        Quantity("abs(omega of elbow) {} rad/s", np.abs(m["other"])),
    ]


def noisy(excess: Array, seed: int = 1) -> Array:
    """Mean squares of five white residuals each of variance 1 + excess."""
    draw = np.random.default_rng(seed)
    return np.asarray((1.0 + excess) * draw.chisquare(5, len(excess)) / 5)


LAWS: dict[str, tuple[Callable[[dict[str, Array]], Any], str, tuple[float, ...]]] = {
    "low speed": (lambda m: 40.0 * np.exp(-2.0 * np.abs(m["u"]) / 0.1), r"abs\(omega\) < (\S+) rad/s", (0.12,)),
    "high speed": (lambda m: 40.0 * m["u"] ** 4, r"abs\(omega\) > (\S+) rad/s", (0.65,)),
    "direction": (lambda m: 20.0 * (m["u"] < 0.0), r"omega < (\S+)", (0.0,)),
    "load": (lambda m: 0.1 * m["load"] ** 2, r"abs\(tau_s\) > (\S+) N m", (13.0,)),
    "position": (lambda m: 30.0 * (np.abs(m["q"] - 0.5) < 0.25), r"q between (\S+) and (\S+) rad", (0.25, 0.75)),
    "end of the range": (lambda m: 30.0 * (m["q"] > 0.7), r"q > (\S+) rad", (0.7,)),
    "early": (lambda m: 60.0 * np.exp(-m["t"] / 4.0), r"t < (\S+) s", (9.0,)),
    "late": (lambda m: 20.0 * (m["t"] > 30.0), r"t > (\S+) s", (30.0,)),
    "another joint": (lambda m: 30.0 * m["other"] ** 2, r"abs\(omega of elbow\) > (\S+) rad/s", (0.45,)),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_regime_is_named_with_its_bound(name: str) -> None:
    """Of all quantities the one the power depends on, bounded within a bin or two."""
    law, pattern, bounds = LAWS[name]
    said = regime(noisy(law(motion())), quantities())
    found = re.fullmatch(pattern, said)
    assert found, said
    scale = max(*(abs(b) for b in bounds), 0.1)
    assert [float(x) for x in found.groups()] == pytest.approx(list(bounds), abs=0.35 * scale)


def test_two_conditions_at_once() -> None:
    """Friction that fades as the gear warms up: early, and the more the faster."""
    m = motion()
    said = regime(noisy(4000.0 * m["u"] ** 4 * np.exp(-m["t"] / 8.0)), quantities())
    assert re.fullmatch(r"t < \S+ s and abs\(omega\) > \S+ rad/s|abs\(omega\) > \S+ rad/s and t < \S+ s", said), said


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_regime(seed: int) -> None:
    """Neither has noise alone nor an excess that is the same throughout."""
    assert regime(noisy(np.zeros(BLOCKS), seed), quantities()) == "everywhere"
    assert regime(noisy(np.full(BLOCKS, 5.0), seed), quantities()) == "everywhere"


def equations(torque: Callable[[Array, Array, Array], Any], joint: int = 0) -> Equations:
    """The oracle's arm, whose motor was asked for a torque (t, theta, omega) more than the model knows of."""
    model = two_link(ARM)
    data = measured(model, two_link_recording(Levels(position=1e-7, torque=NOISE), seed=5))
    states = two_link_motion()[0]
    tau = data.tau.copy()
    tau[:, joint] += torque(data.t, states[:, 2 + joint], states[:, 6 + joint])
    changed = {name: value for name, value in vars(data).items() if name != "tau"}
    return Equations(model, (Measured(**changed, tau=tau),), Filters.of_rate(data.dt))


def places(made: Equations) -> list[tuple[str, str, float, str]]:
    """Localised, all rows in units of the noisiest equation's noise."""
    rows = made.residual.reshape(-1, len(made.kinds))
    quiet = equations(lambda t, x, u: 0.0 * t).residual.reshape(rows.shape).std(axis=0).max()
    hidden = np.zeros(rows.size, dtype=bool)
    return [(p.joint, p.side, p.share, p.regime) for p in localise(made, (rows / quiet).ravel(), hidden)]


def test_noise_has_no_place() -> None:
    """Nothing beyond chance: no places."""
    assert places(equations(lambda t, x, u: 0.0 * t)) == []


@pytest.mark.parametrize("joint", [0, 1])
def test_a_motors_friction_is_found_there(joint: int) -> None:
    """A torque against one rotor stands in that motor's equation alone."""
    ((name, side, share, where),) = places(equations(lambda t, x, u: 0.5 * u * np.abs(u), joint))
    assert (name, side) == (("shoulder", "elbow")[joint], "motor")
    assert share == pytest.approx(1.0, abs=0.02)
    assert re.fullmatch(r"abs\(omega\) > \S+ rad/s.*", where), where


def test_one_direction_and_a_late_time() -> None:
    """A torque in one direction alone, and one that begins with the third second."""
    assert places(equations(lambda t, x, u: 0.4 * (u > 0.0)))[0][3].startswith("omega > 0")
    late = places(equations(lambda t, x, u: 0.4 * (t > 2.0)))[0][3]
    found = re.fullmatch(r"t > (\S+) s", late)
    assert found, late
    assert float(found[1]) == pytest.approx(2.0, abs=0.3)


def test_shares_sum_to_one() -> None:
    """Of two torques, sixteen times the power has sixteen times the share."""
    first = equations(lambda t, x, u: 0.8 * np.sin(9.0 * t))
    second = equations(lambda t, x, u: 0.2 * np.sin(9.0 * t), joint=1)
    tau = first.data[0].tau + second.data[0].tau - equations(lambda t, x, u: 0.0 * t).data[0].tau
    changed = {name: value for name, value in vars(first.data[0]).items() if name != "tau"}
    both = Equations(first.model, (Measured(**changed, tau=tau),), first.filters)
    found = places(both)
    assert [(joint, side) for joint, side, _, _ in found] == [("shoulder", "motor"), ("elbow", "motor")]
    assert sum(share for _, _, share, _ in found) == pytest.approx(1.0)
    assert found[0][2] / found[1][2] == pytest.approx(16.0, rel=0.25)


def test_traces_show_what_was_left() -> None:
    """Three pictures an equation, time first; what was missing stands before, and not after."""
    before, after = equations(lambda t, x, u: 0.5 * np.sign(u)), equations(lambda t, x, u: 0.0 * t)
    pictures = traces(before, after, np.zeros(len(before.residual), dtype=bool))
    assert len(pictures) == 3 * len(before.kinds)
    time, speed, position = pictures[:3]
    assert [each.x_label for each in (time, speed, position)] == ["t [s]", "omega [rad/s]", "theta [rad]"]
    assert time.title == "shoulder, motor side"
    assert time.y_label == "residual torque [N m]"
    assert (np.diff(time.x) > 0.0).all()
    fast = np.abs(speed.x) > 0.3
    np.testing.assert_allclose(speed.before[fast], 0.5 * np.sign(speed.x[fast]), atol=0.1)
    np.testing.assert_allclose(speed.after[fast], 0.0, atol=0.1)


def test_masked_rows_are_not_drawn() -> None:
    """Rows that say nothing leave a gap in the line over time, and no dots."""
    made = equations(lambda t, x, u: 0.0 * t)
    mask = np.zeros(len(made.residual), dtype=bool)
    mask.reshape(-1, len(made.kinds))[10:20, 0] = True
    time, speed, _ = traces(made, made, mask)[:3]
    rows = len(mask) // len(made.kinds)
    assert np.isnan(time.before).sum() == 10
    assert len(speed.x) == rows - 10
