"""How large an effect must be: waves against rounding errors, dampings against the decay of a vibration."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.constants import SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.inference.sizes import Sizes
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE

T = np.arange(4000) / RATE
SWAY = 0.4 * np.sin(1.7 * T) + 0.3 * np.sin(2.9 * T + 0.4)


def _sizes(step: float) -> Sizes:
    """Of the two-link arm that sways, with encoders of one step."""
    channels = {f"{signal}.{joint}": SWAY for signal in ("q", "theta") for joint in JOINTS}
    channels |= {f"tau.{joint}": np.cos(5.0 * T) for joint in JOINTS}
    at = Equations(two_link(ARM), (measured(two_link(ARM), fd.Recording(T, channels)),), Filters.of_rate(1.0 / RATE))
    sigma = np.full(2, step / np.sqrt(12.0))
    return Sizes(at, SampleNoise(sigma, sigma, np.zeros(2), np.zeros(2)), np.zeros(at.residual.size, bool))


@pytest.mark.parametrize("step", [3e-3, 3e-4])
@pytest.mark.parametrize("harmonic", [3.0, 80.0])
def test_waves_in_rounding_errors_are_smaller(step: float, harmonic: float) -> None:
    """Least squares of a wave on what rounding makes, at many places of the steps: below the bound."""
    draw = np.random.default_rng(0)
    wave = np.column_stack([np.sin(harmonic * SWAY), np.cos(harmonic * SWAY)])
    amplitudes = []
    for start in draw.uniform(0.0, step, 200):
        error = step * np.round((SWAY + start) / step) - (SWAY + start)
        amplitudes.append(float(np.hypot(*np.linalg.lstsq(wave, error, rcond=None)[0])))
    bound = _sizes(step).resolution({"effect": "encoder_eccentricity", "channel": "theta.elbow"})
    assert max(amplitudes) < bound < 30.0 * float(np.median(amplitudes))
    assert bound < 0.3 * step


def test_an_offset_may_be_a_step() -> None:
    """Of an encoder that rounds down, say; and no wave on two steps of an encoder is told from rounding."""
    assert _sizes(1e-3).resolution({"effect": "sensor_offset", "channel": "q.elbow"}) == pytest.approx(1e-3)
    assert _sizes(1.0).resolution({"effect": "kinematic_error", "joint": "elbow"}) == pytest.approx(1.0)
    assert _sizes(1.0).resolution({"effect": "torque_ripple", "joint": "elbow"}) == 0.0


def test_an_offset_of_more_than_a_step_is_an_effect_however_little_torque_it_makes() -> None:
    """Ten steps count from a tenth of their torque on; without steps the torque decides."""
    offset = fd.effects.SensorOffset("theta.elbow", offset=-1e-2)
    assert _sizes(1e-3).smallest(offset, 1e-4) == pytest.approx(1e-5)
    assert _sizes(1e-3).smallest(offset, 1.0) == SMALLEST_TORQUE_SHARE
    assert _sizes(0.0).smallest(offset, 1e-4) == SMALLEST_TORQUE_SHARE


def test_a_damping_counts_by_how_fast_a_vibration_decays() -> None:
    """Elbow and rotor against each other, the shoulder held: from the ratio 0.002 of the eigenvalues on."""
    sizes, j = _sizes(1e-3), 1
    link = float(np.mean([ARM.inertias(float(q))[1] for q in SWAY]))
    J, K = ARM.rotor[j], ARM.stiffness[j]

    def ratio(D: float) -> float:
        stiffness, damping = (x * np.array([[1.0, -1.0], [-1.0, 1.0]]) for x in (K, D))
        mass = np.diag([link, J])
        A = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]
        )
        fastest = max(np.linalg.eigvals(A), key=abs)
        return float(-fastest.real / abs(fastest))

    share = 1e-4
    for D in (0.002, 0.02):
        damping = fd.effects.TransmissionDamping("elbow", coefficient=D)
        assert sizes.smallest(damping, share) == pytest.approx(min(4e-3, share * 0.002 / ratio(D)), rel=1e-6)
    assert sizes.smallest(fd.effects.ViscousFriction("elbow", side="link", coefficient=0.1), share) == 4e-3


def test_a_damping_that_a_fit_took_to_nothing_has_a_bound() -> None:
    """No ratio of damping to torque is left to compute it from: the share of torque of any effect."""
    none = fd.effects.TransmissionDamping("elbow", coefficient=0.0)
    assert _sizes(1e-3).smallest(none, 0.0) == SMALLEST_TORQUE_SHARE
