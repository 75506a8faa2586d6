"""How far effects stand out of what is left, against columns that are orthogonal and least squares."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexdyn.diagnose.hypothesis.numbers import FileNumber
from flexdyn.diagnose.inference.apart import COMMON, SELDOM, genuine, shares
from flexdyn.diagnose.inference.discrepancy import Discrepancy
from flexdyn.diagnose.inference.space import Structure
from tests.diagnose.inference_cases import EQUATIONS, TIMES, Case, Given, column

Array = NDArray[np.float64]
ROWS = TIMES * EQUATIONS


def _orthogonal(many: int, size: float, seed: int = 0) -> Array:
    """Forms of the first equation (many, rows) that are orthogonal, each of such a root of its sum of squares."""
    table = np.zeros((many, TIMES, EQUATIONS))
    table[:, :, 0] = size * np.linalg.qr(np.random.default_rng(seed).standard_normal((TIMES, many)))[0].T
    return np.asarray(table.reshape(many, ROWS))


def _effect(kind: str, *forms: Array, joint: str = "a", std: float = 0.4) -> Given:
    return Given(kind, joint, (column(np.stack(forms, axis=1), std),))


def _case(effects: tuple[Given, ...], rows: Array, *numbers: Array, std: float = 1e-6, factor: float = 1.0) -> Case:
    """Numbers of the file that such columns are of, at a factor, each a candidate before the effects."""
    names = [FileNumber(str(k), "rotor_inertia", 0.1, std, "a") for k in range(len(numbers))]
    freed = [
        Given("rotor_inertia", "a", (column(white[:, None], 1.0),), number=name)
        for white, name in zip(numbers, names, strict=True)
    ]
    always = column(np.stack(numbers, axis=1), std, 1.0 - factor)
    return Case((*freed, *effects), always, rows, factors=dict.fromkeys(names, factor))


def _oracle(case: Case, structure: Structure, noise: Discrepancy) -> dict[int, float]:
    """Own parts by least squares on all rows, those of the priors below them."""
    at, found = case.dense(structure, noise), {}
    root = np.tile(1.0 / (noise.scale * np.sqrt(noise.times)), TIMES)[:, None]
    excess = np.maximum(at.squares - case.seen.count, 0.0)
    blocks = {c: (block, at.mean[own]) for (c, _), block, own in zip(sorted(structure), at.blocks, at.own, strict=True)}
    factors = list(case.factors.values())
    for c in {*blocks, *range(len(factors))}:
        me = case.given[c]
        others = [block for other, (block, _) in blocks.items() if other != c]
        always = [j for j in range(len(factors)) if j != c]
        does = blocks[c][0].white @ blocks[c][1] if c in blocks else np.zeros(ROWS)
        if me.number is not None:
            does = does + case.always.white[:, c] * (factors[c] + at.mean[c] - 1.0)
        if me.kind == "asymmetric_friction":
            plain = [each for each in case.given if each.kind == "coulomb_friction" and each.joint == me.joint]
            others += [each.columns[0] for each in plain]
        X = np.concatenate([case.always.white[:, always], *(each.white for each in others)], axis=1)
        std = np.concatenate([case.always.std[always], *(each.std for each in others)])
        right = np.concatenate([root[:, 0] * does, np.zeros(len(std))])
        best = np.linalg.lstsq(np.concatenate([root * X, np.diag(1.0 / std)]), right, rcond=None)[0]
        power = ((does - X @ best).reshape(-1, EQUATIONS) ** 2).sum(axis=0)
        found[c] = float(power.sum() / excess[power > 0.01 * power.max()].sum())
    return found


def test_an_orthogonal_effect_has_all_that_it_does() -> None:
    """Own power over what is left beyond the sensors' noise, by the sums of squares of forms that are known."""
    number, one, two, rest = _orthogonal(4, 100.0)
    case = _case((_effect("viscous_friction", one), _effect("backlash", two)), -one - 0.5 * two + 0.2 * rest, number)
    found = shares(case.space(), frozenset({(1, 0), (2, 0)}))
    excess = (0.2 * 100.0) ** 2 - TIMES
    # The prior's mean of zero takes some 1/(1 + 40^2) of each coefficient.
    assert found == {
        0: pytest.approx(0.0, abs=1e-6),  # a number that stays where it is
        1: pytest.approx(1e4 / excess, rel=5e-3),
        2: pytest.approx(0.25e4 / excess, rel=5e-3),
    }


