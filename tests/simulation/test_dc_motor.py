"""A motor under voltage in every solver: closed forms, MuJoCo, SciPy, limits, sticking, and where its power goes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexdyn as fd
from flexdyn.errors import InputError

Array = NDArray[np.float64]
KT, R, N = 0.04, 2.5, 8.0
"""On the motor's side [N m/A, ohm], and the gear."""
ROTOR, ROD = 3e-5 * N * N, 0.49 * 0.1**2
B, PER_VOLT = (N * KT) ** 2 / R, N * KT / R
PENDULUM = """<robot name="pendulum"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.1"/>
<mass value="0.49"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="swing" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
EXACT = fd.solvers.DormandPrince(rtol=1e-11, atol=1e-12)
SOLVERS: list[tuple[Any, float]] = [
    (EXACT, 1e-9),
    (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-10), 1e-6),
    (fd.solvers.RungeKutta4(step=1e-3), 1e-7),
    (fd.solvers.TimeStepping(step=1e-4), 6e-3),
]
EVERY = pytest.mark.parametrize(("solver", "error"), SOLVERS, ids=lambda each: type(each).__name__)


def model(folder: Path, effects: Any = (), *, gravity: float = 0.0, motor: Any = None, **joint: Any) -> Any:
    """A pendulum on a motor under voltage; without gravity a flywheel."""
    (folder / "pendulum.urdf").write_text(PENDULUM)
    numbers = {"torque_constant": KT, "resistance": R} | (motor or {})
    drive = {"gear_ratio": N, "rotor_inertia": 3e-5, "actuator": {"dc_motor": numbers}} | joint
    robot = fd.load_robot(folder / "pendulum.urdf")
    return fd.FlexibleJointModel(robot, {"swing": drive}, effects, gravity=[0.0, 0.0, -gravity])


def steps(*volts: float, each: float = 0.5) -> fd.Recording:
    """Voltages, one after the other."""
    t = each * np.arange(len(volts) + 1)
    return fd.Recording(t, {"voltage.swing": [*volts, volts[-1]]})


@EVERY
def test_step_response(tmp_path: Path, solver: Any, error: float) -> None:
    """``omega = (V/k) (1 - exp(-t/T))``, k = N kt, T = I R/k^2: up, then braked by a short circuit."""
    run = fd.simulate(model(tmp_path), steps(6.0, 0.0), solver=solver, rate=200)
    T, top = (ROTOR + ROD) / B, 6.0 / (N * KT)
    up, down = top * (1.0 - np.exp(-run.t / T)), top * (1.0 - math.exp(-0.5 / T)) * np.exp(-(run.t - 0.5) / T)
    np.testing.assert_allclose(run.v[:, 0], np.where(run.t < 0.5, up, down), atol=error * top)


@EVERY
def test_supply_and_current_limit_cut_it(tmp_path: Path, solver: Any, error: float) -> None:
    """30 V asked for are the 12 V there are; up to the speed where 12 V make 1.5 A the torque is constant."""
    limited = model(tmp_path, motor={"supply": 12.0, "current_limit": 1.5})
    run = fd.simulate(limited, steps(30.0, 30.0), solver=solver, rate=200)
    k, inertia = N * KT, ROTOR + ROD
    knee = (12.0 - 1.5 * R) / k
    reached = knee * inertia / (1.5 * k)
    after = 12.0 / k + (knee - 12.0 / k) * np.exp(-(run.t - reached) * B / inertia)
    wanted = np.where(run.t < reached, 1.5 * k / inertia * run.t, after)
    np.testing.assert_allclose(run.v[:, 0], wanted, atol=error * 12.0 / k)
    middle = run.t < 0.9 * reached
    np.testing.assert_allclose(run.electrical.current[middle, 0], 1.5, rtol=1e-12)
    np.testing.assert_allclose(k * run.electrical.current, run.tau_applied, rtol=1e-12, atol=1e-12)
    assert (run.electrical.voltage[:, 0] < 12.0 + 1e-9).all()


@EVERY
def test_on_an_elastic_joint_with_friction_against_scipy(tmp_path: Path, solver: Any, error: float) -> None:
    """Rotor, spring, pendulum under gravity and a viscous bearing; SciPy at tight tolerance."""
    viscous = fd.effects.ViscousFriction("swing", side="motor", coefficient=0.004)
    arm = model(tmp_path, [viscous], gravity=9.81, stiffness=30.0, damping=0.05)
    run = fd.simulate(arm, steps(4.0, -6.0, each=0.4), solver=solver, rate=100)

    def rate(t: float, x: Array) -> list[float]:
        q, theta, v, omega = x
        spring = 30.0 * (theta - q) + 0.05 * (omega - v)
        tau = PER_VOLT * (4.0 if t < 0.4 else -6.0) - (B + 0.004) * omega
        return [v, omega, (spring - 0.49 * 9.81 * 0.1 * math.sin(q)) / ROD, (tau - spring) / ROTOR]

    first = solve_ivp(rate, (0.0, 0.4), [0.0] * 4, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    then = solve_ivp(rate, (0.4, 0.8), first.y[:, -1], "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    wanted = np.where(run.t < 0.4, first.sol(run.t)[0], then.sol(np.maximum(run.t, 0.4))[0])
    np.testing.assert_allclose(run.q[:, 0], wanted, atol=3.0 * error)


@pytest.mark.parametrize("solver", [solver for solver, _ in SOLVERS if not isinstance(solver, fd.solvers.RungeKutta4)])
def test_too_little_voltage_does_not_move_it(tmp_path: Path, solver: Any) -> None:
    """Dry friction holds up to its level to the last bit; a little more moves it."""
    dry = model(tmp_path, [fd.effects.CoulombFriction("swing", side="motor", level=PER_VOLT * 2.0)])
    run = fd.simulate(dry, steps(1.99, -1.99, 2.01), solver=solver, rate=100)
    held = run.t <= 1.0
    assert (run.v[held, 0] == 0.0).all()
    assert (run.q[held, 0] == 0.0).all()
    assert run.v[-1, 0] > 0.0


def test_mujoco_does_the_same(tmp_path: Path) -> None:
    """A general actuator with affine bias is a motor with back-EMF; the same pendulum, the same volts."""
    mujoco = pytest.importorskip("mujoco")
    xml = f"""<mujoco><option timestep="1e-4" integrator="RK4" gravity="0 0 -9.81"/><worldbody><body>
      <joint name="swing" axis="0 1 0" armature="{ROTOR}"/>
      <inertial pos="0 0 -0.1" mass="0.49" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
      <actuator><general joint="swing" gainprm="{PER_VOLT}" biastype="affine" biasprm="0 0 {-B}"/>
      </actuator></mujoco>"""
    theirs = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(theirs)
    t = np.arange(0.0, 2.0, 0.01)
    volts = 5.0 * np.sin(3.0 * t) + 3.0 * np.sin(11.0 * t)
    seen = []
    for each in volts:
        seen.append(float(data.qpos[0]))
        data.ctrl[0] = each
        mujoco.mj_step(theirs, data, nstep=100)
    ours = fd.simulate(model(tmp_path, gravity=9.81), fd.Recording(t, {"voltage.swing": volts}), solver=EXACT, times=t)
    np.testing.assert_allclose(ours.q[:, 0], seen, atol=1e-6)


def test_power_is_heat_and_work(tmp_path: Path) -> None:
    """Volts times amperes are Joule's heat and what turns the rotor; integrated, what the energy ledger was given."""
    arm = model(tmp_path, gravity=9.81, motor={"supply": 12.0, "current_limit": 2.0})
    run = fd.simulate(arm, steps(9.0, -12.0, 3.0), solver=EXACT, rate=20000)
    e, work = run.electrical, run.tau_applied * run.omega
    np.testing.assert_allclose(e.power, e.heat + work, atol=1e-12)
    np.testing.assert_allclose(e.heat, R * e.current**2)
    got = np.trapezoid((e.power - e.heat)[:, 0], run.t)
    assert got == pytest.approx(run.energy.supplied[-1, 0], rel=1e-3)
    assert run.energy.closes
    assert np.abs(e.current).max() == pytest.approx(2.0)


