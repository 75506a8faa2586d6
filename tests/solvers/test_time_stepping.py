"""TimeStepping: stable whatever the springs, of order 1, never a source of energy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import Backlash, Effect, EndStop, PreslidingFriction, SpringHysteresis, ViscousFriction
from flexdyn.simulation.solvers import DormandPrince, TimeStepping
from tests.solvers.arms import Array, coulomb, planar, positions

pytestmark = pytest.mark.filterwarnings("ignore::flexdyn.EnergyWarning")  # what a first-order step damps is its error
MS = TimeStepping(step=1e-3)
EXACT = DormandPrince(rtol=1e-11, atol=1e-13)
BENT: dict[str, Any] = {"q0": [-0.5, 1.0], "theta0": "equilibrium"}


def order(steps: Array, errors: list[float]) -> float:
    """Slope of log error over log step."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.mark.parametrize("damping", [0.0, 10.0, 1e4, 1e7])
@pytest.mark.parametrize("stiffness", [1.0, 1e2, 1e4, 1e6, 1e7, 1e9])
def test_stable_for_any_spring_and_damper(stiffness: float, damping: float) -> None:
    """Ten seconds of swinging at 1 ms: it gains less than 0.5 % of what it can turn into motion."""
    model = planar(stiffness, joints=2, damping=damping, gravity=9.81)
    run = fd.simulate(model, None, 10.0, MS, q0=[-0.5, 1.0])
    energy = run.energy.mechanical
    hanging = fd.simulate(model, None, 1e-3, MS, q0=[-0.5 * math.pi, 0.0]).energy.gravity[0]
    assert (energy - energy[0]).max() < 0.005 * (energy[0] - hanging)
    assert np.abs(run.v).max() > 1.0


@pytest.mark.parametrize("stiffness", [1e6, 1e9])
def test_a_stiff_arm_moves_as_the_rigid_one(stiffness: float) -> None:
    """In the limit of stiff springs the steps follow the rigid arm's motion, to their own order."""
    elastic = planar(stiffness, joints=2, damping=10.0, gravity=9.81)
    rigid = elastic.replace(joints={"*": {"stiffness": math.inf, "damping": 0.0}})
    exact = fd.simulate(rigid, None, 1.0, EXACT, q0=[-0.5, 1.0], rate=100)
    gaps = [
        np.abs(fd.simulate(elastic, None, 1.0, TimeStepping(step=h), **BENT, rate=100).q - exact.q).max()
        for h in (2e-3, 1e-3)
    ]
    assert gaps[1] < 0.05
    assert gaps[1] < 0.6 * gaps[0]


@pytest.mark.parametrize("case", ["smooth", "stick_slip", "backlash", "end_stop", "memory"])
def test_order_one(case: str) -> None:
    """The error falls with the step: slope 1 within 0.1 on a smooth arm and on one that sticks, rattles or bounces."""
    effects: dict[str, list[Effect]] = {
        "smooth": [ViscousFriction("shoulder", side="link", coefficient=0.2)],
        "stick_slip": [*coulomb("link", 0.5, 0.1), *coulomb("motor", 0.4, 0.2)],
        "backlash": [Backlash("shoulder", half_gap=0.02), ViscousFriction("shoulder", side="motor", coefficient=0.5)],
        "end_stop": [EndStop("shoulder", lower=-1.4, upper=-0.6, stiffness=300.0, damping=5.0)],
        "memory": [
            PreslidingFriction("shoulder", side="link", level=0.4, stiffness=200.0, damping=1.0),
            SpringHysteresis("elbow", stiffness=30.0, width=0.01),
        ],
    }
    model = planar(60.0, effects[case], joints=2, damping=0.5, gravity=4.0)
    grid = np.linspace(0.05, 1.0, 20)
    start: dict[str, Any] = {"q0": [-1.0, 0.8], "times": grid}
    exact = positions(fd.simulate(model, [0.8, -0.3], 1.0, EXACT, **start))
    steps: Array = np.logspace(-1.0, -5.0, 5, base=2.0) * 1e-3
    errors = []
    for step in steps:
        run = fd.simulate(model, [0.8, -0.3], 1.0, TimeStepping(step=float(step)), **start)
        errors.append(float(np.sqrt(np.mean((positions(run) - exact) ** 2))))
    assert abs(order(steps, errors) - 1.0) < 0.1