def test_what_is_left_at_other_equations_does_not_matter() -> None:
    """Of an effect that acts on the first equation alone."""
    number, one, rest = _orthogonal(3, 100.0)
    other = np.zeros((TIMES, EQUATIONS))
    other[:, 1] = 50.0
    rows = -one + 0.2 * rest
    found = [
        shares(_case((_effect("viscous_friction", one),), left, number).space(), frozenset({(1, 0)}))[1]
        for left in (rows, rows + other.ravel())
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-12)


def test_without_anything_left_every_effect_stands_out() -> None:
    """However small it is."""
    number, one, two = _orthogonal(3, 100.0)
    case = _case((_effect("viscous_friction", one), _effect("backlash", two)), -one - 0.01 * two, number)
    found = shares(case.space(), frozenset({(1, 0), (2, 0)}))
    assert min(found[1], found[2]) > 1e6


def test_a_copy_of_another_effect_has_none() -> None:
    """Both do the same: neither has a part of its own; without the other one, each has all of it."""
    number, one, rest = _orthogonal(3, 100.0)
    case = _case((_effect("viscous_friction", one), _effect("backlash", one)), -one + 0.2 * rest, number)
    space = case.space()
    both = shares(space, frozenset({(1, 0), (2, 0)}))
    assert max(both[1], both[2]) < 1e-4
    for c in (1, 2):
        assert shares(space, frozenset({(c, 0)}))[c] > 20.0


@pytest.mark.parametrize("joint", ["a", "b"])
def test_a_law_counts_what_the_plainer_one_that_it_contains_cannot_do(joint: str) -> None:
    """Asymmetric friction is Coulomb friction and a difference; at another joint Coulomb friction does not matter."""
    number, plain, difference, rest = _orthogonal(4, 100.0)
    law = _effect("asymmetric_friction", plain + difference, plain - difference)
    rows = -(0.9 * plain + 0.3 * difference) + 0.2 * rest
    case = _case((law, _effect("coulomb_friction", plain, joint=joint)), rows, number)
    found = shares(case.space(), frozenset({(1, 0)}))[1]
    own = 0.3**2 if joint == "a" else 0.9**2 + 0.3**2
    assert found == pytest.approx(own * 1e4 / (0.2**2 * 1e4 - TIMES), rel=2e-2)


@pytest.mark.parametrize(("tolerance", "left"), [(1e-5, 1.0), (1e-2, 0.25), (10.0, 0.0)])
def test_a_number_takes_what_its_tolerance_allows(tolerance: float, left: float) -> None:
    """An effect that a number of the file could be: by ridge regression ``1/(1 + tolerance^2 |x|^2)`` is left of it."""
    one, rest = _orthogonal(2, 100.0)
    case = _case((_effect("viscous_friction", one),), -one + 0.2 * rest, one, std=tolerance)
    mean = case.dense(frozenset({(1, 0)}), case.noise()).mean[-1]
    found = shares(case.space(), frozenset({(1, 0)}))[1] / (mean**2 * 1e4 / (0.2**2 * 1e4 - TIMES))
    assert found == pytest.approx((1.0 + tolerance**2 * 1e4) ** -2, rel=1e-2, abs=1e-6)
    assert found == pytest.approx(left, abs=0.01)