def test_a_joint_without_motor_has_no_volts(tmp_path: Path) -> None:
    """NaN, and no channel in its recording."""
    bare = model(tmp_path).replace(joints={"swing": {"actuator": None}})
    run = fd.simulate(bare, [0.1], 0.1)
    assert np.isnan(run.electrical.power).all()
    assert "voltage.swing" not in run.to_recording()


def test_a_run_plays_again_from_its_volts(tmp_path: Path) -> None:
    """Its recording holds the volts; duty is the same in units of the supply."""
    arm = model(tmp_path, gravity=9.81, motor={"supply": 12.0})
    run = fd.simulate(arm, steps(5.0, -20.0), rate=100)
    log = run.to_recording()
    assert log["voltage.swing"].min() == pytest.approx(-12.0)
    again = fd.simulate(arm, log, rate=100)
    np.testing.assert_allclose(again.q, run.q, atol=1e-7)
    duty = fd.Recording(log.t, {"duty.swing": log["voltage.swing"] / 12.0})
    np.testing.assert_allclose(fd.simulate(arm, duty, rate=100).q, run.q, atol=1e-7)


def test_a_wrong_number_of_the_motor(tmp_path: Path) -> None:
    """The volts stay what they are: twice the resistance is half the torque at standstill and half the back-EMF."""
    wrong = fd.effects.ParameterError("swing", parameter="resistance", factor=2.0)
    run = fd.simulate(model(tmp_path, [wrong]), steps(6.0), solver=EXACT)
    other = fd.simulate(model(tmp_path, motor={"resistance": 2.0 * R}), steps(6.0), solver=EXACT)
    np.testing.assert_allclose(run.q, other.q, atol=1e-12)
    np.testing.assert_allclose(run.electrical.current, other.electrical.current, atol=1e-10)


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    """A torque is not what such a motor is asked for; a duty needs a supply; a goal needs the firmware."""
    arm = model(tmp_path)
    with pytest.raises(InputError, match=r"voltage.swing: the joint's motor is under voltage; record voltage.swing or"):
        fd.simulate(arm, fd.Recording([0.0, 1.0], {"tau.swing": [0.1, 0.1]}))
    with pytest.raises(InputError, match=r"duty.swing needs the supply; give joints.swing.actuator.dc_motor.supply"):
        fd.simulate(arm, fd.Recording([0.0, 1.0], {"duty.swing": [0.1, 0.1]}))
    supplied = model(tmp_path, motor={"supply": 12.0})
    with pytest.raises(InputError, match=r"goal.swing: a goal needs the servo's firmware"):
        fd.simulate(supplied, fd.Recording([0.0, 1.0], {"goal.swing": [0.1, 0.1], "q.swing": [0.0, 0.0]}))
