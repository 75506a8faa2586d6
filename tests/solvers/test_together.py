"""Several contacts that stick, stop and let go at one instant, and friction that ends in rest."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import Backlash, CoulombFriction, Effect, ViscousFriction
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver, TimeStepping
from tests.effects.reference import Arm
from tests.solvers.arms import coulomb, label, planar, positions, side_by_side

SOLVERS: list[Solver] = [
    DormandPrince(rtol=1e-10, atol=1e-12),
    Rosenbrock(rtol=1e-8, atol=1e-10),
    TimeStepping(step=1e-3),
]

RIGID = Arm((math.inf, math.inf), (0.0, 0.0), (0.1, 0.1))
"""The arm of `planar` without springs, for its mass matrix."""


def comb(robot: fd.Robot, stiffness: float) -> fd.FlexibleJointModel:
    """Every joint with the same drive and the same friction on link and motor."""
    effects: list[Effect] = []
    for name in robot.joint_names:
        effects += [
            CoulombFriction(name, side="link", level=0.3),
            CoulombFriction(name, side="motor", level=0.4),
            ViscousFriction(name, side="link", coefficient=0.05),
        ]
    drive = {"rotor_inertia": 0.1, "stiffness": stiffness, "damping": 0.0 if math.isinf(stiffness) else 0.2}
    return fd.FlexibleJointModel(robot, {"*": drive}, effects, gravity=[0.0, -2.0, 0.0])


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
@pytest.mark.parametrize("stiffness", [math.inf, 60.0])
def test_identical_joints_stick_and_let_go_as_one(tmp_path: Path, solver: Solver, stiffness: float) -> None:
    """Three joints that do not feel each other, all alike: each moves as it would alone, at the same instants."""
    tau = fd.Samples([0.0, 1.0, 2.0, 3.0, 4.0], [2.0, -1.5, 0.0, 2.5, 2.5])
    runs = []
    for count in (3, 1):
        command = fd.Samples(tau.t, np.repeat(tau.values, count, axis=1))
        runs.append(
            fd.simulate(comb(side_by_side(tmp_path, count), stiffness), command, 6.0, solver, q0=[-1.3] * count)
        )
    three, alone = runs
    close = 1e-6 if isinstance(solver, Rosenbrock) else 1e-9
    for x in (three.q, three.theta):
        np.testing.assert_allclose(x - x[:, :1], 0.0, atol=1e-12)
    np.testing.assert_allclose(three.q[:, :1], alone.q, atol=close)
    at_rest = (alone.v == 0.0)[:, 0]
    assert 0.05 < at_rest.mean() < 0.95
    assert ((three.v == 0.0).all(axis=1) == at_rest).mean() > 0.998  # the sample next to an event may differ


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
def test_both_joints_reach_their_levels_at_once_and_leave_together(solver: Solver) -> None:
    """Ramps that reach both levels at t = 1: neither moves before, both move after, as M a = tau - L says."""
    jerk = np.array([1.0, 0.7])
    levels = RIGID.mass_matrix([0.0, 0.0]) @ jerk
    model = planar(math.inf, coulomb("link", *levels), joints=2)
    ramp = fd.Samples([0.0, 2.0], [np.zeros(2), 2.0 * levels], "linear")
    run = fd.simulate(model, ramp, 1.0 + 1e-2, solver)
    assert (run.q[run.t <= 1.0 - 2e-3] == 0.0).all()
    close = 0.3 if isinstance(solver, TimeStepping) else 1e-3
    np.testing.assert_allclose(run.v[-1], 0.5 * jerk * 1e-4, rtol=close)


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
def test_at_its_level_a_joint_may_still_be_held_by_the_other(solver: Solver) -> None:
    """Both are loaded past their levels, but the shoulder's start would throw the elbow back: so the elbow sticks."""
    levels = np.array([3.0, 0.1])
    model = planar(math.inf, coulomb("link", *levels), joints=2)
    M = RIGID.mass_matrix([0.0, 0.0])
    assert np.linalg.solve(M, levels)[1] < 0.0
    ramp = fd.Samples([0.0, 2.0], [np.zeros(2), 2.0 * levels], "linear")
    run = fd.simulate(model, ramp, 1.0 + 1e-2, solver)
    assert run.q[-1, 0] > 0.0
    assert (run.q[:, 1] == 0.0).all()
    close = 0.3 if isinstance(solver, TimeStepping) else 1e-3
    np.testing.assert_allclose(run.v[-1, 0], 0.5 * levels[0] / M[0, 0] * 1e-4, rtol=close)


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
@pytest.mark.parametrize("name", ["ur5", "panda", "scara"])
@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
def test_an_arm_comes_to_rest_in_few_events(name: str, rigid: bool, solver: Solver) -> None:
    """Thrown without gravity, friction on every side: chattering ends in sticking, every joint exactly at rest."""
    model = fd.load_model(name)
    sides: list[Any] = ["link", "motor"]
    prismatic = np.array(model.robot.kinds) == "prismatic"
    levels = np.where(prismatic, 40.0, np.linspace(9.0, 3.0, model.n))
    friction = [
        CoulombFriction(joint, side=side, level=levels[j])
        for j, joint in enumerate(model.joint_names)
        for side in sides
    ]
    changes = {"*": {"stiffness": math.inf}} if rigid else {}
    model = model.replace(effects=friction, gravity=[0.0, 0.0, 0.0], joints=changes)
    v0 = np.where(prismatic, 0.2, 1.0) * (-1.0) ** np.arange(model.n)
    run = fd.simulate(model, None, 3.0, solver, v0=v0, rate=100)
    late = run.t > 2.0
    assert (run.v[late] == 0.0).all()
    rounding = 1e-12 if isinstance(solver, Rosenbrock) else 0.0  # between steps its polynomial rounds
    np.testing.assert_allclose(run.q[late], np.broadcast_to(run.q[-1], run.q[late].shape), rtol=0.0, atol=rounding)
    if not isinstance(solver, TimeStepping):
        assert 2 <= run.stats["events"] < 100 * model.n


def test_a_run_that_time_cannot_resolve_says_so() -> None:
    """A rotor that rattles in its gap 1e15 times a second: an error that names the trouble, and no endless run."""
    gap = [Backlash("shoulder", half_gap=1e-13)]
    model = planar(1e15, gap, rotor=1e-15)
    with pytest.raises(fd.SimulationError, match="infinitely many events in finite time"):
        fd.simulate(model, None, 1.0, DormandPrince(), omega0=[1e3], v0=[0.0])


def test_positions_between_events_are_continuous() -> None:
    """Sampled finely across stops and break-aways of four contacts, no position jumps."""
    effects = [*coulomb("link", 0.4, 0.2), *coulomb("motor", 0.3, 0.2)]
    model = planar(80.0, effects, joints=2, gravity=4.0)
    run = fd.simulate(model, [0.5, -0.3], 3.0, DormandPrince(), q0=[-1.0, 0.8], rate=10_000)
    assert run.stats["events"] > 10
    speed = max(np.abs(run.v).max(), np.abs(run.omega).max())
    assert np.abs(np.diff(positions(run), axis=0)).max() < 1.01e-4 * speed
