"""Log posteriors of structures, against the Gaussian of the rows and priors summed and integrated by hand."""

from __future__ import annotations

import math
from itertools import chain, combinations
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.linalg import solve_toeplitz, toeplitz
from scipy.stats import beta, multivariate_normal

from flexdyn.diagnose.inference.discrepancy import Autoregression, Discrepancy
from flexdyn.diagnose.inference.library import Candidate, Column, Library
from flexdyn.diagnose.inference.space import NEGLIGIBLE, ODDS, SMALLEST, Space, Structure
from flexdyn.diagnose.proposal import Proposal, linear

Array = NDArray[np.float64]
ROWS = 60
NUMBERS = 2
"""Columns that every structure has: numbers of the file."""
SPEEDS = ({"velocity": 0.1}, {"velocity": 0.2}, {"velocity": 0.4})
NONE = Discrepancy.none(np.arange(ROWS, dtype=np.intp)[:, None])
EMPTY: Structure = frozenset()


def _proposals() -> list[Proposal]:
    """Viscous friction on three joints, and an effect with a grid of speeds on one."""
    place = {"effect": "viscous_friction", "side": "motor"}
    found = [linear({**place, "joint": joint}, "coefficient") for joint in ("a", "b", "c")]
    return [*found, linear({"effect": "stribeck_friction", "joint": "a", "side": "motor"}, "excess", SPEEDS)]


def _column(draw: np.random.Generator, width: int = 1) -> Column:
    return Column(
        draw.standard_normal((ROWS, width)), np.full(width, 0.4), np.zeros(width), np.zeros(width, bool), np.ones(width)
    )


def _space(rows: Array) -> Space:
    """Candidates with columns of noise."""
    draw = np.random.default_rng(1)
    candidates, columns, place = [], [], NUMBERS
    for proposal in _proposals():
        at = [np.array([place + k]) for k in range(len(proposal.grid))]
        place += len(at)
        columns += [_column(draw) for _ in at]
        candidates.append(Candidate(proposal.place["effect"], proposal, None, list(proposal.grid), at, len(at)))
    always, later = _column(draw, NUMBERS), _column(draw)
    library = SimpleNamespace(
        candidates=lambda: (candidates, columns), always=lambda: always, columns=lambda proposal, point: later
    )
    return Space(cast(Library, library), rows)


def _space_with(*sizes: float, seed: int = 2) -> Space:
    """Rows in which the first candidates have these sizes, beside noise."""
    rows = np.random.default_rng(seed).standard_normal(ROWS)
    space = _space(rows)
    for c, size in enumerate(sizes):
        space.rows = space.rows - size * space.raw[:, space.candidates[c].columns[0][0]]
    return space


def _density(space: Space, structure: Structure, covariance: Array) -> float:
    """Of the rows given a structure, its numbers integrated out."""
    chosen = [space.raw[:, :NUMBERS] / 2.5]
    for c in range(3):  # a little of every law without a grid is in every structure
        chosen.append(NEGLIGIBLE * space.raw[:, space.candidates[c].columns[0]] / 2.5)
    chosen += [space.raw[:, space.candidates[c].columns[p]] / 2.5 for c, p in structure]
    Z = np.concatenate(chosen, axis=1)
    whole = multivariate_normal.logpdf(-space.rows, np.zeros(ROWS), Z @ Z.T + covariance)
    return float(whole) + 0.5 * ROWS * math.log(2.0 * math.pi)


@pytest.mark.parametrize("structure", [EMPTY, frozenset({(0, 0)}), frozenset({(1, 0), (3, 2)})])
def test_a_posterior_is_density_times_prior(structure: Structure) -> None:
    """Without a model error."""
    space = _space_with(1.0, 0.5)
    space.under(NONE)
    found = space.value(structure) - space.log_prior(structure)
    found -= space.log_large(structure, space.gram.estimate(space.columns(structure)))
    assert found == pytest.approx(_density(space, structure, np.eye(ROWS)), rel=1e-9)


def test_a_posterior_under_a_model_error_has_its_covariance() -> None:
    """An autoregression of order 1 from the first row on; the log-determinant is known apart from structures."""
    space, phi, variance = _space_with(1.0), 0.8, 5.0
    gamma = variance * phi ** np.arange(ROWS)
    table = np.array([[0.0], solve_toeplitz(gamma[:1], gamma[1:2])])
    noise = Discrepancy(
        (Autoregression(table, np.sqrt([variance, variance * (1.0 - phi**2)])),),
        np.arange(ROWS, dtype=np.intp)[:, None],
    )
    space.under(noise)
    for structure in (EMPTY, frozenset({(0, 0)}), frozenset({(0, 0), (3, 1)})):
        estimate = space.gram.estimate(space.columns(structure))
        found = estimate.log_likelihood - noise.log_scale
        assert found == pytest.approx(_density(space, structure, toeplitz(gamma)), rel=1e-9)


