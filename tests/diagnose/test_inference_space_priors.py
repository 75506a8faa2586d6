"""Priors of structures: of places and grid points by sums and integrals, of sizes by normal distributions."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain, combinations, product

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm

from flexdyn.diagnose.constants import (
    EFFECT_TORQUE_SHARE,
    NEGLIGIBLE_SHARE,
    PLACE_BETA,
    SMALLEST_TORQUE_SHARE,
    UBIQUITOUS_BETA,
    WHOLE_NUMBER_LOG_ODDS,
)
from flexdyn.diagnose.inference.candidate import Column
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Structure
from flexdyn.diagnose.inference.structure_prior import PriorOfPlaces
from flexdyn.diagnose.inference.substitutes import own_share
from flexdyn.effects import CoulombFriction
from flexdyn.model.uncertain_parameters import FileNumber
from tests.diagnose.inference_cases import EQUATIONS, EXPECTED, TIMES, Case, Given, column, share

Array = NDArray[np.float64]
ROWS = TIMES * EQUATIONS
EMPTY: Structure = frozenset()
ALONE: Structure = frozenset({(0, 0)})


def _draw(width: int = 1, seed: int = 0) -> Array:
    return np.random.default_rng(seed).standard_normal((ROWS, width))


def _places(kind: str, *, points: int = 1, joints: str = "abc") -> Case:
    """One kind on some joints, and a law with a grid of three on one."""
    grid = tuple((0.1 * k,) for k in range(1, points + 1)) if points > 1 else ((),)
    effects = [
        Given(kind, joint, tuple(column(_draw(seed=10 * k + p)) for p in range(points)), grid)
        for k, joint in enumerate(joints)
    ]
    speeds = tuple(column(_draw(seed=100 + p)) for p in range(3))
    effects.append(Given("backlash", "a", speeds, ((0.1,), (0.2,), (0.4,))))
    return Case(tuple(effects), column(_draw(2)), np.zeros(ROWS))


def test_priors_of_places_come_from_a_share_that_is_integrated_out() -> None:
    """Places are there with a probability that has a Beta prior."""
    space = _places("stribeck_friction").space()
    for m in range(1, 4):
        structure = frozenset((c, 0) for c in range(m))
        assert space.log_prior(structure) == pytest.approx(math.log(share(m, 3) / share(0, 3)), abs=1e-8)


@pytest.mark.parametrize("kind", EXPECTED)
def test_friction_of_every_motor_is_expected(kind: str) -> None:
    """Its share of the places is most likely near 1: alone the odds are 20 to 1, and each further one is likelier."""
    space = _places(kind).space()
    priors = [space.log_prior(frozenset((c, 0) for c in range(m))) for m in range(4)]
    for m in range(1, 4):
        assert priors[m] == pytest.approx(
            math.log(share(m, 3, UBIQUITOUS_BETA) / share(0, 3, UBIQUITOUS_BETA)), abs=1e-8
        )
    assert priors[3] > max(priors[:3])
    alone = _places(kind, joints="a").space()
    assert math.exp(alone.log_prior(ALONE)) == pytest.approx(20.0)


def test_friction_of_links_is_not_expected() -> None:
    """It is a kind of its own, as likely as not, and what the motors have is no reason for it."""
    motors = math.exp(_places("viscous_friction", joints="a").space().log_prior(ALONE))
    space = _places("viscous_friction", joints="a").space()
    (motor, *_) = space.candidates
    assert motor.proposal is not None
    link = replace(motor.proposal, place={**motor.proposal.place, "side": "link"})
    space.candidates[0] = replace(motor, proposal=link)
    space.places = PriorOfPlaces(space.candidates)
    assert motors == pytest.approx(20.0)
    assert math.exp(space.log_prior(ALONE)) == pytest.approx(1.0)


def test_a_law_that_contains_expected_friction_is_expected_as_much() -> None:
    """Asymmetric friction of a motor has the odds of Coulomb friction, times those of an effect that few drives have.

    So it is as likely as Coulomb friction and an offset, which are the same model.
    """
    kinds = ("coulomb_friction", "asymmetric_friction", "torque_offset")
    given = [Given(kind, "a", (column(_draw(seed=k)),)) for k, kind in enumerate(kinds)]
    space = Case(tuple(given), column(_draw(seed=9)), np.zeros(ROWS)).space()
    assert math.exp(space.log_prior(frozenset({(0, 0)}))) == pytest.approx(20.0)
    assert math.exp(space.log_prior(frozenset({(1, 0)}))) == pytest.approx(1.0)
    assert math.exp(space.log_prior(frozenset({(0, 0), (2, 0)}))) == pytest.approx(1.0)


def test_two_laws_of_one_motor_count_as_expected_friction_once() -> None:
    """Friction that varies, alone or beside Coulomb friction of the same motor: a motor has it or has it not."""
    forms = np.linalg.qr(_draw(6))[0]
    given = [Given("coulomb_friction", joint, (column(forms[:, [k]]),)) for k, joint in enumerate("ab")]
    given.append(Given("position_dependent_friction", "a", (column(forms[:, [2]]),), ((2.0,),)))
    space = Case(tuple(given), column(forms[:, 4:]), np.zeros(ROWS)).space()
    a, b, wave = ((c, 0) for c in range(3))
    prior = {
        held: space.places.log_prior(frozenset(held)) for m in range(1, 4) for held in combinations((a, b, wave), m)
    }
    varies = math.log(PLACE_BETA[0] / PLACE_BETA[1])  # few drives have it
    assert prior[a, b, wave] == pytest.approx(prior[a, b] + varies)
    assert prior[b, wave] == pytest.approx(prior[a, b] + varies)
    assert prior[a, wave] == pytest.approx(prior[a,] + varies)
    assert prior[wave,] == pytest.approx(prior[a,] + varies)
    beside = {held: {point: gain for gain, point in Scan(space).additions(frozenset({held}))} for held in (a, b)}
    apart = (prior[a, wave] - prior[a,]) - (prior[b, wave] - prior[b,])
    assert beside[a][wave] - beside[b][wave] == pytest.approx(apart)


@pytest.mark.parametrize("kind", ["stribeck_friction", "viscous_friction"])
def test_priors_of_all_structures_add_up_to_one(kind: str) -> None:
    """Over all subsets and grid points, once that of the empty structure is known: the choice of a point is even."""
    space = _places(kind, points=2).space()
    everywhere = chain.from_iterable(combinations(range(3), m) for m in range(4))
    plain = [frozenset(zip(mine, at, strict=True)) for mine in everywhere for at in product(range(2), repeat=len(mine))]
    gridded = [EMPTY, *(frozenset({(3, p)}) for p in range(3))]
    total = sum(math.exp(space.log_prior(one | other)) for one in plain for other in gridded)
    none = share(0, 3, UBIQUITOUS_BETA if kind in EXPECTED else PLACE_BETA) * share(0, 1)
    assert total * none == pytest.approx(1.0, abs=1e-8)


def test_an_effect_on_all_joints_costs_less_than_its_members_apart() -> None:
    """Each further place is more likely than the one before; alone the odds are 1 to 20, over the grid's points."""
    space = _places("stribeck_friction").space()
    priors = [space.log_prior(frozenset((c, 0) for c in range(m))) for m in range(4)]
    assert priors[1] < 0.0
    assert np.diff(priors)[2] > np.diff(priors)[1] > np.diff(priors)[0]
    assert math.exp(space.log_prior(frozenset({(3, 0)}))) == pytest.approx(PLACE_BETA[0] / PLACE_BETA[1] / 3)


