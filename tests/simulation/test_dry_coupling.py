"""Dry friction between two motors: closed forms, an independent complementarity solution, exact sticking, energy."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import CoulombFriction, JointCoupling, ViscousFriction
from flexdyn.errors import InputError
from flexdyn.simulation.plant import build_plant
from tests.effects.arms import model_of
from tests.effects.reference import Arm
from tests.simulation.test_plant_jacobian import compare, point_of, slopes

Array = NDArray[np.float64]
WHEEL = """<link name="{0}"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{0}_turn" type="continuous"><parent link="base"/><child link="{0}"/><axis xyz="0 0 1"/></joint>"""
I1, I2, LEVEL, RATIO = 0.02, 0.05, 0.3, -1.7
J1, J2 = 0.01, 0.03
ONE, TWO = "one_turn", "two_turn"
EXACT = fd.solvers.DormandPrince(rtol=1e-11, atol=1e-12)
STICKING = [
    EXACT,
    fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11),
    fd.solvers.TimeStepping(step=1e-4),
]
EVERY = pytest.mark.parametrize("solver", STICKING, ids=lambda each: type(each).__name__)


def wheels(folder: Path, *effects: Any, stiffness: float = np.inf, **settings: Any) -> fd.FlexibleJointModel:
    """Two flywheels that know of each other by effects alone; their motors have J1, J2."""
    text = f'<robot name="wheels"><link name="base"/>{WHEEL.format("one", I1)}{WHEEL.format("two", I2)}</robot>'
    (folder / "wheels.urdf").write_text(text)
    numbers = {"stiffness": stiffness, "damping": 0.02 if np.isfinite(stiffness) else 0.0}
    joints = {ONE: numbers | {"rotor_inertia": J1}, TWO: numbers | {"rotor_inertia": J2}}
    return fd.FlexibleJointModel(fd.load_robot(folder / "wheels.urdf"), joints, effects, **settings)


def rubbing(level: float = LEVEL, ratio: float = RATIO, **more: Any) -> JointCoupling:
    """Between both motors."""
    return JointCoupling(ONE, other=TWO, level=level, ratio=ratio, **more)


def tolerance(solver: Any, exact: float = 1e-7, stepped: float = 3e-3) -> float:
    """Of a solver's speeds."""
    return stepped if isinstance(solver, fd.solvers.TimeStepping) else exact


@EVERY
def test_it_brakes_the_relative_motion_to_an_exact_stop(tmp_path: Path, solver: Any) -> None:
    """``u = omega_1 - r omega_2`` falls by L (1/I + r^2/I) t to 0; momentum r I_1 omega_1 + I_2 omega_2 stays."""
    run = fd.simulate(wheels(tmp_path, rubbing()), None, 0.4, solver=solver, v0=[4.0, 1.0], rate=1000)
    inertia = np.array([I1 + J1, I2 + J2])
    brake = LEVEL * np.array([-1.0, RATIO]) / inertia
    u0 = 4.0 - RATIO * 1.0
    stop = u0 / (LEVEL / inertia[0] + RATIO**2 * LEVEL / inertia[1])
    assert 0.1 < stop < 0.3
    wanted = np.array([4.0, 1.0]) + np.minimum(run.t, stop)[:, None] * brake
    np.testing.assert_allclose(run.v, wanted, atol=tolerance(solver))
    after = run.t > stop + 2e-4
    assert (run.v[after, 0] == RATIO * run.v[after, 1]).all()
    assert (run.v[run.t < stop - 2e-4, 0] != RATIO * run.v[run.t < stop - 2e-4, 1]).all()
    assert run.energy.closes
    lost = run.energy.dissipated[f"joint_coupling.{ONE}.motor"][-1]
    assert lost == pytest.approx(0.5 * LEVEL * u0 * stop, rel=tolerance(solver, 1e-7, 5e-3))


@EVERY
def test_what_sticks_moves_as_one_until_the_torque_is_too_much(tmp_path: Path, solver: Any) -> None:
    """A rising torque on the first wheel: the friction that holds is ``tau I_r/(I_1 + I_r)``, I_r = I_2/r^2."""
    t = np.array([0.0, 1.0])
    push = fd.Samples(t, {ONE: [0.0, 1.0], TWO: [0.0, 0.0]}, "linear")
    run = fd.simulate(wheels(tmp_path, rubbing()), push, 1.0, solver=solver, rate=1000)
    first, second = I1 + J1, (I2 + J2) / RATIO**2
    slips = LEVEL * (first + second) / second
    assert 0.3 < slips < 0.8
    before, after = run.t < slips - 1e-3, run.t > slips + 1e-3
    assert (run.v[before, 0] == RATIO * run.v[before, 1]).all()
    np.testing.assert_allclose(
        run.v[before, 0], 0.5 * run.t[before] ** 2 / (first + second), atol=tolerance(solver, 1e-9)
    )
    slid = run.t[after] - slips
    start = 0.5 * slips**2 / (first + second)
    np.testing.assert_allclose(
        run.v[after, 0], start + (slid * (slips - LEVEL) + 0.5 * slid**2) / first, atol=tolerance(solver, 1e-7, 0.02)
    )
    np.testing.assert_allclose(
        run.v[after, 1], start / RATIO - RATIO * LEVEL * slid / (I2 + J2) * -1.0, atol=tolerance(solver, 1e-7, 0.02)
    )


