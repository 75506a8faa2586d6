"""Log posteriors of structures, against the Gaussian of the rows and parts that are computed by dense algebra."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from flexdyn.diagnose.inference.candidate_matrix import SPARE_COLUMNS
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.priors import FITTED_SIZE_WIDTH
from flexdyn.diagnose.inference.space import Structure
from flexdyn.effects import CoulombFriction
from flexdyn.model.uncertain_parameters import FileNumber
from tests.diagnose.inference_cases import EQUATIONS, TIMES, Case, Given, column, in_order

Array = NDArray[np.float64]
EMPTY: Structure = frozenset()
INERTIA = FileNumber("a", "rotor_inertia", 0.1, 0.1, "a")
NUMBER, VISCOUS_A, _, STRIBECK, COULOMB, _, RIPPLE = range(7)
TOLD = ModelError(np.array([2.0, 5.0]), np.array([3.0, 8.0]), np.full(2, float(TIMES)))
"""A model error that differs by equation."""


@lru_cache
def _case(seed: int = 0, level: float = 0.5, *, bounded: bool = False, stands: bool = False) -> Case:
    """Laws with one number and with two, in one equation and in both; rows that hold three of them and noise."""
    draw = np.random.default_rng(seed)
    valid = draw.random((TIMES, EQUATIONS)) > 0.1

    def white(width: int = 1, *equations: int) -> Array:
        table = draw.standard_normal((TIMES, EQUATIONS, width)) * valid[:, :, None]
        for k in set(range(EQUATIONS)) - set(equations or range(EQUATIONS)):
            table[:, k] = 0.0
        return np.asarray(table.reshape(TIMES * EQUATIONS, width))

    always = column(white(2), 0.1, 0.02)
    plain = column(white(1, 0), size=0.7)
    both = np.concatenate([plain.white + 0.1 * white(1, 0), 0.5 * plain.white + white(1, 0)], axis=1)
    viscous = column(white(1, 1), 0.5)
    effects = [
        Given("rotor_inertia", "a", (column(always.white[:, [0]], 1.0),), number=INERTIA),
        Given("viscous_friction", "a", (column(white(1, 0)),)),
        Given("viscous_friction", "b", (replace(viscous, positive=np.full(1, bounded)),)),
        Given("stribeck_friction", "a", tuple(column(white()) for _ in range(3)), ((0.1,), (0.2,), (0.4,))),
        Given("coulomb_friction", "a", (plain,)),
        Given("asymmetric_friction", "a", (column(both, [0.3, 0.4], size=[0.7, 0.2]),)),
        Given("torque_ripple", "b", (column(white(2, 1)), column(white(2))), ((3.0,), (2.5,))),
    ]
    rows = level * white()[:, 0] - effects[1].columns[0].white[:, 0] - 0.8 * effects[6].columns[0].white[:, 1]
    if stands:
        tangents = column(white(2, 1), [FITTED_SIZE_WIDTH, 0.3], [1.0, -0.1], [0.5, 0.0])
        effects.append(
            Given("coulomb_friction", "b", (tangents,), stands=CoulombFriction("b", side="motor", level=1.0))
        )
    return Case(tuple(effects), always, rows, valid, column(white()), {INERTIA: 1.0})


def _structures(case: Case) -> st.SearchStrategy[Structure]:
    """Any candidates, each at any of its grid points; a law never stands beside one that it contains."""
    points = [st.none() | st.integers(0, len(each.columns) - 1) for each in case.given]
    nested = [("coulomb_friction", "a"), ("asymmetric_friction", "a")]
    both = {c for c, each in enumerate(case.given) if (each.kind, each.joint) in nested}
    drawn = st.tuples(*points).map(lambda ps: frozenset((c, p) for c, p in enumerate(ps) if p is not None))
    return drawn.filter(lambda structure: not both <= {c for c, _ in structure})


@pytest.mark.parametrize("times", [(1.0, 1.0), (3.0, 7.0)])
@pytest.mark.parametrize(
    "structure", [EMPTY, frozenset({(VISCOUS_A, 0)}), frozenset({(VISCOUS_A, 0), (STRIBECK, 2), (RIPPLE, 0)})]
)
def test_a_value_is_density_times_prior(structure: Structure, times: tuple[float, float]) -> None:
    """Where no more is left than the sensors' noise: the Gaussian of rows that count 1/times each."""
    case = _case(level=0.3)
    rows = case.rows + case.given[VISCOUS_A].columns[0].white[:, 0] + 0.8 * case.given[RIPPLE].columns[0].white[:, 1]
    case = replace(case, rows=rows)
    noise = case.noise(times=times)
    space, at = case.space(noise), case.dense(structure, noise)
    assert np.all(at.squares < noise.count)
    covariance = at.X @ np.diag(at.std**2) @ at.X.T + np.diag(np.tile(times, TIMES))
    wanted = multivariate_normal.logpdf(at.y, at.X @ at.prior, covariance)
    wanted += 0.5 * float(np.log(2.0 * np.pi * np.tile(times, TIMES)).sum())
    found = space.value(structure) - space.log_prior(structure)
    found -= space.log_large(structure, space.gram.estimate(space.columns(structure)))
    assert found == pytest.approx(wanted, rel=1e-9)


