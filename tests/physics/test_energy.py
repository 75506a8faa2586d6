"""Energy: kept where nothing drives or brakes, and the same by every way of counting."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import BENT, EXACT, state, two_link
from tests.oracles.two_link import TwoLink


def test_a_conservative_arm_keeps_its_energy_over_100_000_steps() -> None:
    """Drift below 1e-9 of the energy in play, over 100,000 Runge-Kutta steps at a small step."""
    arm = TwoLink(stiffness=(30.0, 20.0), gravity=9.81)
    solver = fd.solvers.RungeKutta4(step=2e-4)
    run = fd.simulate(two_link(arm), None, 20.0, solver, rate=50, q0=[-0.5, 0.6], theta0=[-0.4, 0.5])
    assert run.stats["steps"] == 100_000
    energy = run.energy.mechanical
    assert np.abs(energy - energy[0]).max() < 1e-9 * np.ptp(run.energy.kinetic)


def test_energy_is_that_of_the_closed_form() -> None:
    """Kinetic, spring and gravitational energy of every sample, counted a second time."""
    arm = TwoLink(stiffness=(30.0, 20.0), damping=(0.2, 0.1), rotor=(0.2, 0.1), gravity=9.81)
    run = fd.simulate(two_link(arm), [1.0, -0.5], 2.0, EXACT, rate=100, **BENT)
    expected = np.array([arm.energy(x) for x in state(run)])
    np.testing.assert_allclose(run.energy.mechanical, expected, rtol=1e-11)
    assert np.ptp(expected) > 0.1


def test_power_of_motor_and_damper() -> None:
    """The gain is the integral of tau omega - D (omega - v)^2: what the motor supplies less what the damper takes."""
    arm = TwoLink(stiffness=(30.0, 20.0), damping=(0.4, 0.3), gravity=9.81)
    run = fd.simulate(two_link(arm), [1.0, -0.5], 2.0, EXACT, rate=2000, **BENT)
    power = (run.tau * run.omega).sum(axis=1) - (run.omega - run.v) ** 2 @ np.array(arm.damping)
    work = np.concatenate([[0.0], np.cumsum((power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) / 6000.0)])
    np.testing.assert_allclose(run.energy.mechanical[::2] - run.energy.mechanical[0], work, atol=1e-8)


def test_work_of_a_force_at_the_tip() -> None:
    """A constant force does the work F (x - x0), wherever the tip goes."""
    force = np.array([0.5, -0.8, 0.3])
    external = fd.FrameWrench("tool", [*force, 0.0, 0.0, 0.0])
    run = fd.simulate(two_link(TwoLink(stiffness=(30.0, 20.0))), None, 3.0, EXACT, external=external, **BENT)
    tip = run.frame_positions("tool")
    np.testing.assert_allclose(run.energy.mechanical - run.energy.mechanical[0], (tip - tip[0]) @ force, atol=1e-9)


@pytest.mark.parametrize("name", ["panda", "scara", "ur5"])
def test_shipped_arms_without_friction_keep_their_energy(name: str) -> None:
    """Seven joints or a slider, springs loaded by gravity: let go, nothing is gained or lost."""
    model = fd.load_model(name)
    payloads = [effect for effect in model.effects if isinstance(effect, fd.effects.Payload)]
    model = model.replace(effects=payloads, urdf_dynamics="ignore", joints={"*": {"damping": 0.0}})
    run = fd.simulate(model, None, 0.2, fd.solvers.DormandPrince(rtol=1e-11, atol=1e-12), theta0="equilibrium")
    energy = run.energy.mechanical
    assert np.ptp(run.energy.kinetic) > 0.05
    assert np.abs(energy - energy[0]).max() < 1e-8 * np.ptp(run.energy.kinetic)


def test_energy_cannot_be_overwritten() -> None:
    """The ledger of a run is as immutable as the run."""
    energy = fd.simulate(two_link(TwoLink()), None, 0.1).energy
    for part in (energy.kinetic, energy.spring, energy.gravity):
        with pytest.raises(ValueError, match="read-only"):
            part[0] = 1.0