@EVERY
@pytest.mark.parametrize("own", [0.1, 0.6])
def test_with_friction_of_both_motors_too(tmp_path: Path, solver: Any, own: float) -> None:
    """The first wheel is held by L_1 + min(L, L_2/|r|), three contacts on two velocities: nothing moves before."""
    arm = wheels(
        tmp_path,
        CoulombFriction(ONE, side="motor", level=0.2),
        CoulombFriction(TWO, side="motor", level=own),
        rubbing(),
    )
    breaks = 0.2 + min(LEVEL, own / abs(RATIO))
    push = fd.Samples([0.0, 1.0], {ONE: [0.0, 1.0], TWO: [0.0, 0.0]}, "linear")
    run = fd.simulate(arm, push, 1.0, solver=solver, rate=1000)
    held = run.t < breaks - 1e-3
    assert (run.v[held] == 0.0).all()
    assert (run.q[held] == 0.0).all()
    assert (run.v[run.t > breaks + 1e-3, 0] > 0.0).all()
    goes_along = own / abs(RATIO) < LEVEL
    assert (abs(run.v[-1, 1]) > 0.0) == goes_along
    assert run.energy.closes


def accelerations(inertia: Array, torque: Array, levels: Array, ratio: float) -> Array:
    """From rest: the least of 1/2 a'Ma - tau a + sum of L |u'|, by trying every set of signs and of sticking contacts.

    The principle of Gauss with dry friction: independent of how the core solves its complementarity problem.
    """
    rows = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, -ratio]])
    best, least = np.zeros(2), 0.0
    for signs in itertools.product((-1, 0, 1), repeat=3):
        stuck = rows[[s == 0 for s in signs]]
        _, sizes, V = np.linalg.svd(stuck) if len(stuck) else (None, np.zeros(0), np.eye(2))
        moves = V[int((sizes > 1e-12).sum()) :].T
        if moves.shape[1] == 0:
            continue
        net = torque - (levels * np.array(signs)) @ rows
        a = moves @ np.linalg.solve(moves.T @ inertia @ moves, moves.T @ net)
        value = 0.5 * a @ inertia @ a - torque @ a + levels @ np.abs(rows @ a)
        if value < least:
            best, least = a, value
    return best


@EVERY
def test_accelerations_from_rest_are_those_of_an_independent_solution(tmp_path: Path, solver: Any) -> None:
    """Torques and levels at random, held or not, on rigid joints."""
    rng = np.random.default_rng(3)
    inertia, moved = np.diag([I1 + J1, I2 + J2]), 0
    for _ in range(40):
        torque, levels = rng.normal(0.0, 0.4, 2), rng.uniform(0.05, 0.5, 3)
        ratio = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 2.5))
        arm = wheels(
            tmp_path,
            CoulombFriction(ONE, side="motor", level=levels[0]),
            CoulombFriction(TWO, side="link", level=levels[1]),
            rubbing(float(levels[2]), ratio),
        )
        run = fd.simulate(arm, torque, 0.01, solver=solver)
        wanted = accelerations(inertia, torque, levels, ratio)
        np.testing.assert_allclose(run.v[-1] / 0.01, wanted, atol=1e-6)
        assert ((run.v[-1] == 0.0) == (wanted == 0.0)).all()
        moved += int((wanted != 0.0).any())
    assert 5 < moved < 35


@EVERY
def test_on_elastic_joints_in_an_arm(tmp_path: Path, solver: Any) -> None:
    """Two links, springs, gravity, swinging torques: the rotors stick to each other and slip again; solvers agree."""
    t = np.linspace(0.0, 1.0, 201)
    swing = fd.Samples(t, np.stack([14.0 * np.sin(9.0 * t), 6.0 * np.cos(7.0 * t)], axis=1), "cubic")
    arm = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.2), gravity=9.81)
    dry = JointCoupling("shoulder", other="elbow", level=3.0, ratio=0.8)
    model = model_of(arm, [dry, CoulombFriction("elbow", side="motor", level=0.4)])
    run, truth = (fd.simulate(model, swing, 1.0, solver=each) for each in (solver, EXACT))
    relative = run.omega[:, 0] - 0.8 * run.omega[:, 1]
    assert 0.1 < (relative == 0.0).mean() < 0.9
    assert np.abs(relative[relative != 0.0]).min() > 1e-9
    np.testing.assert_allclose(run.q, truth.q, atol=tolerance(solver, 1e-6, 5e-3))
    assert run.energy.closes