def test_a_harmonic_that_is_no_whole_number_costs_more() -> None:
    """Of cycles a turn of the joint, or of the motor; what stands has been decided."""
    points = ((3.0,), (2.5,), (50.6,), (50.0,), (0.2,))
    ripple = Given("torque_ripple", "a", tuple(column(_draw(2, k)) for k in range(5)), points)
    space = Case((ripple,), column(_draw(2)), np.zeros(ROWS)).space()
    priors = np.array([space.log_prior(frozenset({(0, p)})) for p in range(5)])
    np.testing.assert_allclose(
        priors - priors[0],
        [0.0, -WHOLE_NUMBER_LOG_ODDS, -WHOLE_NUMBER_LOG_ODDS, 0.0, -WHOLE_NUMBER_LOG_ODDS],
        atol=1e-12,
    )
    space.candidates[0].ratio = 25.3
    space.under(space.noise)  # anew: priors of points are remembered
    priors = np.array([space.log_prior(frozenset({(0, p)})) for p in range(5)])
    np.testing.assert_allclose(
        priors - priors[0], [0.0, -WHOLE_NUMBER_LOG_ODDS, 0.0, 0.0, -WHOLE_NUMBER_LOG_ODDS], atol=1e-12
    )


def test_a_law_that_forgets_the_torque_costs_what_its_rows_tell() -> None:
    """Its log-density by the number of independent rows in the equation that it is about."""
    white = _draw()
    white[::EQUATIONS] *= 0.1  # the second equation has more of it
    case = Case(
        (Given("torque_limit", "a", (replace(column(white), log_jacobian=-70.0),)),), column(_draw(2)), _draw()[:, 0]
    )
    for times in ((1.0, 1.0), (3.0, 7.0)):
        space = case.space(case.noise(times=times))
        found = space.log_prior(ALONE) - math.log(share(1, 1) / share(0, 1))
        assert found == pytest.approx(-70.0 / times[1], rel=1e-9)


