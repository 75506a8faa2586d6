"""A candidate that the linear equations promise must be missed by a fit without it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.fitted_structure import FittedStructure
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.naming import names
from flexdyn.diagnose.decision.needed_in_fits import needed_in_fits
from flexdyn.diagnose.decision.one_law import with_best
from flexdyn.diagnose.decision.rivals_in_fits import rivals_in_fits
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.odds_by_fits import most_likely_visited
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from tests.diagnose.test_simulated import FORCE, LEVEL, LEVELS, MASS, RATE
from tests.diagnose.truths import slider_model, slider_recording, sliding


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Posterior:
    """Of a slider with Coulomb friction, whose level is LEVEL."""
    model = slider_model(tmp_path_factory.mktemp("slider"))
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, LEVEL)
    return posterior(*prepared(model, (measured(model, slider_recording(x, FORCE, RATE, LEVELS, 0)),)))


def _place(found: Posterior, kind: str, side: str = "motor") -> int:
    each = enumerate(found.space.candidates)
    return next(c for c, one in each if one.kind == kind and one.place.get("side") == side)


def test_what_is_there_is_missed_and_what_is_not_is_left_out(found: Posterior) -> None:
    """Friction that is there, and an offset that is not: a fit without the offset is more likely."""
    (friction,) = found.best
    offset = (_place(found, "torque_offset"), 0)
    made = needed_in_fits(with_best(found, found.best | {offset}))
    odds = {frozenset(c for c, _ in rest): each for rest, _, each in made.by_fits}
    assert made.best == found.best
    assert [effect.name for effect in made.fitted.hypothesis.effects] == ["coulomb_friction"]
    assert odds[frozenset({friction[0]})] > 1.0
    assert odds[frozenset({offset[0]})] < 1e-6
    assert list(made.left_out) == [offset[0]]
    assert made.fitted.reached == pytest.approx(needed_in_fits(found).fitted.reached, rel=1e-4)


def test_what_is_needed_stays(found: Posterior) -> None:
    """Friction alone: the structure is as before, and its fit leaves no more."""
    made = needed_in_fits(found)
    assert made.best == found.best
    assert made.fitted.reached <= found.fitted.reached
    ((rest, whole, odds),) = made.by_fits
    assert (rest, whole) == (frozenset(), frozenset(c for c, _ in found.best))
    assert odds < 1e-6


def test_a_search_that_does_not_settle_ends_where_a_fit_was_most_likely(found: Posterior) -> None:
    """At an offset, after a pass that had the friction: its fit counts; the other way round, nothing changes."""
    space, offset = found.space, (_place(found, "torque_offset"), 0)
    (friction,) = found.best
    right = space.identities(found.best)
    wrong = space.identities(frozenset({offset}))
    start = hypothesis_of(space, frozenset({offset}))
    made = fit(start, found.fitted.space)
    best, fitted = most_likely_visited(space, frozenset({offset}), made, [(right, found.fitted.hypothesis)])
    assert {c for c, _ in best} == {friction[0]}
    assert fitted.reached == pytest.approx(found.fitted.reached, rel=0.05)
    assert most_likely_visited(space, found.best, found.fitted, [(wrong, made.hypothesis)])[0] == found.best


def test_a_plainer_law_takes_the_place_of_one_that_contains_it(found: Posterior) -> None:
    """Friction that has two levels, or a bristle, where it has one level and none: its fit is as good as theirs."""
    ((plain, _),) = found.best
    for kind in ("asymmetric_friction", "presliding_friction"):
        given = with_best(found, frozenset({(_place(found, kind), 0)}))
        made = rivals_in_fits(given)
        assert {c for c, _ in made.best} == {plain}
        structure, whole, odds = made.by_fits[0]
        assert (structure, whole) == (made.best, frozenset(c for c, _ in given.best))
        assert odds > 1.0
        assert made.fitted.reached == pytest.approx(needed_in_fits(found).fitted.reached, rel=0.02)


def test_one_of_two_that_fits_do_not_need_is_an_a_or_b() -> None:
    """Where fits with either one alone are as likely, one is named with the other as its rival."""
    sure = Masses.of({frozenset({(0, 0), (1, 0), (2, 0)}): 0.0, frozenset({(0, 0), (1, 0)}): -0.5})
    both = frozenset({0, 1, 2})
    at = [frozenset((c, 0) for c in both - {left_out}) for left_out in (2, 1, 0)]
    weighed = sure.by_fits([(at[0], both, 1.0), (at[1], both, 1.0), (at[2], both, 0.0)])
    alone, either = names(weighed, frozenset({0, 1}))
    assert (alone.rivals, alone.established) == ((), True)
    assert (either.rivals, either.established) == ((2,), True)


def test_what_fits_leave_out_is_not_believed_elsewhere() -> None:
    """The promise for it is taken off every set; what the equations say of the others stays, and their A or B."""
    sets = {(0, 1, 2): 9.0, (0, 1): 4.0, (0, 2): 8.5, (0,): 3.5, (3, 1): 3.5, (3, 1, 2): 8.5}
    known = {frozenset((c, 0) for c in mine): value for mine, value in sets.items()}
    whole, left = frozenset({0, 1, 2}), frozenset({(0, 0), (1, 0)})
    made = Masses.of(known).without({2: 5.0 + 7.0}).by_fits([(left, whole, float(np.exp(7.0)))])
    assert made.of_any([2]) < 0.01
    assert made.sets[0] == frozenset({0, 1})
    assert made.of_any([3]) / made.of_any([0]) == pytest.approx(np.exp(3.5 - 4.0) / (1.0 + np.exp(-0.5)), rel=0.01)


def test_fits_count_where_they_tell_more() -> None:
    """A set has the mass that the equations or a fit give it, whichever is more, and not both."""
    both, one, other = frozenset({0, 1}), frozenset({0}), frozenset({1})
    here = Masses.of({frozenset({(0, 0), (1, 0)}): 0.0, frozenset({(0, 0)}): float(np.log(0.2))})
    made = here.by_fits([(frozenset({(0, 0)}), both, 0.1), (frozenset({(1, 3)}), both, 0.4)])
    found = dict(zip(made.sets, made.probability, strict=True))
    assert found == {both: pytest.approx(1.0 / 1.6), one: pytest.approx(0.2 / 1.6), other: pytest.approx(0.4 / 1.6)}
    assert made.sets == (both, other, one)
    assert made.structures[1] == frozenset({(1, 3)})  # at the grid point of the fit
    assert made.log[1] == pytest.approx(np.log(0.4))


def test_what_the_user_states_of_a_number_is_part_of_the_likelihood(found: Posterior) -> None:
    """A mass ten tolerances off costs exp(-50), and nothing where its tolerance is taken for wrong."""
    hidden = np.zeros(found.fitted.equations.residual.shape, bool)
    numbers = list(found.fitted.hypothesis.factors)

    def likelihood(off: float, freed: bool) -> float:
        factors = dict.fromkeys(numbers, 1.0) | {numbers[0]: 1.0 + off * numbers[0].tolerance}
        there = dataclasses.replace(
            found.fitted.hypothesis, factors=factors, freed=frozenset(numbers[:1] if freed else ())
        )
        made = dataclasses.replace(found.fitted, hypothesis=there)  # its rows are as they were
        return FittedStructure.of(found.space, found.best, 0.0, made, hidden).likelihood

    assert likelihood(10.0, freed=False) - likelihood(0.0, freed=False) == pytest.approx(-50.0)
    assert likelihood(10.0, freed=True) == pytest.approx(likelihood(0.0, freed=True), abs=1e-3)
