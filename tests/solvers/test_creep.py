"""A joint that sticks does not move: not by rounding, not in a minute, however stiff its spring."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import AsymmetricFriction, CoulombFriction, Effect
from flexdyn.simulation.solvers import Solver, TimeStepping
from tests.solvers.arms import NAMES, STICKING, coulomb, label, planar

STIFFNESSES = (5.5, 1e3, 1e5, 1e7)
POSE = (-0.4, -1.2)
"""Both rods below the horizontal: gravity loads both joints, and even soft springs balance it stably [rad]."""


def watched(solver: Solver) -> float:
    """How long [s]: a minute, or 6000 steps of a fixed size, each of which computes from equal states the same."""
    return min(60.0, 6000 * solver.step) if isinstance(solver, TimeStepping) else 60.0


def held(run: fd.Run, sides: tuple[str, ...]) -> None:
    """The sides named have not moved by one bit, and have no velocity; the others rest to their solver's tolerance."""
    for side, x, u in (("link", run.q, run.v), ("motor", run.theta, run.omega)):
        if side in sides:
            assert (x == x[0]).all()
            assert (u == 0.0).all()
        else:
            np.testing.assert_allclose(x, np.broadcast_to(x[0], x.shape), atol=1e-7)


@pytest.mark.parametrize("solver", STICKING, ids=label)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("sides", [("motor",), ("link",), ("link", "motor")], ids=label)
@pytest.mark.parametrize("joints", [1, 2])
def test_an_arm_held_against_its_weight_stays(
    solver: Solver, stiffness: float, sides: tuple[str, ...], joints: int
) -> None:
    """From equilibrium, with 80 % of the dry level as load, every joint creeps by exactly 0.0."""
    bare = planar(stiffness, joints=joints, gravity=9.81)
    weight = np.abs(fd.LinkSide(bare).bias(np.array(POSE[:joints]), np.zeros(joints)))
    effects = [effect for side in sides for effect in coulomb(side, *(weight / 0.8))]
    start: dict[str, Any] = {"q0": POSE[:joints]}
    if "link" not in sides:
        start["theta0"] = "equilibrium"  # the springs carry the weight to the rotors, which hold it
    model = planar(stiffness, effects, joints=joints, gravity=9.81)
    run = fd.simulate(model, None, watched(solver), solver, rate=5, **start)
    held(run, sides)


@pytest.mark.parametrize("solver", STICKING, ids=label)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("side", ["motor", "link"])
@pytest.mark.parametrize("joints", [1, 2])
def test_an_arm_held_against_its_motors_stays(solver: Solver, stiffness: float, side: str, joints: int) -> None:
    """The same under motor torques a millionth below the level."""
    levels = np.array([2.0, 0.7])[:joints]
    tau = (1.0 - 1e-6) * levels * np.array([1.0, -1.0])[:joints]
    q0 = np.zeros(joints)
    start = {} if side == "motor" else {"theta0": q0 + tau / stiffness}  # wound up, the link held
    model = planar(stiffness, coulomb(side, *levels), joints=joints)
    run = fd.simulate(model, tau, watched(solver), solver, q0=q0, rate=5, **start)
    held(run, (side,))


@pytest.mark.parametrize("solver", STICKING, ids=label)
@pytest.mark.parametrize("stiffness", [5.5, 1e4, 1e7, math.inf])
@pytest.mark.parametrize("side", ["motor", "link"])
@pytest.mark.parametrize("direction", [1, -1])
def test_the_level_is_where_it_lets_go(solver: Solver, stiffness: float, side: Any, direction: int) -> None:
    """L(1 - 1e-6) holds to the last bit and L(1 + 1e-6) moves, each way at its own level."""
    levels = {1: 1.7, -1: 0.6}
    friction: list[Effect] = [
        AsymmetricFriction("shoulder", side=side, level_positive=1.2, level_negative=0.1),
        CoulombFriction("shoulder", side=side, level=0.5),
    ]
    model = planar(stiffness, friction)
    for factor, moves in ((1.0 - 1e-6, False), (1.0 + 1e-6, True)):
        tau = direction * levels[direction] * factor
        wound = {"theta0": [tau / stiffness]}
        start: dict[str, Any] = wound if side == "link" and math.isfinite(stiffness) else {}
        run = fd.simulate(model, [tau], 4.0, solver, rate=5, **start)
        x, u = (run.q, run.v) if side == "link" else (run.theta, run.omega)
        if moves:
            assert direction * (x[-1, 0] - x[0, 0]) > 1e-7
        else:
            assert (x == x[0]).all()
            assert (u == 0.0).all()


@pytest.mark.parametrize("solver", STICKING, ids=label)
@pytest.mark.parametrize("sides", [("link", "motor"), ("motor", "link")], ids=label)
def test_on_a_rigid_joint_both_sides_hold_together(solver: Solver, sides: tuple[Any, Any]) -> None:
    """Link and motor intervals add: the joint lets go at the sum of their levels and not before."""
    friction = [
        CoulombFriction("shoulder", side=side, level=level) for side, level in zip(sides, (0.9, 1.6), strict=True)
    ]
    model = planar(math.inf, friction)
    for factor in (1.0 - 1e-6, 1.0 + 1e-6):
        run = fd.simulate(model, [2.5 * factor], 4.0, solver, rate=5)
        if factor < 1.0:
            held(run, ("link", "motor"))
        else:
            assert run.q[-1, 0] > 1e-7


@pytest.mark.parametrize("solver", STICKING, ids=label)
def test_a_joint_that_came_to_rest_stays_at_rest(solver: Solver) -> None:
    """A moving arm that friction stops has, from then on, one position and no velocity."""
    effects = [*coulomb("link", 0.8, 0.5), *coulomb("motor", 0.6, 0.4)]
    model = planar(200.0, effects, joints=2, damping=0.5)
    run = fd.simulate(model, None, 60.0, solver, q0=[0.0, 1.0], v0=[2.0, -3.0], rate=5)
    late = run.t > 40.0
    for x, u in ((run.q, run.v), (run.theta, run.omega)):
        assert (np.abs(x[-1] - x[0]) > 0.05).all()
        assert (x[late] == x[-1]).all()
        assert (u[late] == 0.0).all()
    assert run.joint_names == NAMES
