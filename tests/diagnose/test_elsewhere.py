"""Structures that other linearisations prefer are weighed by fits."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.workspace import prepared
from flexdyn.diagnose.inference.elsewhere import odds_by_fits
from flexdyn.diagnose.inference.passes import posterior
from tests.diagnose.test_simulated import FORCE, LEVEL, LEVELS, MASS, RATE
from tests.diagnose.truths import slider_model, slider_recording, sliding


def test_a_fit_tells_what_a_linearisation_only_promised(tmp_path: Path) -> None:
    """Friction that is there: nothing in its place is out of the question, the same again is as likely."""
    model = slider_model(tmp_path)
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, LEVEL)
    data = measured(model, slider_recording(x, FORCE, RATE, LEVELS, 0))
    found = posterior(*prepared(model, (data,)))
    there = frozenset(c for c, _ in found.best)
    assert {found.space.candidates[c].kind for c in there} == {"coulomb_friction"}
    nothing, same = odds_by_fits(found.space, found.best, found.fitted, [frozenset(), there])
    assert nothing < 1e-6
    assert same == pytest.approx(1.0, abs=0.05)
