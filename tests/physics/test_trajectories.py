"""Trajectories of a smooth arm under open-loop torque equal an independent integration to 1e-8 rad over 5 s."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import flexdyn as fd
from tests.arms import BENT, EXACT, state, two_link
from tests.oracles.integrate import trajectory
from tests.oracles.two_link import TwoLink

CLOSE = 1e-8
START = [0.0, math.pi / 2, 0.0, math.pi / 2, 0.4, -0.3, 0.4, -0.3]
SMOOTH = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))


def torques(count: int = 26) -> fd.Samples:
    """Random torques over 5 s, unevenly spaced."""
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 5.0, count)
    t[1:-1] += rng.uniform(-0.05, 0.05, count - 2)
    return fd.Samples(t, rng.normal(0.0, 0.4, (count, 2)))


def test_held_torques() -> None:
    """Every sample is held to the next; the state agrees at all of them."""
    command = torques()
    run = fd.simulate(two_link(SMOOTH), command, solver=EXACT, times=command.t, **BENT)

    def f(t: float, x: Sequence[float]) -> list[float]:
        return SMOOTH.derivative(x, command.values[np.searchsorted(command.t, t, side="right") - 1].tolist())

    assert np.abs(state(run) - trajectory(f, START, command.t)).max() < CLOSE
    np.testing.assert_array_equal(run.tau, command.values)


def test_linear_torques() -> None:
    """Torques interpolated linearly bend at the samples and nowhere else."""
    command = torques()
    linear = fd.Samples(command.t, command.values, "linear")
    run = fd.simulate(two_link(SMOOTH), linear, solver=EXACT, times=command.t, **BENT)

    def f(t: float, x: Sequence[float]) -> list[float]:
        return SMOOTH.derivative(x, [float(np.interp(t, command.t, command.values[:, j])) for j in (0, 1)])

    assert np.abs(state(run) - trajectory(f, START, command.t)).max() < CLOSE
    np.testing.assert_allclose(run.tau, command.values, atol=1e-15)


def test_cubic_torques() -> None:
    """A cubic command is the C2 spline through the samples, without stops in between."""
    command = torques()
    cubic = fd.Samples(command.t, command.values, "cubic")
    run = fd.simulate(two_link(SMOOTH), cubic, solver=EXACT, times=command.t, **BENT)
    spline = CubicSpline(command.t, command.values)

    def f(t: float, x: Sequence[float]) -> list[float]:
        return SMOOTH.derivative(x, spline(t).tolist())

    assert np.abs(state(run) - trajectory(f, START, command.t)).max() < CLOSE
    np.testing.assert_allclose(run.tau, command.values, atol=1e-12)


def test_gravity_in_the_plane_of_motion() -> None:
    """A heavy flexible arm that swings freely: the command's end leaves it without torque."""
    arm = TwoLink(stiffness=(60.0, 40.0), damping=(0.3, 0.2), gravity=9.81)
    stops = np.linspace(0.0, 5.0, 11)
    start = [-1.8, 0.4, -1.7, 0.45, 0.2, -0.1, 0.3, 0.0]
    command = fd.Samples([0.0, 0.5, 1.0], [[1.0, -0.5], [2.0, 0.3], [9.0, 9.0]])
    initial: dict[str, Any] = {"q0": start[0:2], "theta0": start[2:4], "v0": start[4:6], "omega0": start[6:8]}
    run = fd.simulate(two_link(arm), command, 5.0, EXACT, times=stops, **initial)

    def f(t: float, x: Sequence[float]) -> list[float]:
        return arm.derivative(x, command.values[int(t / 0.5)].tolist() if t < 1.0 else [0.0, 0.0])

    assert np.abs(state(run) - trajectory(f, start, stops)).max() < CLOSE
    assert (run.tau[2:] == 0.0).all()


def test_force_and_moment_at_the_tip() -> None:
    """The paper's end-of-arm force enters as J^T F, J of eq. 8-11; after its samples end it is gone."""
    t, rng = np.linspace(0.0, 4.0, 9), np.random.default_rng(5)
    wrench = rng.normal(0.0, 0.3, (9, 6))
    external = fd.FrameWrench("tool", fd.Samples(t, wrench, "linear"))
    stops = np.append(t, 5.0)
    run = fd.simulate(two_link(SMOOTH), None, 5.0, EXACT, times=stops, external=external, **BENT)

    def f(t_: float, x: Sequence[float]) -> list[float]:
        fx, fy, mz = (float(np.interp(t_, t, wrench[:, k])) if t_ < 4.0 else 0.0 for k in (0, 1, 5))
        return SMOOTH.derivative(x, [0.0, 0.0], SMOOTH.tip_torque(x[0:2], fx, fy, mz))

    assert np.abs(state(run) - trajectory(f, START, stops)).max() < CLOSE


def test_forces_add_up_and_follow_the_axes_asked_for() -> None:
    """A force that turns with the tool and one that does not, each constant, act together."""
    along, fixed = [0.2, 0.1, 0.0, 0.0, 0.0, 0.05], [-0.1, 0.3, 7.0, 5.0, -3.0, 0.0]
    external = [fd.FrameWrench("tool", along, "frame"), fd.FrameWrench("tool", fixed)]
    stops = np.linspace(0.0, 5.0, 6)
    run = fd.simulate(two_link(SMOOTH), None, 5.0, EXACT, times=stops, external=external, **BENT)

    def f(_: float, x: Sequence[float]) -> list[float]:
        c, s = math.cos(x[0] + x[1]), math.sin(x[0] + x[1])
        fx, fy = c * 0.2 - s * 0.1 - 0.1, s * 0.2 + c * 0.1 + 0.3
        return SMOOTH.derivative(x, [0.0, 0.0], SMOOTH.tip_torque(x[0:2], fx, fy, 0.05))

    assert np.abs(state(run) - trajectory(f, START, stops)).max() < CLOSE


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.RungeKutta4(step=1e-4)])
def test_every_solver_agrees(solver: fd.solvers.Solver) -> None:
    """Both solvers come to one end, sampled between their steps or on them."""
    stops = np.array([0.0, 0.123456, 0.5, 1.0])
    run = fd.simulate(two_link(SMOOTH), [0.3, -0.2], 1.0, solver, times=stops, **BENT)
    expected = trajectory(lambda _, x: SMOOTH.derivative(x, [0.3, -0.2]), START, stops)
    assert np.abs(state(run) - expected).max() < CLOSE
