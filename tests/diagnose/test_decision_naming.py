"""Names from a posterior over structures, made by hand."""

from __future__ import annotations

import math

import pytest

from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.naming import Name, names
from flexdyn.diagnose.inference.space import Structure


def _masses(shares: dict[tuple[int, ...], float]) -> Masses:
    """Of sets of candidates, all at the first point of their grids."""
    return Masses.of({frozenset((c, 0) for c in mine): math.log(share) for mine, share in shares.items()})


def test_a_set_counts_with_its_best_grid_point() -> None:
    """Two points of one candidate's grid are one set."""
    known: dict[Structure, float] = {
        frozenset(): 0.0,
        frozenset({(3, 0)}): math.log(3.0),
        frozenset({(3, 5)}): math.log(2.0),
    }
    masses = Masses.of(known)
    assert masses.sets == (frozenset({3}), frozenset())
    assert masses.structures[0] == frozenset({(3, 0)})
    assert masses.probability.tolist() == pytest.approx([0.75, 0.25])
    assert masses.log_bayes_factor(3) == pytest.approx(math.log(3.0))


def test_what_every_set_holds_is_certain() -> None:
    """Whatever stands beside it."""
    masses = _masses({(1,): 0.6, (1, 2): 0.4})
    (name,) = names(masses, frozenset({1}))
    assert name == Name(1, (), 1.0)
    assert name.established


def test_what_shares_the_probability_is_a_rival() -> None:
    """The rival with most mass first, and no more of them than are needed."""
    masses = _masses({(1, 9): 0.6, (2, 9): 0.3, (3, 9): 0.07, (9,): 0.03})
    one, nine = names(masses, frozenset({1, 9}))
    assert (one.candidate, one.rivals) == (1, (2, 3))
    assert one.probability == pytest.approx(0.97)
    assert (nine.candidate, nine.rivals) == (9, ())
    assert nine.probability == pytest.approx(1.0)
    two_will_do = _masses({(1, 9): 0.7, (2, 9): 0.26, (3, 9): 0.04})
    assert names(two_will_do, frozenset({1, 9}))[0].rivals == (2,)


def test_what_makes_nothing_of_it_is_no_rival() -> None:
    """8 stands for 7, and has nothing in common with 1."""
    masses = _masses({(1, 7): 0.5, (1, 8): 0.4, (8,): 0.06, (7,): 0.04})
    one, seven = names(masses, frozenset({1, 7}), stands_in=lambda of, c: (of, c) != (1, 8))
    assert (one.candidate, one.rivals) == (1, ())
    assert one.probability == pytest.approx(0.9)
    assert seven.rivals == (8,)
    assert seven.probability == pytest.approx(1.0)


def test_the_rival_that_comes_in_its_place_is_told_before_one_that_comes_anyway() -> None:
    """5 is as often in sets with 1 as without it, 3 only in the place of 1."""
    masses = _masses({(1,): 0.4, (1, 5): 0.4, (3, 5): 0.12, (3,): 0.08})
    (name,) = names(masses, frozenset({1}))
    assert name.rivals == (3,)
    masses = _masses({(1,): 0.4, (1, 5): 0.4, (3, 5): 0.19, (4,): 0.01})
    assert names(masses, frozenset({1}))[0].rivals == (3,)


def test_what_may_be_an_imitation_needs_more_rivals() -> None:
    """Alone it is there with 0.96, but genuine with 0.97 only; one of two is there with 0.99."""
    masses = _masses({(1,): 0.96, (2,): 0.03, (): 0.01})
    assert names(masses, frozenset({1}))[0].rivals == ()
    (name,) = names(masses, frozenset({1}), {1: 0.97})
    assert name.rivals == (2,)
    assert name.probability == pytest.approx(0.99 * 0.97)


