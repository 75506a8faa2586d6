"""Coupled axes against equations derived by hand in the coordinates of the joints, and against MuJoCo's tendons.

With A the matrix of the axes, J, K, D and F diagonal in them, and the closed form of the two-link arm in its joints::

    elastic   M a + h = A^T tau_s,   J alpha + F omega = tau - tau_s,   tau_s = K (theta - A q) + D (omega - A v)
    rigid     (M + A^T J A) a + h + A^T F A v = A^T tau
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexdyn as fd
from tests.arms import EXACT
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
A = np.array([[0.5, 0.5], [0.7, -0.4]])
NAMES, JOINTS = ("left", "right"), ("shoulder", "elbow")
AXES = {name: dict(zip(JOINTS, row, strict=True)) for name, row in zip(NAMES, A.tolist(), strict=True)}
J, K, D, F = np.array([[0.1, 0.2], [30.0, 20.0], [0.1, 0.2], [0.3, 0.15]])
TAU = np.array([1.0, 0.5])
ARM = TwoLink(gravity=9.81)
DOWN = [0.0, -9.81, 0.0]


def links(q: Array, v: Array) -> tuple[Array, Array]:
    """M and h in the coordinates of the joints."""
    d11, d22, d12, _ = ARM.inertias(q[1])
    return np.array([[d11, d12], [d12, d22]]), np.array(ARM.bias(q.tolist(), v.tolist()))


def elastic(t: float, x: Array) -> Array:
    """X' of x = [q, theta, v, omega]: q and v of the joints."""
    q, theta, v, omega = np.split(x, 4)
    M, h = links(q, v)
    spring = K * (theta - A @ q) + D * (omega - A @ v)
    return np.concatenate([v, omega, np.linalg.solve(M, A.T @ spring - h), (TAU - spring - F * omega) / J])


def rigid(t: float, x: Array) -> Array:
    """X' of x = [q, v] of the joints."""
    q, v = np.split(x, 2)
    M, h = links(q, v)
    return np.concatenate([v, np.linalg.solve(M + A.T @ np.diag(J) @ A, A.T @ (TAU - F * (A @ v)) - h)])


def model(*effects: fd.effects.Effect, spring: bool, gravity: list[float] = DOWN) -> fd.FlexibleJointModel:
    """The same arm in the coordinates of its drives."""
    numbers = {"rotor_inertia": J, **({"stiffness": K, "damping": D} if spring else {})}
    joints = {name: {key: float(values[k]) for key, values in numbers.items()} for k, name in enumerate(NAMES)}
    robot = fd.load_robot("scara_two_link").with_axes(AXES)
    return fd.FlexibleJointModel(robot, joints, effects, gravity=gravity)


def viscous() -> list[fd.effects.Effect]:
    """F of both motors."""
    return [
        fd.effects.ViscousFriction(name, side="motor", coefficient=float(f)) for name, f in zip(NAMES, F, strict=True)
    ]


@pytest.mark.parametrize("equations", [elastic, rigid])
@pytest.mark.parametrize(
    ("solver", "close"),
    [
        (fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12), 1e-9),
        (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11), 1e-9),
        (fd.solvers.RungeKutta4(step=1e-3), 1e-8),
        (fd.solvers.TimeStepping(step=1e-4), 5e-4),
    ],
)
def test_every_solver_follows_the_hand_derived_equations(
    equations: Callable[[float, Array], Array], solver: fd.solvers.Solver, close: float
) -> None:
    """Links and rotors under constant torques and gravity for a second; the energy closes."""
    spring = equations is elastic
    truth = solve_ivp(equations, (0.0, 1.0), np.zeros(8 if spring else 4), "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    run = fd.simulate(model(*viscous(), spring=spring), TAU, duration=1.0, solver=solver)
    assert run.model.robot.expand(run.q[-1]) == pytest.approx(truth[:2], abs=close)
    assert run.theta[-1] == pytest.approx(truth[2:4] if spring else A @ truth[:2], abs=close)
    assert run.energy.closes


def test_the_inertia_of_rigid_drives_is_a_full_matrix() -> None:
    """In the joints M + A^T J A; in the axes A^-T M A^-1 + J."""
    q = np.array([0.4, -0.7])
    M, _ = links(q, np.zeros(2))
    inverse = np.linalg.inv(A)
    found = fd.LinkSide(model(spring=False)).mass_matrix(A @ q)
    np.testing.assert_allclose(found, inverse.T @ M @ inverse + np.diag(J), rtol=1e-12)


def test_the_unit_matrix_is_the_uncoupled_arm() -> None:
    """To rounding: the mass matrix is projected and not left out."""
    robot = fd.load_robot("scara_two_link")
    drives = {"*": {"rotor_inertia": 0.1, "stiffness": 30.0}, "elbow": {"stiffness": np.inf}}
    friction = [fd.effects.CoulombFriction("elbow", side="motor", level=0.2)]
    plain, coupled = (
        fd.simulate(fd.FlexibleJointModel(arm, drives, friction, gravity=DOWN), TAU, duration=1.0, solver=EXACT)
        for arm in (robot, robot.with_axes({name: {name: 1.0} for name in JOINTS}))
    )
    np.testing.assert_allclose(coupled.q, plain.q, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(coupled.theta, plain.theta, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11)])
