"""Frequency responses against the closed form of two masses and against simulated sines."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.analysis.arms import DAMPER, MASS, ROTOR, SPRING, two_mass
from tests.arms import EXACT, two_link
from tests.oracles.two_link import TwoLink

FREQUENCIES = [0.01, 1.0, 2.847, 3.0, 4.245, 30.0]
"""[Hz]; near the anti-resonance, 2.847, and the resonance, 4.245."""


def test_two_masses(tmp_path: Path) -> None:
    """Theta/tau = (M s^2 + D s + K)/(s^2 (M J s^2 + (M + J)(D s + K))), q/tau = (D s + K)/the same."""
    found = fd.frequency_response(two_mass(tmp_path), FREQUENCIES)
    s = 2j * math.pi * np.array(FREQUENCIES)
    spring = DAMPER * s + SPRING
    bottom = s**2 * (MASS * ROTOR * s**2 + (MASS + ROTOR) * spring)
    assert found.shape == (6, 2, 1)
    np.testing.assert_allclose(found[:, 0, 0], spring / bottom, rtol=1e-8)
    np.testing.assert_allclose(found[:, 1, 0], (MASS * s**2 + spring) / bottom, rtol=1e-8)


def test_zeros_and_poles_are_those_of_the_modes(tmp_path: Path) -> None:
    """Without damping torque to omega vanishes at the anti-resonances and grows without bound at the frequencies."""
    model = two_link(TwoLink(stiffness=(30.0, 20.0), gravity=9.81))
    pose = [-math.pi / 2, 0.4]
    found = fd.modes(model, pose)
    for joint, zeros in zip(model.joint_names, found.anti_resonances, strict=True):
        response = [
            abs(fd.frequency_response(model, f, x=pose, inputs=[joint], outputs=[f"omega.{joint}"])[:, 0, 0])
            for f in (zeros, found.frequencies * 1.000001, [1.1 * zeros[0]])
        ]
        assert response[0].max() < 1e-6 * response[2].max()
        assert response[1].min() > 1e3 * response[2].max()


def test_a_simulated_sine() -> None:
    """Started on the linear steady state, the arm stays on it but for an error of the square of the amplitude."""
    arm = TwoLink(stiffness=(30.0, 20.0), damping=(0.2, 0.1), rotor=(0.2, 0.1), gravity=9.81)
    model, f = two_link(arm), 2.3
    linear = fd.linearize(model, [0.3, 0.8], outputs=("q", "theta", "v", "omega"))
    G = linear.frequency_response([f])[0, :, 0]  # the shoulder's motor moves
    errors = []
    for amplitude in (0.2, 0.1):
        t = np.linspace(0.0, 1.0, 4001)
        tau = np.tile(linear.tau0, (len(t), 1))
        tau[:, 0] += amplitude * np.sin(2.0 * math.pi * f * t)
        x = linear.x0 + amplitude * G.imag
        start: dict[str, Any] = {"q0": x[:2], "theta0": x[2:4], "v0": x[4:6], "omega0": x[6:]}
        run = fd.simulate(model, fd.Samples(t, tau, "cubic"), 1.0, EXACT, rate=100, **start)
        waves = (np.exp(2j * math.pi * f * run.t)[:, None] * G[:4]).imag
        moved = (np.hstack([run.q, run.theta]) - linear.x0[:4]) / amplitude
        errors.append(np.abs(moved - waves).max() / np.abs(G[:4]).max())
    assert errors[0] < 0.05
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_a_command_delay_is_phase_alone(tmp_path: Path) -> None:
    """Dead time T multiplies the response by exp(-2 pi i f T) and leaves A and B as they are."""
    plain = two_mass(tmp_path)
    late = two_mass(
        tmp_path, [{"effect": "command_delay", "delay": 0.004}, {"effect": "command_delay", "delay": 0.001}]
    )
    phase = np.exp(-2j * math.pi * np.array(FREQUENCIES) * 0.005)[:, None, None]
    expected = fd.frequency_response(plain, FREQUENCIES) * phase
    np.testing.assert_allclose(fd.frequency_response(late, FREQUENCIES), expected, rtol=1e-12)
    assert fd.linearize(late).delays.tolist() == [0.005]


def test_zero_frequency() -> None:
    """A hanging arm gives way by its compliance; one that nothing holds has no bound, and says so."""
    arm = TwoLink(stiffness=(30.0, 20.0), gravity=9.81)
    model = two_link(arm)
    pose = [-math.pi / 2, 0.4]
    step = 1e-6
    start = fd.linearize(model, pose).tau0
    moved = fd.equilibrium(model, start + np.array([step, 0.0]), q_guess=pose)
    rest = fd.equilibrium(model, start, q_guess=pose)
    static = fd.frequency_response(model, [0.0], x=pose)[0, :, 0]
    np.testing.assert_allclose(
        static.real, np.concatenate([moved.q - rest.q, moved.theta - rest.theta]) / step, rtol=1e-4
    )
    with pytest.raises(fd.InputError, match=r"^frequencies: the response is infinite, got 0\.0; take"):
        fd.frequency_response(fd.load_model("scara_two_link"), [1.0, 0.0])
    with pytest.raises(fd.InputError, match=r"^frequencies: frequencies in Hz, at least 0, are needed"):
        fd.frequency_response(model, [-1.0])
