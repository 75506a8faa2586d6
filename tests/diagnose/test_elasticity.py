"""A joint that the model takes for rigid: motions of an elastic arm that were computed without flexdyn."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose import columns
from flexdyn.diagnose.candidates import softened
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.filters import Filters
from flexdyn.diagnose.measured import measured
from flexdyn.diagnose.screen import Screen, extended
from flexdyn.diagnose.workspace import workspace
from flexdyn.effects import JointElasticity
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording

BOTH, LINK, MOTOR = ("q", "theta"), ("q",), ("theta",)
SIGNALS = pytest.mark.parametrize("signals", [BOTH, LINK, MOTOR], ids=["both encoders", "link", "motor"])


def taken_for_rigid(*joints: int) -> fd.FlexibleJointModel:
    """The arm as someone wrote it down who knew of no elasticity in these joints."""
    shoulder, elbow = (math.inf if j in joints else K for j, K in enumerate(ARM.stiffness))
    return two_link(dataclasses.replace(ARM, stiffness=(shoulder, elbow)))


@SIGNALS
def test_the_column_of_a_compliance_is_the_slope_of_the_residual(signals: tuple[str, ...]) -> None:
    """The residual of a nearly rigid joint less that of the rigid one, whichever encoders there are."""
    data = measured(taken_for_rigid(1), two_link_recording(Levels(1e-9, 1e-9), 0, signals))
    at = Equations(taken_for_rigid(1), (data,), Filters.of_rate(data.dt))
    nearly = at.model.replace(effects=[*at.model.effects, JointElasticity("elbow", stiffness=1e7)])
    change = at.of(nearly).residual - at.residual
    column = columns.of_effect(at, JointElasticity("elbow", stiffness=1e7))
    assert np.linalg.norm(column - change) < 0.03 * np.linalg.norm(change)


@SIGNALS
@pytest.mark.parametrize("joints", [(1,), (0, 1)], ids=["one of two", "an arm taken for rigid"])
def test_an_elasticity_is_proposed_first_and_its_stiffness_found(
    signals: tuple[str, ...], joints: tuple[int, ...]
) -> None:
    """Before any other effect of the catalogue, at the joint that has it, and well within its own error."""
    model = taken_for_rigid(*joints)
    space, start, _ = workspace(model, (measured(model, two_link_recording(Levels(), 1, signals)),))
    made = fit(start, space)
    best = Screen(space).ranked(made, 1.0)[0]
    assert best.proposal is not None
    assert best.proposal.place["effect"] == "joint_elasticity"
    after = extended(made, best)
    assert after is not None
    if len(joints) == 1:
        found = softened(after, space)
        (value,), (std,) = found.hypothesis.effects[-1].values, found.std().values()
        assert value == pytest.approx(ARM.stiffness[1], rel=0.2)
        assert abs(value - ARM.stiffness[1]) < 4.0 * std


def test_a_rigid_joint_with_both_encoders_says_that_they_agree() -> None:
    """Beside its torques, theta - q is an equation: an offset shows in it as it is, and nowhere else."""
    model = taken_for_rigid(0, 1)
    true = two_link_recording(Levels(1e-9, 1e-9), 0, LINK)
    left = []
    for offset in (0.0, 1e-3):
        rotors = {"theta.shoulder": true["q.shoulder"], "theta.elbow": true["q.elbow"] + offset}
        data = measured(model, fd.Recording(true.t, dict(true.channels) | rotors))
        at = Equations(model, (data,), Filters.of_rate(data.dt))
        assert at.kinds == ((0, "total"), (0, "transmission"), (1, "total"), (1, "transmission"))
        left.append(at.residual.reshape(-1, 4))
    np.testing.assert_allclose(left[1][:, [1, 3]] - [0.0, 1e-3], 0.0, atol=1e-12)
    np.testing.assert_allclose(left[1][:, [0, 2]], left[0][:, [0, 2]], atol=1e-6)
