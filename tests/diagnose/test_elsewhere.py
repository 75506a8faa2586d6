"""Structures that other linearisations prefer are weighed by fits, and fits by what is left."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import prepared
from flexdyn.diagnose.inference.elsewhere import odds_by_fits
from flexdyn.diagnose.inference.passes import posterior
from flexdyn.diagnose.inference.weights import for_fit, rows_of
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.effects import CoulombFriction
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


def test_first_values_that_are_bad_are_not_called_good(tmp_path: Path) -> None:
    """A fit from them has the model error of the linearisation; first values that leave less have their own."""
    model = slider_model(tmp_path)
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, LEVEL)
    bare, noise, start = prepared(model, (measured(model, slider_recording(x, FORCE, RATE, LEVELS, 0)),))
    mask = sign_mask(bare.equations, noise)
    seen = rows_of(bare.equations, mask)

    def scale(level: float, near: Hypothesis | None = None) -> float:
        effects = (CoulombFriction("lift", side="motor", level=level),) if level else ()
        there = dataclasses.replace(start, effects=effects)
        error = for_fit(bare, noise, mask, seen, there, near).whiten
        assert isinstance(error, Tempered)
        return float(error.error.scale[0])

    assert scale(20.0 * LEVEL, start) == scale(0.0) < scale(20.0 * LEVEL)
    assert scale(LEVEL, start) == scale(LEVEL) < scale(0.0)