def test_what_may_be_nothing_at_all_is_not_established() -> None:
    """Sets that hold nothing in its place have a tenth of the mass."""
    (name,) = names(_masses({(1,): 0.9, (): 0.1}), frozenset({1}))
    assert not name.established
    assert not name.rivals
    assert name.probability == pytest.approx(0.9)


def test_rare_and_unfit_rivals_do_not_count() -> None:
    """Below 2 % nobody is told; nor is what the caller rules out."""
    rare = _masses({(1,): 0.93, **{(k,): 0.01 for k in range(2, 9)}})
    (name,) = names(rare, frozenset({1}))
    assert not name.rivals
    assert name.probability == pytest.approx(0.93)
    ruled_out = _masses({(1,): 0.8, (2,): 0.2})
    (name,) = names(ruled_out, frozenset({1}), stands_in=lambda _, c: c != 2)
    assert not name.established


def test_what_also_stands_in_the_best_set_is_no_rival() -> None:
    """Candidate 2 is in all sets; in place of 1 stands nothing."""
    assert not names(_masses({(1, 2): 0.8, (2,): 0.2}), frozenset({1, 2}))[0].established


def test_the_order_of_comparison_does_not_matter() -> None:
    """Equal posteriors are ranked by their candidates."""
    shares: dict[tuple[int, ...], float] = {(2,): 0.5, (1,): 0.5}
    assert _masses(shares).sets == _masses(dict(reversed(shares.items()))).sets


@pytest.mark.parametrize(("genuine", "wanted"), [({1: 1.0}, 0.98), ({}, 0.98), ({1: 0.5}, 0.49), ({2: 0.5}, 0.98)])
def test_what_may_be_an_imitation_is_less_probable(genuine: dict[int, float], wanted: float) -> None:
    """The probability that something is there times that it is what its name says; nothing said: it is."""
    (name,) = names(_masses({(1,): 0.98, (): 0.02}), frozenset({1}), genuine)
    assert name.probability == pytest.approx(wanted)
    assert name.established == (wanted > 0.95)


def test_rivals_are_chosen_before_imitations_are_discounted() -> None:
    """What is called "A or B" is as genuine as A: a rival is no reason to believe in A more."""
    masses = _masses({(1,): 0.7, (2,): 0.29, (): 0.01})
    plain, discounted = (names(masses, frozenset({1}), genuine)[0] for genuine in (None, {1: 0.9}))
    assert plain.rivals == discounted.rivals == (2,)
    assert plain.probability == pytest.approx(0.99)
    assert discounted.probability == pytest.approx(0.99 * 0.9)
    assert plain.established
    assert not discounted.established


def test_only_what_is_asked_for_is_named() -> None:
    """The caller leaves out what the fitted model does not hold."""
    masses = _masses({(1, 2): 1.0})
    assert [each.candidate for each in names(masses, frozenset({1, 2}), of=[2])] == [2]


def test_linearisations_that_do_not_agree_count_alike() -> None:
    """What stands at all of them is certain; what stands at one of three has a third of the mass."""
    masses = _masses({(1, 2): 0.9, (1, 3): 0.1}).mixed([frozenset({1, 3}), frozenset({1})], (1.0, 1.0))
    assert masses.probability.sum() == pytest.approx(1.0)
    one, two = names(masses, frozenset({1, 2}))
    assert one.probability == pytest.approx(1.0)
    assert not two.established
    assert masses.of_any([2]) == pytest.approx(0.3)
    assert masses.of_any([3]) == pytest.approx((0.1 + 1.0) / 3.0)
    assert masses.log_bayes_factor(2) == pytest.approx(math.log(9.0))


def test_a_law_that_contains_another_is_its_rival_at_another_linearisation() -> None:
    """They share a name, as within one linearisation: "A or B"."""
    (name,) = names(_masses({(1,): 1.0}).mixed([frozenset({2})], (1.0,)), frozenset({1}))
    assert (name.candidate, name.rivals) == (1, (2,))
    assert name.probability == pytest.approx(1.0)
