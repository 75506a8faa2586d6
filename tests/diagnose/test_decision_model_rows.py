"""Rows of the test data that a corrected model with made-up positions still shows."""

from __future__ import annotations

import dataclasses

import numpy as np

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.model_rows import rows_of_models
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import recorded_noise
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording


def _one_joint_rests() -> fd.Recording:
    """Motor encoders and torques; the elbow stands still."""
    whole = two_link_recording(Levels(), 0)
    kept = {name: x.copy() for name, x in whole.channels.items() if name[:2] in ("th", "ta")}
    kept["theta.elbow"] = kept["theta.elbow"][0] + 1e-5 * np.random.default_rng(0).standard_normal(len(whole.t))
    return fd.Recording(whole.t, kept)


def test_a_joint_at_rest_hides_its_own_rows() -> None:
    """And none of the joint that moves, although the position of the resting link is made up."""
    model = two_link(ARM)
    data = measured(model, _one_joint_rests())
    at, noise = Equations(model, (data,), Filters.of_rate(data.dt), quasi_static=True), recorded_noise((data,))
    assert at.computed.all()
    full, alone = (sign_mask(at, noise, alone=each).reshape(-1, 2) for each in (False, True))
    assert np.array_equal(full, alone)
    assert sign_mask(dataclasses.replace(at, quasi_static=False), noise).all()
    assert alone[:, 1].all()
    assert not alone[:, 0].all()


def test_torque_errors_are_known_where_a_joint_rests() -> None:
    """The equation of the joint that moves is judged by its own standstill."""
    model = two_link(ARM)
    data = (measured(model, _one_joint_rests()),)
    at = Equations(model, data, Filters.of_rate(data[0].dt))
    start = Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    rows = rows_of_models(at, start, start, data)
    assert rows.seen[:, 0].any()
    (before, _, after), recorded = rows.torque(0)
    assert len(before) == len(after) == len(recorded) > 0
    assert np.isfinite(before).all()
