"""Chapter: the closed-form equations against Pinocchio, and flexdyn's integration against SciPy's."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from flexdyn.arrays import Array
from flexdyn.paper import equations as eq
from flexdyn.paper.cases import PAPER_V, PaperCases, smooth_samples, smooth_torque
from flexdyn.paper.chapter import Chapter, Check, prose, stated
from flexdyn.robot import frame_positions
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solvers import DormandPrince

STATES = 1000
SEED = 830


def verification(cases: PaperCases) -> Chapter:
    """Eq. 6-19 at 1,000 random states, and a smooth motion of 5 s integrated twice."""
    run, distance = twice_integrated(cases)
    checks = [*_dynamics(cases), *_kinematics(cases)]
    checks.append(stated("integration", distance))
    text = prose("verification.md", states=STATES)
    return Chapter("The equations", text, tuple(checks), runs={"smooth_torque": run})


def random_states() -> tuple[Array, Array, Array]:
    """Positions, velocities and torques of the links, the same at every call, (states, 2) each."""
    rng = np.random.default_rng(SEED)
    shape = (STATES, 2)
    return rng.uniform(-np.pi, np.pi, shape), rng.uniform(-3.0, 3.0, shape), rng.uniform(-5.0, 5.0, shape)


def largest_relative_error(got: Array, true: Array) -> float:
    """Largest error over the states, relative to the largest entry of each state."""
    axes = tuple(range(1, true.ndim))
    return float((np.abs(got - true).max(axes) / np.abs(true).max(axes)).max())


def twice_integrated(cases: PaperCases) -> tuple[Run, float]:
    """The smooth motion as a run, and its largest distance [rad] from SciPy's integration of eq. 12-15."""
    from scipy.integrate import solve_ivp

    solver = DormandPrince(rtol=1e-11, atol=1e-13)
    run = simulate(cases.smooth_model(PAPER_V), smooth_samples(), 5.0, solver, rate=250.0)
    arm = cases.arm(v=PAPER_V)
    x0 = np.concatenate([run.q[0], run.theta[0], np.zeros(4)])
    solution = solve_ivp(
        lambda t, x: eq.derivative(arm, x, smooth_torque(t)), (0.0, 5.0), x0, "DOP853", run.t, rtol=1e-12, atol=1e-14
    )
    return run, float(np.abs(solution.y[:4].T - np.hstack([run.q, run.theta])).max())


def _dynamics(cases: PaperCases) -> list[Check]:
    """The paper's equations of motion against Pinocchio's."""
    arm, links = cases.arm(), LinkSide(cases.smooth_model())
    q, v, torque = random_states()
    D, c, a = eq.mass_matrix(arm, q), eq.coriolis(arm, q, v), eq.link_acceleration(arm, q, v, torque)
    return [
        stated("mass_matrix", largest_relative_error(links.mass_matrix(q), D), states=STATES),
        stated("coriolis", largest_relative_error(links.bias(q, v), c), states=STATES),
        stated("accelerations", largest_relative_error(links.acceleration(q, v, torque), a), states=STATES),
    ]


def _kinematics(cases: PaperCases) -> list[Check]:
    """The paper's kinematics against Pinocchio's."""
    arm, robot = cases.arm(), cases.model.robot
    q, v, _ = random_states()
    model = robot.pin_model
    data, frame = model.createData(), model.getFrameId(robot.tip)
    jacobians = np.array(
        [pin.computeFrameJacobian(model, data, each, frame, pin.LOCAL_WORLD_ALIGNED)[:2] for each in robot.expand(q)]
    )
    place = np.abs(frame_positions(robot, q)[:, :2] - eq.tip(arm, q)).max()
    measured, given = tip_acceleration(arm, q, v, np.random.default_rng(SEED + 1).uniform(-5.0, 5.0, q.shape))
    return [
        stated("jacobian", largest_relative_error(eq.jacobian(arm, q), jacobians), states=STATES),
        stated("tip_position", place, states=STATES),
        stated("tip_acceleration", largest_relative_error(given, measured), states=STATES),
    ]


def tip_acceleration(arm: eq.Arm, q: Array, v: Array, a: Array) -> tuple[Array, Array]:
    """The tip's acceleration [m/s^2] in two ways: second differences of its position, and J_r q'' + (dJ_r/dt) q'."""
    h = 1e-4
    ahead, here, behind = (eq.tip(arm, q + s * v + 0.5 * s**2 * a) for s in (h, 0.0, -h))
    given = np.einsum("tij,tj->ti", eq.jacobian(arm, q), a) + np.einsum("tij,tj->ti", eq.jacobian_rate(arm, q, v), v)
    return (ahead - 2 * here + behind) / h**2, given