def test_a_number_that_is_wrong_stands_out_by_all_that_it_does() -> None:
    """Within its tolerance and beyond it; another number, not set free, by what its tolerance allows."""
    one, two, rest = _orthogonal(3, 100.0)
    for tolerance in (1e-5, 1e-2, 0.3):
        case = _case((), -0.5 * (one + two) + 0.2 * rest, one, two, std=tolerance)
        found = shares(case.space(), frozenset({(0, 0)}))
        moved = 0.5 / (1.0 + 1.0 / (tolerance**2 * 1e4))  # by ridge regression
        excess = 1e4 * (0.2**2 + (0.5 - moved) ** 2) - TIMES
        wanted = {0: pytest.approx(0.25e4 / excess, rel=1e-2), 1: pytest.approx(moved**2 * 1e4 / excess, rel=1e-2)}
        assert found == wanted


@pytest.mark.parametrize("factor", [1.0, 0.6, 1.5])
def test_a_number_is_as_far_off_as_it_is_from_the_file(factor: float) -> None:
    """Wherever the linearisation stands: all of what it does counts, and not what it moved last."""
    one, rest = _orthogonal(2, 100.0)
    case = _case((), -(1.3 - factor) * one + 0.2 * rest, one, std=0.3, factor=factor)
    excess = 0.2**2 * 1e4 - TIMES
    for structure in (frozenset[tuple[int, int]](), frozenset({(0, 0)})):
        assert shares(case.space(), structure) == {0: pytest.approx(0.3**2 * 1e4 / excess, rel=1e-2)}


@settings(deadline=None, max_examples=40)
@given(
    seed=st.integers(0, 10_000),
    scale=st.tuples(st.floats(1.0, 10.0), st.floats(1.0, 10.0)),
    times=st.tuples(st.floats(1.0, 30.0), st.floats(1.0, 30.0)),
    chosen=st.sets(st.integers(0, 5), min_size=1),
)
def test_shares_are_those_of_least_squares(
    seed: int, scale: tuple[float, float], times: tuple[float, float], chosen: set[int]
) -> None:
    """Of any structure, its columns alike and in both equations, under any model error."""
    draw = np.random.default_rng(seed)
    forms = draw.standard_normal((8, ROWS)) + 0.7 * draw.standard_normal(ROWS)
    forms[3, ::EQUATIONS] = 0.0
    effects = (
        _effect("viscous_friction", forms[2]),
        _effect("backlash", forms[3], forms[4]),
        _effect("asymmetric_friction", forms[5], forms[6]),
        _effect("coulomb_friction", forms[5] + 0.3 * forms[7]),
    )
    case = _case(
        effects, 5.0 * draw.standard_normal(ROWS) + draw.standard_normal(8) @ forms, *forms[:2], std=0.05, factor=0.9
    )
    # Coulomb friction does not stand beside the law that contains it.
    structure = frozenset((c, 0) for c in chosen if c != 5 or 4 not in chosen)
    noise = case.noise(scale, times)
    found, wanted = shares(case.space(noise), structure), _oracle(case, structure, noise)
    assert found.keys() == wanted.keys()
    for c, each in found.items():
        assert each == pytest.approx(wanted[c], rel=1e-6)


@pytest.mark.parametrize("kind", ["viscous_friction", "stribeck_friction", "backlash"])
@pytest.mark.parametrize("ratio", [0.0, 0.5, 4.0])
def test_a_genuine_effect_is_more_likely_than_an_imitation(kind: str, ratio: float) -> None:
    """By Bayes' rule, the imitation's probability by drawing shares of what it imitates."""
    drawn = np.random.default_rng(1).random(400_000)
    stands_out = drawn / (1.0 - drawn)  # a share s is R = s/(1 - s) over the rest
    imitation = float((stands_out >= ratio).mean())
    odds = COMMON.get(kind, SELDOM)
    assert genuine(kind, ratio) == pytest.approx(odds / (odds + imitation), rel=5e-3)


def test_genuine_is_a_probability_that_grows_with_what_stands_out() -> None:
    """Up to certainty where nothing is left."""
    values = [genuine("backlash", float(r)) for r in (0.0, 0.1, 1.0, 10.0, 1e6)]
    assert np.all(np.diff(values) > 0.0)
    assert values[0] == pytest.approx(0.5)
    assert genuine("backlash", np.inf) == pytest.approx(1.0)
