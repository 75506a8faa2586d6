"""A joint that the model takes for rigid: motions of an elastic arm that were computed without flexdyn."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.effects import JointElasticity
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, Levels, two_link_recording

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


@pytest.mark.parametrize(
    ("signals", "joints"),
    [
        pytest.param(BOTH, (1,), id="both encoders"),
        pytest.param(MOTOR, (1,), id="motor", marks=pytest.mark.slow),
        pytest.param(BOTH, (0, 1), id="rigid arm, both encoders", marks=pytest.mark.slow),
        pytest.param(LINK, (0, 1), id="rigid arm, link"),
        pytest.param(MOTOR, (0, 1), id="rigid arm, motor"),
    ],
)
def test_an_elasticity_is_named_and_its_stiffness_found(signals: tuple[str, ...], joints: tuple[int, ...]) -> None:
    """Nothing else is, at the joints that have it, and well within its own error."""
    answer = fd.diagnose(taken_for_rigid(*joints), [two_link_recording(Levels(), 1, signals)])
    named = {(each.suspect.effect, each.suspect.joint): each.suspect.parameters for each in answer.findings}
    assert set(named) == {("joint_elasticity", JOINTS[j]) for j in joints}
    for j in joints:
        stiffness = named["joint_elasticity", JOINTS[j]]["stiffness"]
        assert stiffness.value == pytest.approx(ARM.stiffness[j], rel=0.3)
        assert abs(stiffness.value - ARM.stiffness[j]) < 4.0 * stiffness.std


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