def test_dry_friction_of_a_motor_holds_its_axis_and_not_a_joint(solver: fd.solvers.Solver) -> None:
    """The right motor sticks, to the last bit, while both joints turn: one degree of freedom, by hand.

    With p the left axis and e = A^-1 (1, 0): e^T (M + A^T J A) e p'' + e^T h = tau_left - F p'.
    """
    dry = fd.effects.CoulombFriction("right", side="motor", level=50.0)
    still = model(*viscous(), dry, spring=False, gravity=[0.0, 0.0, 0.0])
    run = fd.simulate(still, TAU, duration=1.0, solver=solver, q0=[0.2, 0.1])
    e, start = np.linalg.solve(A, [1.0, 0.0]), np.linalg.solve(A, [0.0, 0.1])
    free = TwoLink()

    def one(t: float, x: Array) -> Array:
        q, v = start + e * x[0], e * x[1]
        d11, d22, d12, _ = free.inertias(q[1])
        M = np.array([[d11, d12], [d12, d22]]) + A.T @ np.diag(J) @ A
        return np.array([x[1], (TAU[0] - F[0] * x[1] - e @ np.array(free.bias(q.tolist(), v.tolist()))) / (e @ M @ e)])

    truth = solve_ivp(one, (0.0, 1.0), [0.2, 0.0], "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert (run.v[:, 1] == 0.0).all()
    assert (run.q[:, 1] == 0.1).all()
    assert run.q[-1, 0] == pytest.approx(truth[0], abs=1e-8)
    assert np.ptp(run.model.robot.expand(run.q), axis=0).min() > 0.1


def test_solvers_agree_on_stick_and_slip_of_the_motors() -> None:
    """Torques that swing, dry friction of both motors, one of them elastic: axes come to rest to the last bit."""
    t = np.linspace(0.0, 2.0, 401)
    swing = fd.Samples(t, np.stack([2.5 * np.sin(4.0 * t), 2.0 * np.cos(3.0 * t)], axis=1), "cubic")
    dry = [fd.effects.CoulombFriction(name, side="motor", level=0.5) for name in NAMES]
    arm = model(*viscous(), *dry, spring=True, gravity=[0.0, 0.0, 0.0]).replace(joints={"left": {"stiffness": np.inf}})
    solvers = (EXACT, fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11), fd.solvers.TimeStepping(step=2e-4))
    exact, stiff, stepped = (fd.simulate(arm, swing, duration=2.0, solver=solver) for solver in solvers)
    for run in (exact, stiff, stepped):
        assert run.energy.closes
        assert ((run.omega == 0.0).mean(axis=0) > 0.02).all()
    assert np.ptp(exact.theta, axis=0).min() > 0.1
    np.testing.assert_allclose(stiff.theta, exact.theta, atol=1e-6)
    np.testing.assert_allclose(stepped.theta, exact.theta, atol=2e-3)


