"""The experiment of an "A or B": the rival in the place of what is named, and the motion that parts them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from flexdyn.diagnose.decision.corrected import corrected
from flexdyn.diagnose.decision.findings import findings, with_experiments
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.split import parts
from flexdyn.diagnose.experiment.rehearsal import CLEAR_DELTA_BIC
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.inference.posterior import posterior
from tests.diagnose.truths import Levels, slider_model, slider_recording, sliding

RATE, MASS, LEVEL = 250.0, 2.5, 0.8


def test_the_rival_is_fitted_and_a_motion_tells_it_apart(tmp_path: Path) -> None:
    """Dry friction or stiff bristles: as if the data had left it open."""
    t = np.arange(round(12.0 * RATE)) / RATE
    force = 6.0 * np.sin(2.1 * t + 0.3) + 5.0 * np.sin(5.3 * t) + 3.0 * np.sin(11.0 * t)
    x, _ = sliding(force, 1.0 / RATE, MASS, LEVEL)
    recording = slider_recording(x, force, RATE, Levels(position=2e-6, torque=0.02), seed=1)
    model = slider_model(tmp_path)
    fitted, _ = parts(model, [recording])
    bare, start = prepared(model, tuple(each.data for each in fitted))
    compared = posterior(bare, start)
    found = corrected(compared, weighed(dataclasses.replace(bare, noise=compared.noise)))
    (named,) = found.names
    (rival,) = (c for c, each in enumerate(found.candidates) if each.kind == "presliding_friction")
    either = [Name(named.candidate, (rival,), 0.99)]
    told = findings(model, found, either, {})
    assert told[0].plan is None
    (answer,) = with_experiments(told, found, either)
    assert answer.plan is not None
    assert answer.plan.names == ("Coulomb friction", "presliding friction")
    assert answer.plan.delta_bic >= CLEAR_DELTA_BIC
    assert answer.experiment.startswith(answer.plan.motion)
