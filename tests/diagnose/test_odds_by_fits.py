"""Structures that other linearisations prefer are weighed by fits, and fits by what is left."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.estimate import SHORTENED_STEP
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.catalogue import everything
from flexdyn.diagnose.inference.linearisation import Linearisation
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.odds_by_fits import odds_by_fits
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from flexdyn.effects import CoulombFriction
from flexdyn.errors import SimulationError
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


def _promising(folder: Path, level: float) -> tuple[Linearisation, Structure]:
    """A linearisation whose equations are made to promise a level of friction, and the structure with it."""
    model = slider_model(folder)
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, LEVEL)
    bare, start = prepared(model, (measured(model, slider_recording(x, FORCE, RATE, LEVELS, 0)),))
    near = Linearisation.of(bare, start, everything(bare.equations), None)
    space, prior = near.space, near.space.matrix.prior
    each = enumerate(space.candidates)
    friction = next(c for c, one in each if one.kind == "coulomb_friction" and one.place["side"] == "motor")
    (column,) = space.candidates[friction].columns[0]
    prior.mean[column], prior.precision[column] = level, 1e12
    one = np.ones(len(space.seen.count))
    space.under(ModelError(one, one, space.seen.count))
    return near, frozenset({(friction, 0)})


def test_a_fit_begins_at_a_share_of_a_step_that_is_too_long(tmp_path: Path) -> None:
    """The linear equations are made to promise six times the friction that is there: a fit must not begin there."""
    near, structure = _promising(tmp_path, 6.0 * LEVEL)

    def level(made: Fit) -> float:
        (effect,) = made.hypothesis.effects
        assert isinstance(effect, CoulombFriction)
        return effect.level

    promised = near.fitted(hypothesis_of(near.space, structure), 1)
    assert level(promised) == pytest.approx(6.0 * LEVEL, rel=1e-3)
    begun = near.best_fitted(structure, 1)
    assert level(begun) == pytest.approx(6.0 * LEVEL * SHORTENED_STEP**2, rel=1e-3)  # of all shares the nearest


@pytest.mark.parametrize("share", [0.3, 3.0])
def test_a_fit_is_weighted_by_what_the_linear_equations_promise(share: float, tmp_path: Path) -> None:
    """A level that is wrong leaves so much that its own weights make its equation count for nothing."""
    near, structure = _promising(tmp_path, LEVEL)
    start = hypothesis_of(near.space, structure)
    start = dataclasses.replace(start, effects=tuple(each.replace(level=share * LEVEL) for each in start.effects))
    one = np.ones(len(near.space.seen.count))
    stalled, made = near.fitted(start, 4), near.fitted(start, 4, ModelError(one, one, near.space.seen.count))
    (level,) = (effect.level for effect in made.hypothesis.effects if isinstance(effect, CoulombFriction))
    assert level == pytest.approx(LEVEL, rel=1e-3)
    assert made.reduced < 2.0 < stalled.equations.residual.std() / made.equations.residual.std()


def test_cycles_stay_until_the_structure_is_whole(tmp_path: Path) -> None:
    """A fit between two linearisations keeps the cycles of waves, and the last one moves them.

    Also where it begins at a share of its step, and where no share is finite.
    """
    for level in (LEVEL, 6.0 * LEVEL, 1e200):
        near, structure = _promising(tmp_path, level)
        for whole in (False, True):
            with np.errstate(over="ignore"):
                assert near.best_fitted(structure, 1, whole=whole).hypothesis.fits_cycles == whole


def test_a_fit_begins_where_it_is_if_no_share_of_a_step_is_finite(tmp_path: Path) -> None:
    """A friction whose square overflows, and shares of it: the linearisation's own point is fitted."""
    near, structure = _promising(tmp_path, 1e200)
    one = np.ones(len(near.space.seen.count))
    for error in (None, ModelError(one, one, near.space.seen.count)):  # whatever it is weighted by
        with pytest.raises(SimulationError), np.errstate(over="ignore"):
            near.fitted(hypothesis_of(near.space, structure), 1, error)
    with np.errstate(over="ignore"):
        begun = near.best_fitted(structure, 1)
    assert not begun.hypothesis.effects
    assert np.isfinite(begun.reached)