@pytest.mark.parametrize(("angle", "expected"), [(0.0, 0.0), (math.pi / 2, 1.0)])
def test_an_own_share_is_what_another_law_cannot_make(angle: float, expected: float) -> None:
    """Of the same columns nothing, of columns at a right angle all."""
    first, second = np.linalg.qr(_draw(2))[0].T[:, :, None] * 1e4
    blocks = (column(first, size=0.5), column(math.cos(angle) * first + math.sin(angle) * second, size=0.5))
    given = tuple(
        Given(kind, "a", (each,)) for kind, each in zip(("coulomb_friction", "stribeck_friction"), blocks, strict=True)
    )
    case = Case(given, column(_draw(seed=3), 1e-9), -2.0 * blocks[0].white[:, 0])
    assert own_share(case.space(), ALONE, 0, 1) == pytest.approx(2.0 * 0.5 * expected, abs=2e-3, rel=0.02)


def _sharp(size: float, **changes: float) -> tuple[Case, Column]:
    """An effect of one number whose size the rows tell to a millionth."""
    block = replace(column(1e5 * _draw(seed=1), size=0.5), **changes)  # type: ignore[arg-type]
    return Case((Given("stribeck_friction", "a", (block,)),), column(_draw(), 1e-6), -size * block.white[:, 0]), block


def _large(case: Case, structure: Structure = ALONE) -> float:
    space = case.space()
    return space.log_large(structure, space.gram.estimate(space.columns(structure)))


@pytest.mark.parametrize("smallest", [SMALLEST_TORQUE_SHARE, 0.05])
@pytest.mark.parametrize(("times", "low", "high"), [(10.0, -1e-6, 0.0), (0.5, -1e15, -5.0)])
def test_negligible_sizes_are_no_effects(smallest: float, times: float, low: float, high: float) -> None:
    """An effect of half the least size is refused; one of ten times that size is not touched.

    However sure the sum is, a negligible amount that every structure has may be a part of it.
    """
    for sign in (1.0, -1.0):
        case, _ = _sharp(sign * times * smallest / 0.5, smallest=smallest)
        assert low <= _large(case) <= high


def test_the_least_size_is_a_matter_of_probability_where_the_rows_are_few() -> None:
    """The share of the size's normal distribution that is above it."""
    white = 3.0 * _draw(seed=2)
    case = Case(
        (Given("stribeck_friction", "a", (column(white, size=0.5),)),), column(_draw(), 1e-6), -0.02 * white[:, 0]
    )
    at = case.dense(ALONE, case.noise())
    mean, spread = abs(0.5 * at.mean[-1]), 0.5 * math.sqrt(at.covariance[-1, -1])
    assert _large(case) == pytest.approx(math.log(norm.sf(SMALLEST_TORQUE_SHARE, mean, spread)), rel=1e-9)
    assert -3.0 < _large(case) < -0.01


