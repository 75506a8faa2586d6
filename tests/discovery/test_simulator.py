"""The two-link simulator behind the hidden-effect benchmark: physics, corners, sensors, by means of its own."""

from __future__ import annotations

import ast
import dataclasses
from pathlib import Path

import layout as at
import numpy as np
import pytest
from arm_draw import draw_arm
from hidden import Hidden
from hybrid_truth import TwoLinkWithCorners
from layout import Array
from recording import quantised, read
from scipy.integrate import solve_ivp
from two_link_equations import CENTRE, INERTIA, LENGTH, MASS, TIP
from two_link_forces import bend
from two_link_run import Plant, replayed

BENCHMARKS = Path(at.__file__).parents[1]
OUTER = MASS * CENTRE**2 + INERTIA + TIP * LENGTH**2
TURN = MASS * LENGTH * CENTRE + TIP * LENGTH**2
PAPER = np.array([OUTER + MASS * CENTRE**2 + INERTIA + (MASS + TIP) * LENGTH**2, TURN, OUTER, 0.0, 0.0])


def paper_plant(K: float = 5.5, D: float = 0.0, J: float = 0.1) -> Plant:
    """The paper's arm, horizontal, no friction."""
    P = at.neutral()
    P[:, at.K], P[:, at.D], P[:, at.ROTOR] = K, D, J
    return Plant(P, PAPER)


def rotor_alone(omega: float) -> tuple[Plant, Array]:
    """A rotor of 0.5 kg m^2 without spring, and its first state."""
    y = np.zeros(at.STATES)
    y[6] = omega
    return paper_plant(K=0.0, J=0.5), y


def energy(plant: Plant, y: Array) -> Array:
    """Kinetic, elastic and potential energy of every row (samples,) [J]."""
    q, theta, v, omega = y[:, 0:2], y[:, 2:4], y[:, 4:6], y[:, 6:8]
    P, c = plant.P, plant.links[at.TURN] * np.cos(q[:, 1])
    delta = theta - q + P[:, at.ERROR] * np.sin(P[:, at.ERROR_HARMONIC] * theta + P[:, at.ERROR_PHASE])
    delta = np.sign(delta) * np.maximum(np.abs(delta) - P[:, at.HALF_GAP], 0.0)
    kinetic = 0.5 * (plant.links[at.FIXED] + 2 * c) * v[:, 0] ** 2 + 0.5 * plant.links[at.OUTER] * v[:, 1] ** 2
    kinetic += (plant.links[at.OUTER] + c) * v[:, 0] * v[:, 1] + 0.5 * (P[:, at.ROTOR] * omega**2).sum(axis=1)
    elastic = (0.5 * P[:, at.K] * delta**2 + 0.25 * P[:, at.CUBIC] * delta**4).sum(axis=1)
    weight = plant.links[at.WEIGHT_1] * np.sin(q[:, 0]) + plant.links[at.WEIGHT_2] * np.sin(q.sum(axis=1))
    return np.asarray(kinetic + elastic + weight)


def test_energy_is_kept_by_springs_gears_and_gravity() -> None:
    """Hardening springs, kinematic errors, play and gravity make and lose no energy."""
    arm = next(arm for seed in range(20) if (arm := draw_arm(np.random.default_rng(seed))).vertical)
    plant = arm.plant()
    plant.P[:, at.D] = 0.0
    plant.P[:, at.CUBIC], plant.P[:, at.HALF_GAP] = 1e8, 5e-4
    plant.P[:, at.ERROR], plant.P[:, at.ERROR_HARMONIC] = 3e-4, [2.0, 80.0]
    y = np.zeros(at.STATES)
    y[1], y[2:4] = 0.7, [0.004, 0.707]
    total = energy(plant, replayed(plant, y, np.zeros((2000, 2)), step=5e-5).y)
    assert np.ptp(total) < 1e-6 * np.ptp(plant.links[at.WEIGHT_1] * np.array([0.0, 1.0]))