def test_friction_of_a_motor_acts_on_all_joints_that_it_moves() -> None:
    """A second motor on the base, by a belt: F sign(q1' + q2') and f (q1' + q2') act on both joints.

    The motor's angle is q1 + q2, so that its friction has the power F |q1' + q2'| + f (q1' + q2')^2.
    """
    level, coefficient = 0.4, 0.3
    axes = {"five": {"shoulder": 1.0}, "six": {"shoulder": 1.0, "elbow": 1.0}}
    robot = fd.load_robot("scara_two_link").with_axes(axes)
    effects = [
        fd.effects.CoulombFriction("six", side="motor", level=level),
        fd.effects.ViscousFriction("six", side="motor", coefficient=coefficient),
    ]
    bare = fd.FlexibleJointModel(robot, {"six": {"rotor_inertia": 0.05}}, gravity=[0.0, 0.0, 0.0])
    B = np.array([[1.0, 0.0], [1.0, 1.0]])
    q, v = np.array([0.3, 0.5]), np.array([0.8, -1.3])
    start = {"q0": B @ q, "v0": B @ v, "duration": 1e-4, "solver": EXACT}
    before, after = (fd.simulate(bare.replace(effects=each), **start) for each in ([], effects))
    d11, d22, d12, _ = TwoLink().inertias(q[1])
    inertia = np.array([[d11, d12], [d12, d22]]) + 0.05 * np.ones((2, 2))
    change = np.linalg.solve(B, after.v[-1] - before.v[-1]) / 1e-4
    speed = v.sum()
    torque = level * np.sign(speed) + coefficient * speed
    np.testing.assert_allclose(inertia @ change, -torque * np.ones(2), rtol=1e-3)


TENDONS = """<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81" integrator="RK4" timestep="0.0005">
<flag contact="disable"/></option><worldbody>
<body><inertial pos="0 0 0.05" mass="1.5" diaginertia="0.02 0.02 0.01"/><joint name="pitch" type="hinge" axis="0 1 0"/>
<body pos="0 0 0.1"><inertial pos="0.06 0 0.15" mass="0.8" diaginertia="0.006 0.007 0.004"/>
<joint name="roll" type="hinge" axis="0 0 1"/></body></body></worldbody>
<tendon><fixed armature="0.3" damping="0.2"><joint joint="pitch" coef="1"/><joint joint="roll" coef="1"/></fixed>
<fixed armature="0.4" damping="0.1"><joint joint="pitch" coef="1"/><joint joint="roll" coef="-1"/></fixed></tendon>
<actuator><motor tendon="left"/><motor tendon="right"/></actuator></mujoco>""".replace(
    '<fixed armature="0.3"', '<fixed name="left" armature="0.3"'
).replace('<fixed armature="0.4"', '<fixed name="right" armature="0.4"')
WRIST = """<robot name="wrist"><link name="base"/>
<link name="a"><inertial><origin xyz="0 0 0.05"/><mass value="1.5"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><origin xyz="0.06 0 0.15"/><mass value="0.8"/>
<inertia ixx="0.006" iyy="0.007" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pitch" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/></joint>
<joint name="roll" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 0.1"/>
<axis xyz="0 0 1"/></joint></robot>"""


def test_a_differential_wrist_moves_as_mujocos(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Its drives are fixed tendons there, with armature and damping, and the motors pull at them."""
    path = tmp_path_factory.mktemp("wrist") / "wrist.urdf"
    path.write_text(WRIST, encoding="utf-8")
    axes = {"left": {"pitch": 1.0, "roll": 1.0}, "right": {"pitch": 1.0, "roll": -1.0}}
    drives = {"left": {"rotor_inertia": 0.3}, "right": {"rotor_inertia": 0.4}}
    friction = [
        fd.effects.ViscousFriction(name, side="motor", coefficient=c) for name, c in (("left", 0.2), ("right", 0.1))
    ]
    torque = [1.5, -0.8]
    wrist = fd.FlexibleJointModel(fd.load_robot(path).with_axes(axes), drives, friction)
    run = fd.simulate(wrist, torque, duration=1.0, q0=[0.3, 0.1], v0=[0.5, -0.2], solver=EXACT)
    other = mujoco.MjModel.from_xml_string(TENDONS)
    data, B = mujoco.MjData(other), np.array([[1.0, 1.0], [1.0, -1.0]])
    data.qpos[:], data.qvel[:] = np.linalg.solve(B, [0.3, 0.1]), np.linalg.solve(B, [0.5, -0.2])
    data.ctrl[:] = torque
    mujoco.mj_step(other, data, nstep=2000)
    assert np.ptp(run.q, axis=0).min() > 0.2
    assert wrist.robot.expand(run.q[-1]) == pytest.approx(data.qpos, abs=1e-8)
