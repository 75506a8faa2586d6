"""A joint that the model takes for rigid: motions of an elastic arm that were computed without flexdyn."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.last_fit import no_stiffer_than_seen
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.weights import for_fit
from flexdyn.effects import JointElasticity
from tests.arms import two_link
from tests.diagnose.truths import (
    ARM,
    JOINTS,
    RATE,
    Levels,
    slider_model,
    slider_recording,
    sliding,
    two_link_recording,
)

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


@pytest.mark.parametrize(("stiffness", "kept"), [(1e5, True), (1e9, False)])
def test_a_spring_that_no_row_sees_is_no_stiffer_than_they_could_tell(
    tmp_path: Path, stiffness: float, kept: bool
) -> None:
    """A mass on a rigid joint: a stiffer spring has the compliance that is as large as its standard deviation."""
    t, rotor, levels = np.arange(6000) / RATE, 1.0, Levels(position=1e-6, torque=0.02)
    force = 2.0 * np.sin(2 * np.pi * 0.9 * t) + np.sin(2 * np.pi * 2.3 * t + 1.0)
    x, _ = sliding(force, 1.0 / RATE, 2.5 + rotor, 0.0)
    seen = slider_recording(x, force, RATE, levels, 0)
    units = {"units": {"theta.lift": "m", "tau.lift": "N"}}
    log = fd.Recording(seen.t, {"theta.lift": seen["q.lift"], "tau.lift": seen["tau.lift"]}, meta=units)
    model = slider_model(tmp_path).replace(joints={"lift": {"rotor_inertia": rotor}})
    bare, start = prepared(model, (measured(model, log),))
    here = dataclasses.replace(start, effects=(JointElasticity("lift", stiffness=stiffness),))
    made = fit(here, for_fit(bare, here), steps=1)
    (spread,) = (sigma for (_, name), sigma in made.std().items() if name == "stiffness")
    (found,) = (
        each.stiffness for each in no_stiffer_than_seen(made).hypothesis.effects if isinstance(each, JointElasticity)
    )
    if kept:
        assert found == stiffness
    else:
        assert found == pytest.approx(stiffness**2 / spread)
        assert found < 0.01 * stiffness