def test_with_full_rotor_coupling_it_sticks_as_well() -> None:
    """The inertia between rotors and links is a full matrix then."""
    arm = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.2), gravity=9.81)
    dry = JointCoupling("shoulder", other="elbow", level=1e3, ratio=2.0)
    for solver in STICKING:
        run = fd.simulate(model_of(arm, [dry], rotor_coupling="full"), [1.0, 2.0], 0.3, solver=solver)
        assert (run.omega[:, 0] == 2.0 * run.omega[:, 1]).all()
        assert np.ptp(run.theta[:, 1]) > 1e-3
        assert run.energy.closes


def test_smoothed_for_runge_kutta(tmp_path: Path) -> None:
    """Refused without a width; with a small one close to the exact motion."""
    arm = wheels(tmp_path, rubbing())
    with pytest.raises(InputError, match="RungeKutta4 takes smooth laws only, and the model has joint_coupling"):
        fd.simulate(arm, None, 0.4, solver=fd.solvers.RungeKutta4(step=1e-3), v0=[4.0, 1.0])
    smooth = fd.solvers.RungeKutta4(step=1e-4, smoothing=0.01)
    run, truth = (fd.simulate(arm, None, 0.4, solver=each, v0=[4.0, 1.0]) for each in (smooth, EXACT))
    np.testing.assert_allclose(run.v, truth.v, atol=5e-3)


SPRINGS = [(300.0, 200.0), (np.inf, 200.0), (300.0, np.inf), (np.inf, np.inf)]


@pytest.mark.parametrize("springs", SPRINGS, ids=str)
def test_its_slopes(springs: tuple[float, float]) -> None:
    """Smoothed, against differences; stuck, both rows move as one."""
    arm = Arm(springs, (0.0, 0.0), (0.1, 0.2))
    model = model_of(arm, [JointCoupling("elbow", other="shoulder", level=0.7, ratio=1.5, coefficient=0.2)])
    compare(model, *point_of(model, 5))
    x, tau = point_of(model, 6)
    n, e = 2, int(model.elastic.sum())
    slots = np.where(model.elastic, n + np.cumsum(model.elastic) - 1, np.arange(n)) + n + e
    held = model_of(arm, [JointCoupling("elbow", other="shoulder", level=1e3, ratio=1.5)])
    x[slots[1]] = 1.5 * x[slots[0]]
    A = slopes(held, x, tau, smoothing=0.0)
    np.testing.assert_allclose(A[slots[1]], 1.5 * A[slots[0]], rtol=1e-12, atol=1e-9)
    assert np.abs(A[slots[0]]).max() > 0.01


def test_levels_add_up_and_the_drag_stays(tmp_path: Path) -> None:
    """Two halves are one whole; the old coefficient acts beside it."""
    whole = wheels(tmp_path, rubbing(coefficient=0.02), ViscousFriction(TWO, side="link", coefficient=0.01))
    halves = wheels(
        tmp_path,
        rubbing(0.5 * LEVEL, coefficient=0.02),
        rubbing(0.5 * LEVEL),
        ViscousFriction(TWO, side="link", coefficient=0.01),
    )
    one, other = (fd.simulate(each, None, 0.4, solver=EXACT, v0=[4.0, 1.0]) for each in (whole, halves))
    np.testing.assert_allclose(one.v, other.v, atol=1e-12)
    plain = fd.simulate(wheels(tmp_path, rubbing()), None, 0.4, solver=EXACT, v0=[4.0, 1.0])
    assert np.abs(one.v - plain.v).max() > 0.01


def test_what_is_refused(tmp_path: Path) -> None:
    """A ratio of 0, a negative level, and a chain of motors: one line each."""
    with pytest.raises(InputError, match=r"joint_coupling.ratio: a ratio other than 0 is needed, got 0"):
        rubbing(ratio=0.0)
    with pytest.raises(InputError, match=r"joint_coupling.level: it must be at least 0"):
        rubbing(-0.1)
    with pytest.raises(InputError, match=r"effects\[1\].level: \w+ has a dry coupling already"):
        wheels(tmp_path, rubbing(), JointCoupling(TWO, other=ONE, level=0.1))


def test_without_a_level_it_is_the_drag_alone(tmp_path: Path) -> None:
    """No contact in the plant."""
    drag = wheels(tmp_path, JointCoupling(ONE, other=TWO, coefficient=0.1))
    assert not build_plant(drag).has_dry_friction
    assert build_plant(wheels(tmp_path, rubbing())).has_dry_friction


def test_modes_are_those_without_dry_friction() -> None:
    """As for any other dry friction: motors that stick to each other would have fewer modes."""
    arm = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.2), gravity=9.81)
    dry = JointCoupling("shoulder", other="elbow", level=3.0, coefficient=0.1)
    rubbing_arm, plain = (model_of(arm, [each]) for each in (dry, dry.replace(level=0.0)))
    np.testing.assert_array_equal(fd.modes(rubbing_arm).frequencies, fd.modes(plain).frequencies)
    np.testing.assert_array_equal(fd.linearize(rubbing_arm).A, fd.linearize(plain).A)