@settings(deadline=None, max_examples=60)
@given(data=st.data(), seed=st.integers(0, 5), level=st.sampled_from([0.5, 3.0, 30.0]), stands=st.booleans())
def test_a_value_is_the_sum_of_its_parts(data: st.DataObject, seed: int, level: float, stands: bool) -> None:
    """The size of the model error by search, volumes and coefficients by least squares, priors by integration."""
    case = _case(seed, level, bounded=True, stands=stands)
    structure = data.draw(_structures(case))
    found = case.space(replace(TOLD, count=case.seen.count)).value(structure)
    assert found == pytest.approx(case.value(structure, replace(TOLD, count=case.seen.count)), rel=1e-6, abs=1e-6)


@settings(deadline=None, max_examples=30)
@given(data=st.data(), order=st.permutations(range(1, 7)))
def test_the_order_of_candidates_does_not_matter(data: st.DataObject, order: list[int]) -> None:
    """Values, and what is left, with columns at other places."""
    case = _case(1, 3.0, bounded=True)
    order = [NUMBER, *order]
    structure = data.draw(_structures(case))
    renamed = frozenset((order.index(c), p) for c, p in structure)
    one, other = case.space(TOLD), in_order(case, order).space(TOLD)
    assert other.value(renamed) == pytest.approx(one.value(structure), rel=1e-9)
    np.testing.assert_allclose(other.left(renamed), one.left(structure), atol=1e-9)


@settings(deadline=None, max_examples=30)
@given(data=st.data(), unit=st.floats(1e-3, 1e3))
def test_units_of_coefficients_do_not_matter(data: st.DataObject, unit: float) -> None:
    """A column of a thousand times the size, whose prior is a thousandth as wide."""
    case = _case(2, 3.0, bounded=True)
    structure = data.draw(_structures(case))
    effects = tuple(
        each
        if each.number
        else replace(
            each,
            columns=tuple(replace(k, apart=unit * k.apart, std=k.std / unit, size=unit * k.size) for k in each.columns),
        )
        for each in case.given
    )
    other = replace(case, given=effects).space(TOLD)
    assert other.value(structure) == pytest.approx(case.space(TOLD).value(structure), rel=1e-7)


def test_what_was_compared_is_remembered_until_the_model_error_changes() -> None:
    """Other weights for the coefficients keep what is known; another memory begins anew."""
    case, structure = _case(3, 3.0), frozenset({(VISCOUS_A, 0)})
    space = case.space(TOLD)
    before = space.value(structure)
    assert space.known == {structure: before}
    space.weigh(ModelError(np.array([1.0, 9.0]), np.array([1.0, 1.0]), TOLD.count))
    assert space.value(structure) == before
    space.under(replace(TOLD, times=np.array([1.0, 2.0])))
    assert space.known == {}
    assert space.value(structure) == pytest.approx(case.value(structure, space.noise), rel=1e-6)


def test_other_weights_keep_how_many_rows_tell_one_thing() -> None:
    """Coefficients by the sizes of the one model error and the memory of the other."""
    case, structure = _case(4, 3.0), frozenset({(VISCOUS_A, 0), (STRIBECK, 1)})
    space = case.space(TOLD)
    space.weigh(ModelError(np.array([1.0, 9.0]), np.array([50.0, 60.0]), TOLD.count))
    at = case.dense(structure, replace(TOLD, scale=np.array([1.0, 9.0])))
    found = space.gram.whole(space.columns(structure))
    np.testing.assert_allclose(found.mean, at.mean, atol=1e-10)
    np.testing.assert_allclose(found.covariance, at.covariance, atol=1e-10)
    np.testing.assert_allclose(space.left(structure), at.left, atol=1e-9)