@pytest.mark.parametrize(("factor", "change", "refused"), [(1.0, -0.5, False), (1.0, -1.5, True), (0.3, -0.5, True)])
def test_a_number_stays_positive(factor: float, change: float, refused: bool) -> None:
    """A mass, an inertia or a stiffness has a factor above zero; how much is no matter of least sizes."""
    number = FileNumber("a", "rotor_inertia", 0.1, 0.1, "a")
    white = 100.0 * _draw(seed=3)
    freed = Given("rotor_inertia", "a", (column(white, 1.0),), number=number)
    case = Case((freed,), column(white, 1e-6), -change * white[:, 0], factors={number: factor})
    assert _large(case) < -50.0 if refused else _large(case) == pytest.approx(0.0, abs=1e-9)
    tiny = replace(case, rows=-1e-4 * white[:, 0], factors={number: 1.0})
    assert _large(tiny) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("gain", [0.2, -0.2])
def test_a_gain_of_the_torque_changes_the_density_of_its_rows(gain: float) -> None:
    """Rows of recorded torque have (1 + gain) times the density of those of applied torque, each that counts."""
    case, block = _sharp(gain)
    scaled = replace(case, given=(replace(case.given[0], columns=(replace(block, gained=30),)),))
    assert _large(scaled) - _large(case) == pytest.approx(30 * math.log1p(gain), rel=1e-4)
    noise = case.noise(times=(4.0, 4.0))
    structures = [each.space(noise) for each in (scaled, case)]
    found = [each.log_large(ALONE, each.gram.estimate(each.columns(ALONE))) for each in structures]
    assert found[0] - found[1] == pytest.approx(30 / 4.0 * math.log1p(gain), rel=1e-4)


@pytest.mark.parametrize("share", [0.0, 0.25])
def test_it_does_so_as_far_as_slopes_have_the_noise_of_the_rows(share: float) -> None:
    """Along the expected motion they have none: the linear equations follow a covariance that grows with the gain."""
    case, block = _sharp(0.2)
    spaces = [
        replace(case, given=(Given("torque_constant_error", "a", (each,)),)).space(case.noise())
        for each in (replace(block, gained=30), block)
    ]
    for space in spaces:
        space.noise_in_slopes[:] = share
    found = [space.log_large(ALONE, space.gram.estimate(space.columns(ALONE))) for space in spaces]
    assert found[0] - found[1] == pytest.approx(share * 30 * math.log1p(0.2), rel=1e-4)


@pytest.mark.parametrize("plain_at", ["a", "b", "a, where it stands"])
@pytest.mark.parametrize("both", [0.0, 0.7, 1.0])
def test_a_law_is_large_by_what_a_plainer_one_cannot_do(both: float, plain_at: str) -> None:
    """Asymmetric friction that is Coulomb friction of the same joint is none; elsewhere that does not matter.

    Nor does it where Coulomb friction is no law of the catalogue but one that has been found.
    """
    one, other = 1e4 * np.linalg.qr(_draw(2, 4))[0].T
    form = both * one + math.sqrt(1.0 - both**2) * other
    asymmetric = Given("asymmetric_friction", "a", (column(form[:, None]),))
    coulomb = Given("coulomb_friction", plain_at[0], (column(one[:, None]),))
    # The size is four times the least one, of which the plainer law leaves sqrt(1 - both^2).
    case = Case((asymmetric, coulomb), column(_draw(), 1e-6), -4.0 * SMALLEST_TORQUE_SHARE * form)
    if len(plain_at) > 1:
        found = CoulombFriction("a", side="motor", level=1.0)
        case = replace(case, given=(asymmetric, replace(coulomb, stands=found)), rows=case.rows + one)
    wanted = 0.0
    if both == 1.0 and plain_at == "a":  # of nothing, as sure as the negligible amounts of both laws let it be
        wanted = float(norm.logcdf(-SMALLEST_TORQUE_SHARE / (math.sqrt(2.0) * NEGLIGIBLE_SHARE * EFFECT_TORQUE_SHARE)))
    assert _large(case) == pytest.approx(wanted, rel=1e-2, abs=1e-6)
