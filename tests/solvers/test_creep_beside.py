"""What sticks does not move by one bit while the rest of a stiff arm swings, in any solver."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect, PreslidingFriction
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver, TimeStepping
from tests.solvers.arms import label, planar

SOLVERS: tuple[Solver, ...] = (DormandPrince(), Rosenbrock(), TimeStepping(step=1e-3))


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
@pytest.mark.parametrize("stiffness", [1e4, 1e6])
@pytest.mark.parametrize("rotor", [1e-4, 1e-1])
@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_a_held_rotor_stays_while_links_swing(solver: Solver, stiffness: float, rotor: float, damping: float) -> None:
    """Dry friction and bristles together on a rotor, far above any load: the spring shakes it and it does not creep."""
    effects: list[Effect] = [
        CoulombFriction("shoulder", side="motor", level=1e6),
        PreslidingFriction("shoulder", side="motor", level=2.0, stiffness=1e6, damping=damping),
    ]
    model = planar(stiffness, effects, joints=2, rotor=rotor, damping=1e-3 * stiffness**0.5, gravity=9.81)
    run = fd.simulate(model, None, 0.1, solver, q0=[0.3, -0.7], v0=[0.5, 1.0], omega0=[0.0, 1.0])
    assert np.ptp(run.q[:, 1]) > 1e-3  # the elbow swings
    assert (run.theta[:, 0] == 0.3).all()
    assert (run.omega[:, 0] == 0.0).all()
    assert (run.z == 0.0).all()  # nor do its bristles bend


@pytest.mark.parametrize("solver", SOLVERS, ids=label)
def test_a_held_link_stays_while_its_rotor_swings(solver: Solver) -> None:
    """The other way round: friction on the link holds it, a rotor of tiny inertia swings on the spring."""
    model = planar(1e5, [CoulombFriction("shoulder", side="link", level=1e6)], joints=2, rotor=1e-3, gravity=9.81)
    run = fd.simulate(model, [0.5, 0.2], 0.1, solver, q0=[0.3, -0.7], v0=[0.0, 1.0])
    assert np.ptp(run.theta[:, 0]) > 1e-6
    assert (run.q[:, 0] == 0.3).all()
    assert (run.v[:, 0] == 0.0).all()