def test_a_grid_point_that_comes_later_has_a_column_of_its_own() -> None:
    """Its value is that of the rows with it; a point that is known is not made again."""
    case = _case(5, 3.0)
    space = case.space(TOLD)
    place = space.grow(STRIBECK, (0.3,))
    assert place == 3
    assert space.grow(STRIBECK, (0.3,)) == 3
    assert space.grow(STRIBECK, (0.2,)) == 1
    structure = frozenset({(STRIBECK, place), (VISCOUS_A, 0)})
    found = space.gram.whole(space.columns(structure))
    np.testing.assert_allclose(found.mean, case.dense(structure, TOLD).mean, atol=1e-10)
    noise = replace(TOLD, count=case.seen.count)
    space.under(noise)
    assert space.value(structure) == pytest.approx(case.value(structure, noise), rel=1e-6)
    assert space.log_prior(structure) == space.log_prior(frozenset({(STRIBECK, 0), (VISCOUS_A, 0)}))


def test_nothing_grows_where_nothing_can() -> None:
    """Numbers have no grid; a point may do nothing; and there is room for some columns."""
    case = _case(6)
    assert case.space().grow(NUMBER, (0.3,)) is None
    assert replace(case, later=None).space().grow(STRIBECK, (0.3,)) is None
    wide = replace(case, later=column(np.ones((TIMES * EQUATIONS, SPARE_COLUMNS - 1)))).space()
    assert wide.grow(STRIBECK, (0.3,)) == 3
    assert wide.grow(STRIBECK, (0.35,)) is None
    assert wide.candidates[STRIBECK].points == [(0.1,), (0.2,), (0.4,), (0.3,)]


@settings(deadline=None, max_examples=30)
@given(data=st.data(), seed=st.integers(0, 5), stands=st.booleans())
def test_what_is_left_is_the_residual_of_least_squares(data: st.DataObject, seed: int, stands: bool) -> None:
    """Of a structure, and of all columns at once; rows that say nothing leave nothing."""
    case = _case(seed, 3.0, stands=stands)
    structure = data.draw(_structures(case))
    space = case.space(TOLD)
    np.testing.assert_allclose(space.left(structure), case.dense(structure, TOLD).left, atol=1e-6)
    assert not space.left(structure)[~case.valid.ravel()].any()
    everything = frozenset((c, p) for c, each in enumerate(case.given) for p in range(len(each.columns)))
    np.testing.assert_allclose(space.left(everything), case.dense(everything, TOLD).left, atol=1e-6)


def test_what_stands_is_there_or_not() -> None:
    """With it the rows are those of the start; without it, what it does is missing in them."""
    quiet = _case(7, 1.0, stands=True)
    quiet = replace(quiet, always=column(1e-9 * quiet.always.white, 1e-9))
    (block,) = quiet.given[-1].columns
    certain = replace(block, std=np.array([1e-9, 1e-9]), mean=np.array([1.0, 0.0]))
    bare = replace(quiet, given=(replace(quiet.given[-1], columns=(certain,)),))
    space = bare.space()
    np.testing.assert_allclose(space.left(frozenset({(0, 0)})), bare.rows, atol=1e-6)
    np.testing.assert_allclose(space.left(EMPTY), bare.rows - block.white[:, 0], atol=1e-6)
    assert space.matrix.base == 3  # two numbers and a little of its one tangent, none of what it does as it is


def test_the_best_is_the_most_likely_of_those_asked_for() -> None:
    """With the effects that are there, a wrong one and a superfluous one."""
    case = _case(8, 0.7)
    space = case.space()
    true = frozenset({(VISCOUS_A, 0), (RIPPLE, 0)})
    wrong = [EMPTY, *(true - {each} for each in true), true | {(STRIBECK, 0)}, frozenset({(STRIBECK, 0)})]
    for structure in (*wrong, true):
        space.value(structure)
    assert space.best() == true
    assert space.known[true] == max(space.known.values())