@pytest.mark.parametrize("dry", [False, True])
def test_it_agrees_with_an_event_driven_solution(dry: bool) -> None:
    """With play and dry friction coupled over the links, SciPy between corners that are located moves the same."""
    level, gap = np.array([0.05, 0.03]) * dry, np.array([0.01, 0.02]) * dry
    plant, tau = paper_plant(D=0.05), np.array([0.25, -0.1])
    plant.P[:, at.LINK + at.VISCOUS] = 0.01
    plant.P[:, at.LINK + at.POSITIVE] = plant.P[:, at.LINK + at.NEGATIVE] = level
    plant.P[:, at.HALF_GAP] = gap
    y = np.zeros(at.STATES)
    y[0:4] = [0.0, np.pi / 2, 0.3, 1.3]
    run = replayed(plant, y, np.tile(tau, (2001, 1)))
    pair = np.ones(2)
    oracle = TwoLinkWithCorners(5.5 * pair, 0.05 * pair, 0.1 * pair, 0.01 * pair, level, gap, tau)
    exact, corners = oracle.positions(y[:8], run.t, 5e-3)
    assert corners >= 5 * dry
    np.testing.assert_allclose(run.y[:, :4], exact, atol=2e-8)


def test_a_sliding_body_stops_where_it_should_and_rests_exactly() -> None:
    """Under a friction of L a rotor comes to rest after J omega/L and stays to the last bit."""
    plant, y = rotor_alone(omega=0.3)
    plant.P[0, at.MOTOR + at.POSITIVE] = plant.P[0, at.MOTOR + at.NEGATIVE] = 2.0
    run = replayed(plant, y, np.tile([0.5, 0.0], (200, 1)))
    stop = 0.3 * 0.5 / 1.5
    np.testing.assert_allclose(run.y[-1, 2], 0.5 * 0.3 * stop, rtol=1e-9)
    after = run.t > stop + 1e-9
    assert (run.y[after, 6] == 0.0).all()
    assert (run.y[~after, 6] > 0.0).all()
    assert np.ptp(run.y[after, 2]) == 0.0


def test_a_late_torque_arrives_on_time() -> None:
    """A delay of 2.3 ms shifts a held torque by 2.3 ms, between samples too."""
    plant, y = rotor_alone(omega=0.0)
    plant.P[0, at.DELAY] = 2.3e-3
    run = replayed(plant, y, np.tile([0.5, 0.0], (20, 1)))
    np.testing.assert_allclose(run.y[:, 6], np.maximum(run.t - 2.3e-3, 0.0), atol=1e-15)


def test_bristles_follow_their_differential_equation() -> None:
    """Z over the way alone is the solution of z' = u - abs(u) z/width within one direction."""
    solution = solve_ivp(lambda t, z: 3.0 - 3.0 * z / 0.01, (0.0, 0.005), [-0.004], rtol=1e-12, atol=1e-15)
    assert bend(3.0 * 0.005, -0.004, 0.01) == pytest.approx(solution.y[0, -1], rel=1e-9)


def test_sensors_report_steps_lags_and_errors() -> None:
    """Encoders round down to whole steps; a lag shifts a smooth channel; offset and gain act on it."""
    t = np.arange(2000) * 1e-3
    x = np.sin(5.0 * t)
    steps = quantised(x, 1e-3)
    assert ((x - steps >= 0.0) & (x - steps < 1e-3)).all()
    late = read(x, [Hidden("channel_lag", 0, "sensor", {"delay": 2.5e-3})])
    np.testing.assert_allclose(late[10:], np.sin(5.0 * (t[10:] - 2.5e-3)), atol=1e-9)
    gain = Hidden("sensor_gain", 0, "sensor", {"gain": 0.02})
    both = read(x, [gain, dataclasses.replace(gain, effect="sensor_offset", parameters={"offset": 0.1})])
    np.testing.assert_allclose(both, 1.02 * x + 0.1)


def test_the_truth_does_not_come_from_flexdyn() -> None:
    """No file of the benchmark imports the package that it tests."""
    for file in (BENCHMARKS / "discovery").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.partition(".")[0] == "flexdyn" for name in names), file.name