@pytest.mark.parametrize("step", [1e-3, 1e-2])
@pytest.mark.parametrize("stiffness", [5.5, 1e3, 1e6, 1e9])
def test_springs_and_friction_never_give_energy(stiffness: float, step: float) -> None:
    """One joint, wound up and let go, dry, viscous and bristle friction: the energy falls from step to step."""
    effects: list[Effect] = [
        *coulomb("link", 0.02),
        *coulomb("motor", 0.02),
        ViscousFriction("shoulder", side="motor", coefficient=0.01),
    ]
    model = planar(stiffness, effects, damping=0.1)
    run = fd.simulate(model, None, 5.0, TimeStepping(step=step), theta0=[0.3], v0=[0.5], omega0=[-0.5], rate=1.0 / step)
    energy = run.energy.mechanical
    assert (np.diff(energy) <= 1e-12 * energy[:-1]).all()
    assert energy[-1] < 0.9 * energy[0]


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_a_backlash_and_a_stop_never_give_energy(step: float) -> None:
    """What rattles in a gap and bounces off a stop comes back with no more than it brought."""
    gap, stop = (
        Backlash("shoulder", half_gap=0.02),
        EndStop("shoulder", lower=-0.2, upper=0.2, stiffness=500.0, damping=2.0),
    )
    rattling = fd.simulate(planar(300.0, [gap]), None, 10.0, TimeStepping(step=step), omega0=[2.0], v0=[0.0])
    bouncing = fd.simulate(planar(math.inf, [stop]), None, 10.0, TimeStepping(step=step), v0=[2.0])
    for run in (rattling, bouncing):
        assert run.energy.kinetic.max() <= run.energy.kinetic[0] * (1.0 + 1e-9)
        assert np.abs(run.q).max() > 0.2


def test_a_switch_of_the_command_is_met_exactly() -> None:
    """Steps end where the torque jumps: a rigid joint's speed under two held torques is exact."""
    model = planar(math.inf)
    inertia = float(fd.LinkSide(model).mass_matrix(np.zeros(1))[0, 0])
    command = fd.Samples([0.0, 0.12345, 0.3], [1.0, -2.0, -2.0])
    run = fd.simulate(model, command, 0.3, TimeStepping(step=1e-2))
    assert run.v[-1, 0] == pytest.approx((0.12345 - 2.0 * (0.3 - 0.12345)) / inertia, rel=1e-12)


@pytest.mark.parametrize("side", ["link", "motor"])
def test_what_a_rigid_gear_carries_is_told_as_it_slides_and_rests(side: Any) -> None:
    """tau_s = tau_applied - f_motor - J a of the reference solver, at a moving start, sliding and at rest."""
    model = planar(math.inf, coulomb(side, 0.8, 0.3), joints=2)
    torque = fd.Samples([0.0, 0.5, 1.0, 3.0], [[2.0, 0.0], [0.3, -0.1], [0.2, 0.1], [0.2, 0.1]])
    start: dict[str, Any] = {"q0": [0.0, 1.0], "v0": [0.4, -0.6], "times": [0.0, 0.1, 0.3, 0.7, 0.9, 2.9]}
    exact = fd.simulate(model, torque, solver=EXACT, **start)
    stepped = fd.simulate(model, torque, solver=TimeStepping(step=1e-4), **start)
    assert (exact.v[1] != 0.0).all()
    assert (exact.v[-1] == 0.0).any()
    np.testing.assert_allclose(stepped.tau_s, exact.tau_s, atol=2e-3)
