"""Models with the same numbers share one compiled plant; what differs in anything that moves the arm does not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Payload, ViscousFriction
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solvers import DormandPrince
from tests.arms import BENT, two_link
from tests.oracles.two_link import TwoLink
from tests.simulation.test_users_laws import MyFriction

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
VISCOUS = ViscousFriction("elbow", side="link", coefficient=0.2)


def arm() -> fd.FlexibleJointModel:
    """A two-link arm with friction and a load."""
    return two_link(ARM, [VISCOUS, CoulombFriction("elbow", side="motor", level=0.1), Payload(mass=0.3)])


@pytest.mark.parametrize(
    "changes", [{"initial": {"q": {"elbow": 0.3}}}, {"tolerance": 0.2}, {"name": "other"}], ids=lambda c: next(iter(c))
)
def test_what_does_not_move_the_arm_changes_no_plant(changes: dict[str, Any]) -> None:
    """First state, tolerance and name are no part of the equations of motion."""
    model = arm()
    assert build_plant(model.replace(**changes)) is build_plant(model)


@pytest.mark.parametrize(
    "changes",
    [
        {"joints": {"elbow": {"stiffness": 21.0}}},
        {"joints": {"elbow": {"stiffness": float("inf")}}},
        {"effects": [VISCOUS.replace(coefficient=0.3)]},
        {"gravity": [-1.6, 0.0, 0.0]},
        {"rotor_coupling": "full"},
    ],
    ids=str,
)
def test_what_moves_the_arm_makes_another_plant(changes: dict[str, Any]) -> None:
    """Drives, effects, gravity and rotor coupling; and the run is that of the changed model."""
    model = arm()
    changed = model.replace(**changes)
    assert build_plant(changed) is not build_plant(model)
    pair = fd.simulate_many([model, changed], [0.2, 0.1], 0.2, DormandPrince(), **BENT)
    assert all(isinstance(run, fd.Run) for run in pair)
    assert not np.array_equal(pair[0].q, pair[1].q)


def test_laws_in_python_share_nothing() -> None:
    """A user's law may remember what it was asked, so that every plant calls its own."""
    model = two_link(ARM, [MyFriction("elbow", side="link", coefficient=0.3)])
    assert build_plant(model) is not build_plant(model)


def test_a_command_given_to_many_models_fits_each() -> None:
    """One recording drives an elastic arm and a rigid one: each starts where the recording allows it to."""
    soft, hard = arm(), arm().rigid()
    t = np.array([0.0, 0.1, 0.2])
    channels = {"tau.elbow": np.full(3, 0.3), "q.elbow": np.full(3, 0.2), "theta.elbow": np.full(3, 0.4)}
    recording = fd.Recording(t, channels)
    one, other = fd.simulate_many([soft, hard], recording, 0.2, DormandPrince())
    assert isinstance(one, fd.Run)
    assert isinstance(other, fd.Run)
    elbow = soft.index("elbow")
    assert (one.q[0, elbow], one.theta[0, elbow]) == (0.2, 0.4)
    assert (other.q[0, elbow], other.theta[0, elbow]) == (0.2, 0.2)