def test_priors_of_places_come_from_a_share_that_is_integrated_out() -> None:
    """Places are there with a probability that has a Beta prior."""
    space = _space_with()
    a, b = ODDS

    def share(m: int, n: int) -> float:
        return float(quad(lambda p: p**m * (1.0 - p) ** (n - m) * beta.pdf(p, a, b), 0.0, 1.0)[0])

    for m in range(1, 4):
        structure = frozenset((c, 0) for c in range(m))
        assert space.log_prior(structure) == pytest.approx(math.log(share(m, 3) / share(0, 3)), abs=1e-6)


def test_priors_of_all_structures_add_up_to_one() -> None:
    """Over all subsets and grid points, once that of the empty structure is known: the choice of a point is even."""
    space = _space_with()
    everywhere = chain.from_iterable(combinations(range(3), m) for m in range(4))
    plain = [frozenset((c, 0) for c in mine) for mine in everywhere]
    gridded = [EMPTY, *(frozenset({(3, p)}) for p in range(3))]
    total = sum(math.exp(space.log_prior(one | other)) for one in plain for other in gridded)
    a, b = ODDS
    none = math.prod(float(quad(lambda p, n=n: (1.0 - p) ** n * beta.pdf(p, a, b), 0.0, 1.0)[0]) for n in (3, 1))
    assert total * none == pytest.approx(1.0, abs=1e-6)


def test_an_effect_on_all_joints_costs_less_than_its_members_apart() -> None:
    """Each further place is more likely than the one before."""
    space = _space_with()
    priors = [space.log_prior(frozenset((c, 0) for c in range(m))) for m in range(4)]
    assert priors[1] < 0.0
    assert np.diff(priors)[2] > np.diff(priors)[1] > np.diff(priors)[0]
    assert math.exp(space.log_prior(frozenset({(3, 0)}))) == pytest.approx(ODDS[0] / ODDS[1] / len(SPEEDS))


@pytest.mark.parametrize(("times", "low", "high"), [(10.0, -1e-6, 0.0), (0.5, -1e9, -10.0)])
def test_negligible_sizes_are_no_effects(times: float, low: float, high: float) -> None:
    """An effect of half the least size is refused however sure it is; one of ten times that size is not touched."""
    space = _space_with()
    here = space.candidates[0].columns[0]
    space.raw[:, here] *= 1e4  # rows that are so sharp
    space.rows = space.rows - times * SMALLEST * space.raw[:, here[0]]
    space.under(NONE)
    structure = frozenset({(0, 0)})
    assert low <= space.log_large(structure, space.gram.estimate(space.columns(structure))) <= high


def test_a_grid_point_that_comes_later_has_a_column_of_its_own() -> None:
    """Its value is that of the rows with it; a point that is known is not made again."""
    space = _space_with(0.0)
    space.under(NONE)
    place = space.grow(3, (0.3,))
    assert place == 3
    assert space.grow(3, (0.3,)) == 3
    assert space.grow(3, (0.2,)) == 1
    structure = frozenset({(3, place)})
    estimate = space.gram.estimate(space.columns(structure))
    assert estimate.log_likelihood == pytest.approx(_density(space, structure, np.eye(ROWS)), rel=1e-9)
    assert space.log_prior(structure) == space.log_prior(frozenset({(3, 0)}))


def test_what_is_left_is_orthogonal_to_what_is_there_but_for_the_priors() -> None:
    """``X^T left = -Lambda (mean - mu)``, the normal equations."""
    space = _space_with(1.5)
    space.under(NONE)
    structure = frozenset({(0, 0)})
    left, whole = space.left(structure), space.estimate(structure)
    products = space.raw[:, whole.columns].T @ left
    np.testing.assert_allclose(products, -space.prior.precision[whole.columns] * whole.mean, atol=1e-8)
    assert float(left @ left) < 0.7 * float(space.rows @ space.rows)


def test_the_best_is_the_most_likely_of_those_asked_for() -> None:
    """With the effect that is there."""
    space = _space_with(1.0, 0.0, 0.0)
    space.under(NONE)
    for structure in (EMPTY, frozenset({(0, 0)}), frozenset({(1, 0)}), frozenset({(0, 0), (1, 0)})):
        space.value(structure)
    assert space.best() == frozenset({(0, 0)})
