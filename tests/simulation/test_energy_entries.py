"""Each entry of the energy ledger against an independent computation: trapezoids, Pinocchio, formulas by hand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import flexdyn as fd
from flexdyn.effects import Effect
from flexdyn.simulation.solvers import DormandPrince, Solver, TimeStepping
from tests.effects.arms import model_of
from tests.simulation.test_energy import ARM, RAMPS, START, STEPS, TOGETHER, closed, solver_name
from tests.simulation.test_users_laws import MyDamper, MyFriction


def test_supplied_is_torque_times_speed() -> None:
    """Against the trapezoid of tau_applied omega over 30 001 samples, with effects of the actuator."""
    effects = [e for e in TOGETHER if e.stage == "actuator" and e.name != "command_delay"]
    run = fd.simulate(model_of(ARM, effects), RAMPS, 0.3, rate=100_000, **START)
    power = run.tau_applied * run.omega
    by_hand = np.vstack([np.zeros(2), np.cumsum((power[1:] + power[:-1]) / 2e5, axis=0)])
    np.testing.assert_allclose(run.energy.supplied, by_hand, atol=1e-7)
    assert np.abs(by_hand[-1]).min() > 1e-3


def test_dissipated_is_torque_times_speed() -> None:
    """Viscous losses c u^2 and the damping's D (omega - v)^2 against trapezoids; each effect gets its own."""
    effects = [
        fd.effects.ViscousFriction("elbow", side="motor", coefficient=0.2),
        fd.effects.ViscousFriction("shoulder", side="link", coefficient=0.1),
    ]
    run = fd.simulate(model_of(ARM, effects), RAMPS, 0.3, rate=50_000, **START)
    powers = {
        "viscous_friction.elbow.motor": 0.2 * run.omega[:, 1] ** 2,
        "viscous_friction.shoulder.link": 0.1 * run.v[:, 0] ** 2,
        "damping.shoulder": 0.5 * (run.omega[:, 0] - run.v[:, 0]) ** 2,
        "damping.elbow": 0.3 * (run.omega[:, 1] - run.v[:, 1]) ** 2,
    }
    assert set(run.energy.dissipated) == set(powers)
    for label, power in powers.items():
        by_hand = np.append(0.0, np.cumsum((power[1:] + power[:-1]) / 1e5))
        np.testing.assert_allclose(run.energy.dissipated[label], by_hand, atol=1e-7)


def test_a_constant_force_supplies_force_times_way() -> None:
    """A force that does not change in the world's axes: F . (p(t) - p(0)), whatever way the tip takes."""
    force = np.array([3.0, -5.0, 0.0])
    wrench = fd.FrameWrench("tool", [*force, 0.0, 0.0, 0.0])
    run = fd.simulate(model_of(ARM), RAMPS, 0.3, external=wrench, **START)
    way = run.frame_positions("tool") - run.frame_positions("tool")[0]
    np.testing.assert_allclose(run.energy.external, way @ force, atol=1e-7)


@pytest.mark.parametrize("name", ["panda", "scara"])
def test_kinetic_and_gravity_are_pinocchios(name: str) -> None:
    """Energies of the shipped arms against Pinocchio's on the bare robot with the rotors' 1/2 J omega^2 by hand."""
    shipped = fd.load_model(name)
    model = shipped.replace(effects=[])
    run = fd.simulate(model, None, 0.05, rate=200, v0=0.3 * np.cos(np.arange(model.n)))
    robot, rotors = model.robot.pin_model.copy(), model.resolved().rotor_inertia
    robot.gravity = pin.Motion(np.array(model.gravity), np.zeros(3))
    data = robot.createData()
    for i in range(len(run.t)):
        q = model.robot.expand(run.q[i : i + 1])[0]
        rate = (model.robot.expand(1e3 * run.v[i]) - model.robot.expand(0.0 * run.v[i])) / 1e3
        links = pin.computeKineticEnergy(robot, data, q, rate)
        assert run.energy.kinetic[i] == pytest.approx(links + 0.5 * rotors @ run.omega[i] ** 2, rel=1e-10)
        assert run.energy.gravity[i] == pytest.approx(pin.computePotentialEnergy(robot, data, q), rel=1e-10)


def test_springs_hold_what_their_laws_say() -> None:
    """1/2 K delta^2 + cubic/4 delta^4 + 1/2 k (q - rest)^2 + 1/2 k z^2 of what the transmission and the links hold."""
    effects: list[Effect] = [
        fd.effects.KinematicError("shoulder", amplitude=0.02, harmonic=3.0, phase=0.2),
        fd.effects.Backlash("shoulder", half_gap=0.01),
        fd.effects.HardeningSpring("shoulder", cubic=2e5),
        fd.effects.ParallelSpring("elbow", stiffness=20.0, rest=0.3),
        fd.effects.PreslidingFriction("elbow", side="link", level=1.0, stiffness=500.0),
        fd.effects.SpringHysteresis("elbow", stiffness=1000.0, width=0.002),
    ]
    run = fd.simulate(model_of(ARM, effects), STEPS, 0.3, **START)
    twisted = run.deflection[:, 0] + 0.02 * np.sin(3.0 * run.theta[:, 0] + 0.2)
    twisted = np.sign(twisted) * np.maximum(np.abs(twisted) - 0.01, 0.0)
    expected = 150.0 * twisted**2 + 5e4 * twisted**4 + 100.0 * run.deflection[:, 1] ** 2
    expected += 10.0 * (run.q[:, 1] - 0.3) ** 2 + 250.0 * run.z[:, 0] ** 2 + 500.0 * run.z[:, 1] ** 2
    np.testing.assert_allclose(run.energy.spring, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("solver", [DormandPrince(), TimeStepping(step=1e-4)], ids=solver_name)
def test_a_users_friction_has_an_entry(solver: Solver) -> None:
    """A law in Python stands in the ledger as one of the catalogue does."""
    run = fd.simulate(
        model_of(ARM, [MyFriction("shoulder", side="link", coefficient=0.3)]), RAMPS, 0.3, solver, rate=20_000, **START
    )
    power = 0.3 * run.v[:, 0] ** 2
    by_hand = np.append(0.0, np.cumsum((power[1:] + power[:-1]) / 4e4))
    lost = closed(run).dissipated[f"{MyFriction.name}.shoulder.link"]
    np.testing.assert_allclose(lost, by_hand, atol=1e-6 if isinstance(solver, DormandPrince) else 1e-3)


def test_a_users_damper_is_one_of_the_catalogue() -> None:
    """A Python law of the transmission loses what the same law of the core loses."""
    mine, own = (
        closed(fd.simulate(model_of(ARM, [kind("elbow", coefficient=2.0)]), RAMPS, 0.3, DormandPrince(), **START))
        for kind in (MyDamper, fd.effects.TransmissionDamping)
    )
    lost = own.dissipated["transmission_damping.elbow.transmission"]
    assert lost[-1] > 1e-3
    np.testing.assert_allclose(mine.dissipated[f"{MyDamper.name}.elbow.transmission"], lost, atol=1e-7)
