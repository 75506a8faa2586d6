"""Stops and springs on joints that several axes move: they act on the joint, and on the motors through the links.

In the joints, with A of ``p = A q``: ``M a + h = A^T tau_s + T(q, v)``, T the torque of a stop on one joint alone.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.robot.axes import joint_row
from tests.arms import EXACT
from tests.physics.test_axes import AXES, TAU, A, D, F, J, K, links, model, viscous

Array = NDArray[np.float64]
STOP: dict[str, Any] = {"lower": -0.03, "upper": 0.06, "stiffness": 400.0, "damping": 3.0}
SOLVERS = [
    (EXACT, 1e-7),
    (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11), 1e-6),
    (fd.solvers.RungeKutta4(step=2e-4), 1e-6),
    (fd.solvers.TimeStepping(step=5e-5), 2e-3),
]
TIMES = np.linspace(0.0, 1.0, 51)
EVERY = pytest.mark.parametrize(("solver", "close"), SOLVERS, ids=lambda each: type(each).__name__)


def bumper(q: float, v: float) -> Any:
    """Torque of the stop: it presses and does not pull."""
    if q > STOP["upper"]:
        return min(0.0, -(STOP["stiffness"] * (q - STOP["upper"]) + STOP["damping"] * v))
    if q < STOP["lower"]:
        return max(0.0, -(STOP["stiffness"] * (q - STOP["lower"]) + STOP["damping"] * v))
    return 0.0


@cache
def truth(spring: bool) -> Array:
    """Joint positions (TIMES, 2) by SciPy, in small steps past the corners."""

    def rate(t: float, x: Array) -> Array:
        q, v = x[:2], x[-4:-2] if spring else x[2:]
        M, h = links(q, v)
        stop = np.array([0.0, bumper(q[1], v[1])])
        if not spring:
            return np.concatenate([v, np.linalg.solve(M + A.T @ np.diag(J) @ A, A.T @ (TAU - F * (A @ v)) - h + stop)])
        theta, omega = x[2:4], x[6:]
        tau_s = K * (theta - A @ q) + D * (omega - A @ v)
        return np.concatenate([v, omega, np.linalg.solve(M, A.T @ tau_s - h + stop), (TAU - tau_s - F * omega) / J])

    start = np.zeros(8 if spring else 4)
    found = solve_ivp(rate, (0.0, 1.0), start, "DOP853", rtol=1e-10, atol=1e-12, max_step=1e-3, t_eval=TIMES)
    return np.asarray(found.y[:2].T)


@EVERY
@pytest.mark.parametrize("spring", [True, False], ids=["elastic", "rigid"])
def test_a_stop_on_the_elbow(solver: Any, close: float, spring: bool) -> None:
    """The elbow of the arm whose two motors both move both joints hits its bumper and lies in it."""
    arm = model(*viscous(), fd.effects.EndStop("elbow", **STOP), spring=spring)
    times = TIMES
    run = fd.simulate(arm, TAU, 1.0, solver=solver, times=times)
    joints = run.model.robot.expand(run.q)
    wanted = truth(spring)
    assert (wanted[:, 1] > STOP["upper"]).any() or (wanted[:, 1] < STOP["lower"]).any()
    np.testing.assert_allclose(joints, wanted, atol=close)
    assert run.energy.closes
    assert run.energy.dissipated["end_stop.elbow.link"][-1] > 0.0


def test_other_torques_on_a_joint_hold_energy() -> None:
    """A parallel spring and a counterbalance on the elbow: what they hold and the rest is constant without friction."""
    effects = [
        fd.effects.ParallelSpring("elbow", stiffness=20.0, rest=0.3),
        fd.effects.PositionTorque("elbow", cos_1=1.0, sin_1=2.0, cos_2=0.0, sin_2=0.5),
    ]
    arm = model(*effects, spring=False)
    run = fd.simulate(arm, None, 1.0, solver=EXACT)
    assert np.ptp(run.energy.kinetic) > 0.1
    np.testing.assert_allclose(run.energy.mechanical, run.energy.initial, atol=1e-8)
    free = fd.simulate(model(spring=False), None, 1.0, solver=EXACT)
    assert np.abs(run.q - free.q).max() > 0.05


def test_a_pose_held_against_it() -> None:
    """At rest in the bumper the motors carry weight and stop: ``A^T tau = h - T``."""
    arm = model(fd.effects.EndStop("elbow", **STOP), spring=True)
    q = np.array([0.3, 0.1])
    torque = np.array([0.0, bumper(q[1], 0.0)])
    wanted = np.linalg.solve(A.T, links(q, np.zeros(2))[1] - torque)
    held = fd.holding_torques(arm, A @ q)
    np.testing.assert_allclose(np.stack([held.lower, held.upper]), np.stack([wanted, wanted]), rtol=1e-9)


def test_limits_of_the_urdf_stay_with_their_joints() -> None:
    """A run beyond them is told by the joint's name, and they can be made stops."""
    plain = fd.load_robot("scara_two_link")
    limited = replace(plain, lower=np.array([-np.inf, -0.03]), upper=np.array([np.inf, 0.06]))
    robot = limited.with_axes(AXES)
    assert robot.coupled_limits == {"elbow": (-0.03, 0.06)}
    np.testing.assert_allclose(
        np.stack([np.asarray(joint_row(robot, name)) for name in ("shoulder", "elbow")]), np.linalg.inv(A)
    )
    arm = model(*viscous(), spring=False).replace(robot=robot)
    with warnings.catch_warnings(action="ignore"):
        run = fd.simulate(arm, TAU, 1.0, solver=EXACT)
        stopped = fd.simulate(fd.enforce_limits(arm), TAU, 1.0, solver=EXACT)
    elbow = robot.expand(run.q)[:, 1]
    past = max(elbow.max() - 0.06, -0.03 - elbow.min())
    assert {(each.joint, each.kind, each.limit) for each in run.exceeded} == {
        ("elbow", "position", -0.03),
        ("elbow", "position", 0.06),
    }
    assert max(each.by for each in run.exceeded) == pytest.approx(past)
    assert max((each.by for each in stopped.exceeded), default=0.0) < 0.2 * past
    assert [each.joint for each in fd.enforce_limits(arm).effects if isinstance(each, fd.effects.EndStop)] == ["elbow"]


def test_what_does_not_act_on_one_joint_alone_is_refused() -> None:
    """Friction between links of a coupled joint, in a line."""
    problem = (
        "coulomb_friction acts on axes, got 'elbow'; name an axis that moves it, left and right; "
        "parallel_spring, position_torque or end_stop may name the joint"
    )
    with pytest.raises(InputError, match=problem):
        model(fd.effects.CoulombFriction("elbow", side="link", level=1.0), spring=False)


def test_it_is_saved_and_shown(tmp_path: Any) -> None:
    """Written with the joint's name and read back."""
    arm = model(fd.effects.EndStop("elbow", **STOP), spring=False)
    fd.save_model(arm, tmp_path / "arm.yaml")
    assert fd.load_model(tmp_path / "arm.yaml").effects == arm.effects
