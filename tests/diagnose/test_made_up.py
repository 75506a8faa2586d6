"""Positions that no encoder saw, against what the transmission's law says of an arm that stands still."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.proposal import half_gaps
from flexdyn.diagnose.inference.sizes import Sizes
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE, two_link_motion

Array = NDArray[np.float64]
TORQUE = (3.0, -2.0)
GAP, CUBIC, SOFT, WIDTH = 2e-3, 4e5, 100.0, 2e-3


def standing(*effects: fd.effects.Effect, torque: Array | None = None) -> Equations:
    """Of rotors at rest under a torque, seen by their own encoders alone.

    Args:
        effects: of the model.
        torque: on the shoulder (samples,) [N m]; None: constant.
    """
    shoulder = np.full(400, TORQUE[0]) if torque is None else torque
    times = np.arange(len(shoulder)) / RATE
    channels = {f"theta.{joint}": np.full(len(times), 0.3) for joint in JOINTS}
    channels |= {"tau.shoulder": shoulder, "tau.elbow": np.full(len(times), TORQUE[1])}
    model = two_link(ARM, effects)
    data = measured(model, fd.Recording(times, channels))
    return Equations(model, (data,), Filters.of_rate(data.dt))


def winding(effect: fd.effects.Effect | None, torque: float, stiffness: float) -> float:
    """Deflection under a torque, by the laws as they are written."""
    size = abs(torque)
    if isinstance(effect, fd.effects.HardeningSpring):
        roots = np.roots([CUBIC, 0.0, stiffness, -size])
        wound = float(roots[np.abs(roots.imag) < 1e-12].real[0])
    elif isinstance(effect, fd.effects.Backlash):
        wound = size / stiffness + GAP
    else:
        wound = size / stiffness
    return float(np.copysign(wound, torque))


@pytest.mark.parametrize(
    "effect",
    [None, fd.effects.HardeningSpring("shoulder", cubic=CUBIC), fd.effects.Backlash("shoulder", half_gap=GAP)],
    ids=["spring", "hardening", "play"],
)
def test_a_link_stands_where_its_transmission_holds_it(effect: fd.effects.Effect | None) -> None:
    """``K delta + cubic delta^3 = tau``, and half a gap more."""
    at = standing(*([effect] if effect else []))
    wound = at.motions[0].delta
    K = at.true.stiffness
    np.testing.assert_allclose(wound[:, 0], winding(effect, TORQUE[0], K[0]), rtol=1e-9)
    if isinstance(effect, fd.effects.Backlash):  # the law in the core leads back
        np.testing.assert_allclose(K[0] * effect.deflection(wound[:, 0]), TORQUE[0], rtol=1e-9)
    np.testing.assert_allclose(wound[:, 1], winding(None, TORQUE[1], K[1]), rtol=1e-9)


def test_hysteresis_and_spring_carry_the_torque_together() -> None:
    """Wound one way from rest, ``K delta + stiffness width (1 - exp(-delta/width)) = tau``."""
    rising = np.linspace(0.0, TORQUE[0], 2000)
    at = standing(fd.effects.SpringHysteresis("shoulder", stiffness=SOFT, width=WIDTH), torque=rising)
    along, K = at.motions[0], at.true.stiffness[0]
    wound, tau = along.delta[100:, 0], along.tau[100:, 0]
    carried = K * wound - SOFT * WIDTH * np.expm1(-wound / WIDTH)
    np.testing.assert_allclose(carried, tau, rtol=1e-3, atol=3e-3)  # the first samples' winding is lost to the filter
    assert (K * wound < 0.99 * tau).all()


@pytest.mark.parametrize("gap", [0.0, 1e-3, 4e-3])
def test_play_is_looked_for_as_wide_as_it_may_be(gap: float) -> None:
    """Both encoders: the deflection beyond what the spring carries; not the whole of it, which no spring would do."""
    states, tau = two_link_motion()
    channels = {f"tau.{joint}": tau[:, j] for j, joint in enumerate(JOINTS)}
    for j, joint in enumerate(JOINTS):
        wound = states[:, 2 + j] - states[:, j]
        channels[f"q.{joint}"] = states[:, j]
        channels[f"theta.{joint}"] = states[:, 2 + j] + gap * np.sign(wound)
    model = two_link(ARM)
    data = measured(model, fd.Recording(np.arange(len(tau)) / RATE, channels))
    at = Equations(model, (data,), Filters.of_rate(data.dt))
    for j in range(2):
        deflection = float(np.abs(at.motions[0].delta[:, j]).max())
        assert max(half_gaps(at, j, deflection)) == pytest.approx(max(gap, 0.05 * deflection), rel=0.25)


@pytest.mark.parametrize(
    ("places", "scaled"),
    [(("theta",), True), (("q",), False), (("q", "theta"), False)],
    ids=["motors", "links", "both"],
)
def test_a_gain_scales_rows_where_a_torque_makes_the_link_s_position(places: tuple[str, ...], scaled: bool) -> None:
    """A rotor's position is made of what the links need: the recorded torque, and its noise, is not in it."""
    times = np.arange(400) / RATE
    sway = 0.3 * np.sin(5.0 * times)
    channels = {f"{place}.{joint}": sway for place in places for joint in JOINTS}
    channels |= {f"tau.{joint}": np.cos(5.0 * times) for joint in JOINTS}
    model = two_link(ARM)
    at = Equations(model, (measured(model, fd.Recording(times, channels)),), Filters.of_rate(1.0 / RATE))
    nothing = np.zeros(len(JOINTS))
    sizes = Sizes(at, SampleNoise(nothing, nothing, nothing, nothing), np.zeros(at.residual.size, bool))
    rows = at.residual.size // len(at.kinds)
    assert sizes.rows_of(JOINTS[0]) == (rows if scaled else 0)
