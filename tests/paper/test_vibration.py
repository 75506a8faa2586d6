"""The measures of vibration on motions whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexdyn.paper import equations as eq
from flexdyn.paper.cases import (
    PULSE,
    SMOOTH_AMPLITUDE,
    SMOOTH_END,
    TORQUE_END,
    PaperCases,
    smooth_samples,
    smooth_torque,
)
from flexdyn.paper.vibration import amplitude, decay_rate, paper_modes, residual, ringing_after
from flexdyn.simulation.simulate import simulate


def test_decay_rate_of_an_exponential() -> None:
    """An exponential gives its own rate."""
    t = np.linspace(1.0, 4.0, 50)
    assert decay_rate(t, 0.2 * np.exp(-0.37 * t)) == pytest.approx(0.37, rel=1e-12)


@pytest.mark.parametrize("q2", [0.0, 0.9, np.pi / 2, 2.5])
def test_undamped_modes_solve_the_symmetric_eigenproblem(arm: eq.Arm, q2: float) -> None:
    """K phi = w^2 M phi of links and rotors together: two motions of the arm as a whole, two vibrations."""
    M = scipy.linalg.block_diag(eq.mass_matrix(arm, np.array([0.0, q2])), arm.J * np.eye(2))
    K = arm.K * np.block([[np.eye(2), -np.eye(2)], [-np.eye(2), np.eye(2)]])
    squares = scipy.linalg.eigh(K, M, eigvals_only=True)
    found = paper_modes(replace(arm, v=0.0), q2)
    np.testing.assert_allclose([2 * np.pi * mode.frequency for mode in found], np.sqrt(squares[2:]), rtol=1e-9)
    assert max(abs(mode.rate) for mode in found) < 1e-9


def test_small_damping_by_rayleigh(arm: eq.Arm) -> None:
    """To first order a mode decays by half its damping power over twice its kinetic energy."""
    small = replace(arm, v=1e-4)
    for mode, damped in zip(paper_modes(replace(arm, v=0.0), 1.0), paper_modes(small, 1.0), strict=True):
        links, rotors = mode.shape[:2].real, mode.shape[2:4].real
        mass = links @ eq.mass_matrix(arm, np.array([0.0, 1.0])) @ links + arm.J * rotors @ rotors
        assert damped.rate == pytest.approx(small.v * links @ links / (2 * mass), rel=1e-3)
        assert damped.decrement == pytest.approx(2 * np.pi * damped.rate / damped.eigenvalue.imag, rel=1e-12)


def test_amplitude_is_constant_without_friction(cases: PaperCases) -> None:
    """Two beating modes of small size and no friction: the amplitude does not move while the deflections do."""
    run = simulate(cases.smooth_model(), duration=8.0, theta0=[1e-4, np.pi / 2 - 2e-4], rate=100.0)
    size = amplitude(cases.arm(), run)
    assert size[0] == pytest.approx(np.hypot(1e-4, 2e-4), rel=1e-9)
    assert np.ptp(size) < 1e-3 * size[0]
    assert np.abs(run.deflection[:, 0]).min() < 0.1 * size[0]


def test_ringing_sees_oscillation_and_not_coasting(cases: PaperCases) -> None:
    """A sine of 1.2 Hz laid on the rigid arm's smooth motion is measured; the motion itself hardly counts."""
    run = cases.driven["rigid"]
    sine = np.outer(np.sin(2 * np.pi * 1.2 * run.t), [0.02, 0.0])
    assert ringing_after(replace(run, q=run.q + sine)) == pytest.approx(0.02 / np.sqrt(2), rel=0.06)
    assert ringing_after(run) < 1e-6


def test_residual_of_a_known_decay(cases: PaperCases) -> None:
    """A deflection that decays as exp(-0.1 t) is left at e^-1 of itself after ten seconds."""
    run = cases.driven["flexible"]
    decay = np.exp(-0.1 * run.t)[:, None] * np.array([0.1, 0.0])
    still = replace(run, theta=run.q + decay, omega=run.v.copy())
    found = residual(cases.arm(), still)
    assert found.rate == pytest.approx(0.1, rel=1e-9)
    assert found.left == pytest.approx(np.exp(-1.0), rel=1e-3)


def test_smooth_torque_starts_and_ends_smoothly() -> None:
    """Its peak is as said, it has three zero derivatives at both ends, no net impulse, and the spline follows it."""
    assert smooth_torque(np.linspace(0, SMOOTH_END, 9001)).max() == pytest.approx(SMOOTH_AMPLITUDE, rel=1e-6)
    h = 1e-3
    for end in (0.0, SMOOTH_END - h):
        assert np.abs(smooth_torque(np.array([end, end + h]))).max() < SMOOTH_AMPLITUDE * 100 * h**3
    samples = smooth_samples()
    assert abs(samples.values[:, 0].sum()) < 1e-10
    breaks, coefficients, _ = samples.pieces(samples.values)
    middle = (coefficients * (0.5 * np.diff(breaks)[0]) ** np.arange(4)[None, :, None]).sum(1)
    np.testing.assert_allclose(middle, smooth_torque(breaks[:-1] + 0.5 * np.diff(breaks)), atol=1e-9)


def test_bang_bang_is_the_torque_said(cases: PaperCases) -> None:
    """Full torque, full braking, nothing: the same at both joints, within the stall torque."""
    run = cases.driven["flexible"]
    for at, sign in ((0.5 * PULSE, 1.0), (1.5 * PULSE, -1.0), (TORQUE_END + 1.0, 0.0)):
        np.testing.assert_allclose(run.tau[np.searchsorted(run.t, at)], [0.6 * sign] * 2)
    assert np.abs(run.tau).max() < cases.limit.stall_torque
