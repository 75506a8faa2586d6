"""Laws with corners against SciPy, which is stopped and started again at every one of them."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import Backlash, EndStop, TorqueSpeedLimit
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver
from tests.effects.arms import model_of, states
from tests.effects.reference import Arm
from tests.solvers.arms import Array, label
from tests.solvers.hybrid import Switch, integrate

TIMES = np.linspace(0.0, 4.0, 81)
SOLVERS: list[tuple[Solver, float]] = [
    (DormandPrince(rtol=1e-11, atol=1e-13), 1e-8),
    (Rosenbrock(rtol=1e-9, atol=1e-11), 1e-6),
]
GAP, STALL, NO_LOAD = 0.02, 0.8, 2.5
STOP = EndStop("shoulder", lower=-0.3, upper=0.35, stiffness=900.0, damping=4.0)
"""A stop on both sides; its damper jumps in, and lets go before it would pull."""


def corner(place: int, at: float) -> Switch:
    """The state at a place in x passes a value."""
    return lambda t, x: x[place] - at


def edge(sign: int) -> Switch:
    """The deflection of one elastic joint, x = [q, theta, v, omega], passes an edge of the gap."""
    return lambda t, x: x[1] - x[0] - sign * GAP


def pressing(end: float) -> Switch:
    """The force of the stop passes 0 while the link is beyond its end."""

    def force(t: float, x: Any) -> float:
        beyond = x[0] - end
        return float(STOP.stiffness * beyond + STOP.damping * x[2]) if beyond * end > 0.0 else math.copysign(1.0, -end)

    return force


def line(sign: int, tau: float) -> Switch:
    """A torque passes the torque-speed line of a direction."""
    return lambda t, x: sign * tau - STALL * (1.0 - sign * x[3] / NO_LOAD)


def compare(arm: Arm, tau: float, x0: Array, switches: list[Switch], solver: Solver, close: float) -> tuple[int, int]:
    """Hold the states together; how many events each saw."""
    expected, found = integrate(lambda t, x: arm.derivative(t, x, [tau]), x0, TIMES, switches)
    q, theta, v, omega = ([value] for value in x0.tolist())
    run = fd.simulate(model_of(arm), [tau], TIMES[-1], solver, times=TIMES, q0=q, theta0=theta, v0=v, omega0=omega)
    np.testing.assert_allclose(states(run)[:, :2], expected[:, :2], atol=close)
    return run.stats["events"], len(found)


@pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=label)
@pytest.mark.parametrize("tau", [0.0, 0.4])
def test_backlash(solver: Solver, close: float, tau: float) -> None:
    """A rotor rattles in its gap: every touch and every release is an event."""
    arm = Arm((80.0,), (0.0,), (0.2,), effects=(Backlash("shoulder", half_gap=GAP),))
    x0 = np.array([0.0, 0.0, 0.0, 0.9])
    ours, theirs = compare(arm, tau, x0, [edge(1), edge(-1)], solver, close)
    assert ours == theirs >= 8


@pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=label)
def test_backlash_of_two_gaps_and_damping(solver: Solver, close: float) -> None:
    """Half gaps add, and the damper works inside the gap too."""
    gaps = (Backlash("shoulder", half_gap=0.25 * GAP), Backlash("shoulder", half_gap=0.75 * GAP))
    arm = Arm((80.0,), (0.05,), (0.2,), effects=gaps, gravity=3.0)
    x0 = np.array([-1.4, -1.4, 0.0, 0.9])
    ours, theirs = compare(arm, 0.1, x0, [edge(1), edge(-1)], solver, close)
    assert ours == theirs >= 8


@pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=label)
@pytest.mark.parametrize("damping", [0.0, 4.0])
def test_end_stop(solver: Solver, close: float, damping: float) -> None:
    """An arm bounces between two stops that press and never pull."""
    arm = Arm((60.0,), (0.1,), (0.2,), effects=(dataclasses.replace(STOP, damping=damping),))
    switches = [corner(0, STOP.upper), corner(0, STOP.lower)]
    if damping:
        switches += [pressing(STOP.upper), pressing(STOP.lower)]
    ours, _ = compare(arm, 0.3, np.array([0.0, 0.0, 1.5, 1.5]), switches, solver, close)
    assert ours >= 6


@pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=label)
@pytest.mark.parametrize("tau", [0.6, -0.6])
def test_a_motor_reaches_its_torque_speed_line(solver: Solver, close: float, tau: float) -> None:
    """The rotor swings on its spring in and out of the limit; a torque beyond stall begins on the line."""
    limit = TorqueSpeedLimit("shoulder", stall_torque=STALL, no_load_speed=NO_LOAD)
    arm = Arm((80.0,), (0.0,), (0.2,), effects=(limit,))
    lines = [line(1, tau), line(-1, tau), corner(3, NO_LOAD), corner(3, -NO_LOAD)]
    ours, theirs = compare(arm, tau, np.array([0.0, 0.1, 0.0, 0.0]), lines, solver, close)
    assert ours == theirs >= 4


@pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=label)
def test_a_command_that_switches(solver: Solver, close: float) -> None:
    """Torques that jump at odd instants: no step goes across a jump."""
    arm = Arm((80.0,), (0.2,), (0.2,), gravity=9.81)
    at = np.array([0.0, 0.313, math.pi / 3.0, 2.0, 2.000001, 3.7, TIMES[-1]])
    tau = np.array([0.5, -0.8, 1.5, 0.0, -2.0, 0.7, 0.7])
    x, rows = np.array([-1.2, -1.2, 0.0, 0.0]), []
    for begin, end, torque in zip(at[:-1], at[1:], tau[:-1], strict=True):
        inside = TIMES[(begin <= TIMES) & (end > TIMES)]
        grid = np.unique([begin, *inside, end])
        found, _ = integrate(partial(arm.derivative, tau=[torque]), x, grid, [])
        rows += [found[np.isin(grid, inside)]]
        x = found[-1]
    expected = np.vstack([*rows, x])
    run = fd.simulate(model_of(arm), fd.Samples(at, tau), TIMES[-1], solver, times=TIMES, q0=[-1.2])
    np.testing.assert_allclose(states(run)[:, :2], expected[:, :2], atol=close)
