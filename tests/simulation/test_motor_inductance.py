"""A motor whose winding has inductance, in every solver: two exponentials, SciPy, its limit, its energy."""

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
from tests.simulation.test_dc_motor import KT, PER_VOLT, ROD, ROTOR, B, N, R, model, steps

Array = NDArray[np.float64]
L = 0.02
LAG, K, INERTIA = L / R, N * KT, ROTOR + ROD
EXACT = fd.solvers.DormandPrince(rtol=1e-11, atol=1e-12)
SOLVERS: list[tuple[Any, float]] = [
    (EXACT, 1e-9),
    (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-10), 1e-6),
    (fd.solvers.RungeKutta4(step=5e-4), 1e-6),
    (fd.solvers.TimeStepping(step=1e-4), 4e-3),
]
EVERY = pytest.mark.parametrize(("solver", "error"), SOLVERS, ids=lambda each: type(each).__name__)


def wound(folder: Path, effects: Any = (), *, inductance: float = L, motor: Any = None, **more: Any) -> Any:
    """The pendulum of the motor's tests with an inductance."""
    return model(folder, effects, motor={"inductance": inductance} | (motor or {}), **more)


def two_exponentials(t: Array, volts: float, inductance: float = L) -> tuple[Array, Array]:
    """Speed and current after a step from rest: roots of ``L I s^2 + R I s + k^2 = 0``."""
    root = np.sqrt(complex((R * INERTIA) ** 2 - 4.0 * inductance * INERTIA * K * K))
    fast, slow = ((-R * INERTIA - sign * root) / (2.0 * inductance * INERTIA) for sign in (1.0, -1.0))
    top = volts / K
    speed = top * (1.0 + (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (fast - slow))
    rate = top * fast * slow * (np.exp(fast * t) - np.exp(slow * t)) / (fast - slow)
    return speed.real, INERTIA * rate.real / K


@EVERY
@pytest.mark.parametrize("inductance", [L, 0.4], ids=["overdamped", "oscillating"])
def test_step_response(tmp_path: Path, solver: Any, error: float, inductance: float) -> None:
    """Speed and current of an RL motor on a flywheel; real roots, and a pair that rings."""
    assert (4.0 * inductance * INERTIA * K * K < (R * INERTIA) ** 2) == (inductance == L)
    run = fd.simulate(wound(tmp_path, inductance=inductance), steps(6.0), solver=solver, rate=200)
    speed, current = two_exponentials(run.t, 6.0, inductance)
    np.testing.assert_allclose(run.v[:, 0], speed, atol=error * np.abs(speed).max())
    np.testing.assert_allclose(run.electrical.current[:, 0], current, atol=2.0 * error * np.abs(current).max())
    np.testing.assert_allclose(run.tau_applied[:, 0], K * run.electrical.current[:, 0], rtol=1e-12)


@pytest.mark.parametrize(("kind", "coarse", "order"), [("RungeKutta4", 2e-3, 4), ("TimeStepping", 1e-3, 1)])
def test_order_of_convergence(tmp_path: Path, kind: str, coarse: float, order: int) -> None:
    """Half the step, 2^order less error."""
    arm = wound(tmp_path)
    errors = []
    for step in (coarse, coarse / 2.0, coarse / 4.0):
        run = fd.simulate(arm, steps(6.0), solver=getattr(fd.solvers, kind)(step=step), rate=100)
        errors.append(np.abs(run.v[:, 0] - two_exponentials(run.t, 6.0)[0]).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, order, atol=0.25)


def limited_truth(times: Array, volts: list[float], each: float, most: float) -> tuple[Array, Array]:
    """SciPy, phase by phase: free, or the current held at its limit until the voltage would lower it."""

    def free(t: float, x: Array, v: float) -> list[float]:
        return [K * x[1] / INERTIA, (v - R * x[1] - K * x[0]) / L]

    def held(t: float, x: Array, v: float) -> list[float]:
        return [K * x[1] / INERTIA, 0.0]

    def reaches(t: float, x: Array, v: float) -> float:
        return float(most - abs(x[1]))

    def leaves(t: float, x: Array, v: float) -> float:
        return float(np.sign(x[1]) * (v - R * x[1] - K * x[0]))

    reaches.terminal = leaves.terminal = True  # type: ignore[attr-defined]
    reaches.direction = leaves.direction = -1.0  # type: ignore[attr-defined]
    t, x, out, at_limit = 0.0, np.zeros(2), np.empty((len(times), 2)), False
    for k, v in enumerate(volts):
        end = (k + 1) * each
        while t < end:
            at_limit = at_limit and leaves(t, x, v) > 1e-9
            if not at_limit:
                x[1] *= 1.0 - 1e-12
            law, event = (held, leaves) if at_limit else (free, reaches)
            part = solve_ivp(
                law, (t, end), x, "DOP853", events=event, args=(v,), rtol=1e-12, atol=1e-13, dense_output=True
            )
            rows = (times >= t) & (times <= part.t[-1])
            if rows.any():
                out[rows] = part.sol(times[rows]).T
            t, x = float(part.t[-1]), part.y[:, -1]
            at_limit = bool(abs(x[1]) >= most * (1.0 - 1e-9))
            assert len(part.t) > 1
    return out[:, 0], out[:, 1]


@EVERY
def test_the_limit_holds_the_current(tmp_path: Path, solver: Any, error: float) -> None:
    """Up to the limit, along it, off it, and back to the other limit; 30 V asked for are the 12 V there are."""
    arm = wound(tmp_path, motor={"supply": 12.0, "current_limit": 1.5})
    times = np.linspace(0.0, 1.2, 301)[:-1]
    run = fd.simulate(arm, steps(30.0, -30.0, each=0.6), solver=solver, times=times)
    speed, current = limited_truth(times, [12.0, -12.0], 0.6, 1.5)
    np.testing.assert_allclose(run.v[:, 0], speed, atol=3.0 * error * np.abs(speed).max())
    np.testing.assert_allclose(run.electrical.current[:, 0], current, atol=10.0 * error)
    held = np.abs(run.electrical.current[:, 0]) == 1.5
    assert 0.1 < held.mean() < 0.9
    assert np.abs(run.electrical.current).max() == 1.5
    assert np.abs(run.electrical.voltage).max() < 12.0 + 1e-9


@EVERY
def test_on_an_elastic_joint_that_saturates_against_scipy(tmp_path: Path, solver: Any, error: float) -> None:
    """The torque constant is 5 % off and torque is lost at high current: both act on what the winding gives."""
    arm = wound(
        tmp_path,
        [
            fd.effects.TorqueSaturation("swing", scale=2.0),
            fd.effects.TorqueConstantError("swing", gain=0.05),
            fd.effects.ViscousFriction("swing", side="motor", coefficient=0.004),
        ],
        gravity=9.81,
        stiffness=30.0,
        damping=0.05,
    )
    run = fd.simulate(arm, steps(4.0, -6.0, each=0.4), solver=solver, rate=100)

    def rate(t: float, x: Array) -> list[float]:
        q, theta, v, omega, z = x
        spring = 30.0 * (theta - q) + 0.05 * (omega - v)
        asked = PER_VOLT * (4.0 if t < 0.4 else -6.0)
        given = 1.05 * z / (1.0 + abs(1.05 * z) / 2.0)
        link = (spring - 0.49 * 9.81 * 0.1 * math.sin(q)) / ROD
        return [v, omega, link, (given - spring - 0.004 * omega) / ROTOR, (asked - B * omega - z) / LAG]

    first = solve_ivp(rate, (0.0, 0.4), [0.0] * 5, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    then = solve_ivp(rate, (0.4, 0.8), first.y[:, -1], "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    wanted = np.where(run.t < 0.4, first.sol(run.t), then.sol(np.maximum(run.t, 0.4)))
    np.testing.assert_allclose(run.q[:, 0], wanted[0], atol=5.0 * error)
    np.testing.assert_allclose(run.electrical.current[:, 0], wanted[4] / K, atol=20.0 * error)


@pytest.mark.parametrize("solver", [each for each, _ in SOLVERS if not isinstance(each, fd.solvers.RungeKutta4)])
def test_dry_friction_holds_until_the_current_has_grown(tmp_path: Path, solver: Any) -> None:
    """At rest ``i = V/R (1 - exp(-t R/L))``: the rotor breaks away when its torque reaches the level."""
    level = 0.7 * PER_VOLT * 6.0
    arm = wound(tmp_path, [fd.effects.CoulombFriction("swing", side="motor", level=level)])
    run = fd.simulate(arm, steps(6.0, each=0.05), solver=solver, rate=20000)
    breaks_away = -LAG * math.log(1.0 - 0.7)
    assert (run.v[run.t < breaks_away - 2e-4, 0] == 0.0).all()
    assert (run.v[run.t > breaks_away + 3e-4, 0] > 0.0).all()


@EVERY
def test_its_energy(tmp_path: Path, solver: Any, error: float) -> None:
    """1/2 L i^2 is stored; volts times amperes are heat, work and what the winding takes in; the ledger closes."""
    arm = wound(tmp_path, gravity=9.81, motor={"supply": 12.0, "current_limit": 2.0})
    run = fd.simulate(arm, steps(9.0, -12.0, 3.0, each=0.2), solver=solver, rate=20000)
    current = run.electrical.current[:, 0]
    np.testing.assert_allclose(run.energy.magnetic, 0.5 * L * current**2, rtol=1e-9, atol=1e-15)
    assert run.energy.magnetic.max() > 0.01 * run.energy.kinetic.max()
    assert run.energy.closes
    electric = np.trapezoid((run.electrical.power - run.electrical.heat)[:, 0], run.t)
    work = np.trapezoid((run.tau_applied * run.omega)[:, 0], run.t)
    assert electric == pytest.approx(work + run.energy.magnetic[-1], rel=0.02)
    assert run.energy.supplied[-1, 0] == pytest.approx(work + run.energy.magnetic[-1], rel=0.02)


def test_a_small_inductance_is_none(tmp_path: Path) -> None:
    """A step of the voltage decays within L/R, 0.4 us here: `auto` takes Rosenbrock, and says why."""
    small, none = wound(tmp_path, inductance=1e-6), model(tmp_path)
    fast, slow = (fd.simulate(each, steps(6.0, -3.0)) for each in (small, none))
    assert isinstance(fast.solver, fd.solvers.Rosenbrock)
    assert "the fastest rate at the start is 2.5e+06 1/s" in fast.notes[0]
    np.testing.assert_allclose(fast.v, slow.v, atol=2e-5 * np.abs(slow.v).max())
    assert fast.stats["steps"] < 2000


def test_without_inductance_nothing_changes(tmp_path: Path) -> None:
    """Bit for bit, and no state of its own."""
    given, left_out = (fd.simulate(each, steps(6.0)) for each in (wound(tmp_path, inductance=0.0), model(tmp_path)))
    assert given.z.shape[1] == 0
    assert (given.v == left_out.v).all()
    assert not given.energy.magnetic.any()


def test_it_is_read_and_written(tmp_path: Path) -> None:
    """The model file holds it; a negative one is one line."""
    arm = wound(tmp_path)
    fd.save_model(arm, tmp_path / "again.yaml")
    assert "inductance: 0.02" in (tmp_path / "again.yaml").read_text()
    assert fd.load_model(tmp_path / "again.yaml").joints == arm.joints
    with pytest.raises(InputError, match="inductance: it must be finite and at least 0, got -1"):
        wound(tmp_path, inductance=-1.0)


def test_a_motor_that_turns_the_other_way(tmp_path: Path) -> None:
    """Everything is reflected: a negative gear ratio changes the sign of the current and of the volts."""
    there, back = wound(tmp_path, gravity=9.81), wound(tmp_path, gravity=9.81, gear_ratio=-N)
    one, other = fd.simulate(there, steps(6.0, 2.0)), fd.simulate(back, steps(-6.0, -2.0))
    np.testing.assert_allclose(other.q, one.q, atol=1e-12)
    np.testing.assert_allclose(other.electrical.current, -one.electrical.current, atol=1e-12)


def test_analysis_takes_currents_at_once(tmp_path: Path) -> None:
    """Modes, linear models and holding torques are those without inductance: its lag is left out there."""
    with_it, without = wound(tmp_path, gravity=9.81, stiffness=30.0), model(tmp_path, gravity=9.81, stiffness=30.0)
    np.testing.assert_array_equal(fd.linearize(with_it, [0.4]).A, fd.linearize(without, [0.4]).A)
    np.testing.assert_array_equal(fd.linearize(with_it, [0.4]).B, fd.linearize(without, [0.4]).B)
    np.testing.assert_array_equal(fd.modes(with_it, [0.4]).frequencies, fd.modes(without, [0.4]).frequencies)
    assert fd.holding_torques(with_it, [0.4]).upper == fd.holding_torques(without, [0.4]).upper


def test_the_ledger_of_steps_longer_than_the_lag_closes(tmp_path: Path) -> None:
    """Voltages that jump, L/R less than half a step: the current moves within the step, and its energy is counted."""
    arm = wound(tmp_path, inductance=1e-4, motor={"supply": 12.0, "current_limit": 2.0})
    volts = steps(*np.tile([12.0, -3.0, 5.0, -12.0], 8), each=0.02)
    run = fd.simulate(arm, volts, solver=fd.solvers.TimeStepping(step=1e-4))
    assert run.energy.closes
    assert run.energy.magnetic.max() == pytest.approx(0.5 * 1e-4 * 2.0**2)
