"""Which joints of a resting arm break away, and how they leave: against all modes tried one by one.

At rest every joint with dry friction on its link slides forward, slides backward or sticks; only one choice out of 3^n
contradicts neither its own accelerations nor its own friction torques, because M(q) is positive definite.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import flexdyn as fd
from flexdyn.effects import AsymmetricFriction
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver, TimeStepping
from tests.solvers.arms import Array, label

INSTANT = 1e-7
"""How long the arm is watched [s]: its velocities are accelerations times this."""
SOLVERS: list[Solver] = [DormandPrince(), Rosenbrock(), TimeStepping(step=INSTANT)]


def all_modes(M: Array, drive: Array, up: Array, down: Array) -> tuple[Array, Array]:
    """Motions (n,) in {-1, 0, 1} and accelerations (n,) of M a + friction = drive, by trying every motion."""
    n, good = len(drive), []
    for modes in itertools.product((-1, 0, 1), repeat=n):
        motion = np.array(modes)
        free = motion != 0
        friction, a = np.where(motion > 0, up, -down), np.zeros(n)
        if free.any():
            a[free] = np.linalg.solve(M[np.ix_(free, free)], (drive - friction)[free])
        reaction = drive - M @ a
        if (motion * a >= 0).all() and (free | ((reaction <= up) & (reaction >= -down))).all():
            good.append((motion, a))
    assert len(good) == 1
    return good[0]


def model_and_start(name: str, rng: Any, rigid: bool) -> tuple[fd.FlexibleJointModel, dict[str, Any], Array]:
    """A shipped arm with random friction on its links, at rest at a random pose, its drive torques about the levels."""
    model = fd.load_model(name)
    up, down = rng.uniform(0.5, 3.0, (2, model.n))
    friction = [
        AsymmetricFriction(joint, side="link", level_positive=up[j], level_negative=down[j])
        for j, joint in enumerate(model.joint_names)
    ]
    joints = {joint: {"stiffness": math.inf} if rigid else model.joints[joint] for joint in model.joint_names}
    model = model.replace(effects=friction, joints=joints)
    drive = rng.uniform(-2.0, 2.0, model.n) * np.where(rng.random(model.n) < 0.5, up, down)
    q = rng.uniform(-2.0, 2.0, model.n)
    return model, {"q0": q}, drive


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
@pytest.mark.parametrize("name", ["scara", "ur5", "panda"])
def test_the_joints_that_move_are_the_only_choice(name: str, rigid: bool, solver: Solver) -> None:
    """Random poses and torques: the same joints move, the same way, as fast as the one consistent mode says."""
    rng = np.random.default_rng(5)
    moved = []
    for _ in range(6):
        model, start, drive = model_and_start(name, rng, rigid)
        links: Any = model.robot.pin_model.copy()
        links.gravity.linear = np.array(model.gravity)
        data = links.createData()
        pin.crba(links, data, start["q0"])
        M = np.triu(data.M) + np.triu(data.M, 1).T + np.diag(np.where(model.elastic, 0.0, model.rotor_inertia))
        tau = drive + pin.nonLinearEffects(links, data, start["q0"], np.zeros(model.n))
        if not rigid:  # the springs drive the links, the motors balance the springs
            start["theta0"] = start["q0"] + tau / model.stiffness
        up, down = (np.array([getattr(e, f"level_{way}") for e in model.effects]) for way in ("positive", "negative"))
        motion, a = all_modes(M, drive, up, down)
        run = fd.simulate(model, tau, INSTANT, solver, times=[INSTANT], **start)
        assert (np.sign(run.v[0]) == motion).all()
        np.testing.assert_allclose(run.v[0] / INSTANT, a, atol=1e-4 * np.abs(a).max() + 1e-9)
        moved.append(np.abs(motion))
    assert 0.0 < np.mean(moved) < 1.0


def test_the_arm_at_all_its_levels_at_once() -> None:
    """Every joint exactly loaded to its level: all hold, none moves by a bit."""
    model = fd.load_model("panda")
    levels = np.linspace(0.5, 2.0, model.n)
    friction = [
        AsymmetricFriction(joint, side="link", level_positive=level, level_negative=level)
        for joint, level in zip(model.joint_names, levels, strict=True)
    ]
    rigid = model.replace(effects=friction, joints={"*": {"stiffness": math.inf}}, gravity=[0.0, 0.0, 0.0])
    run = fd.simulate(rigid, levels * (-1.0) ** np.arange(model.n), 1.0, DormandPrince(), rate=10)
    assert (run.q == run.q[0]).all()
    assert (run.v == 0.0).all()
