"""How far effects stand out of what is left, against columns that are orthogonal and least squares."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexdyn.diagnose.constants import CERTAIN_SIGMAS, NOISE_LEVEL_ERROR
from flexdyn.diagnose.inference.apart import power_ratios
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.model.uncertain_parameters import FileNumber
from tests.diagnose.inference_cases import EQUATIONS, TIMES, Case, Given, column

Array = NDArray[np.float64]
ROWS = TIMES * EQUATIONS
ALIKE, SIZE = 4.0, 200.0
"""Rows that tell one thing, as what is left is coloured, and the root of the sum of squares of a form."""
POWER, SEEN = SIZE**2, SIZE**2 / ALIKE
"""Of a form: its sum of squares, and that by the weights of the rows."""


def _orthogonal(many: int, size: float, seed: int = 0) -> Array:
    """Forms of the first equation (many, rows) that are orthogonal, each of such a root of its sum of squares."""
    table = np.zeros((many, TIMES, EQUATIONS))
    table[:, :, 0] = size * np.linalg.qr(np.random.default_rng(seed).standard_normal((TIMES, many)))[0].T
    return np.asarray(table.reshape(many, ROWS))


def _effect(kind: str, *forms: Array, joint: str = "a", std: float = 0.4) -> Given:
    sizes = np.linalg.norm(forms, axis=1) / SIZE
    return Given(kind, joint, (column(np.stack(forms, axis=1), std, size=sizes),))


def _case(effects: tuple[Given, ...], rows: Array, *numbers: Array, std: float = 1e-6, factor: float = 1.0) -> Case:
    """Numbers of the file that such columns are of, at a factor, each a candidate before the effects."""
    names = [FileNumber(str(k), "rotor_inertia", 0.1, std, "a") for k in range(len(numbers))]
    freed = [
        Given("rotor_inertia", "a", (column(white[:, None], 1.0),), number=name)
        for white, name in zip(numbers, names, strict=True)
    ]
    always = column(np.stack(numbers, axis=1), std, 1.0 - factor, 0.0)
    return Case((*freed, *effects), always, rows, factors=dict.fromkeys(names, factor))


def _coloured(case: Case) -> Space:
    """Of white size, its rows alike."""
    return case.space(case.noise(times=(ALIKE, ALIKE)))


def _excess(squares: float | Array, times: float | Array = ALIKE) -> Array:
    """Of sums of squares of TIMES rows, what is neither noise of a level that is not sure, nor chance, nor white."""
    above = (
        np.asarray(squares)
        - (1.0 + NOISE_LEVEL_ERROR) * TIMES
        - CERTAIN_SIGMAS * np.sqrt(2.0 * TIMES * np.asarray(times))
    )
    return np.asarray(np.maximum(above, 0.0) * (1.0 - 1.0 / np.asarray(times)))


def _typical(case: Case, excess: Array) -> float:
    """Mean square of the share of torque that is left, each equation's by the columns that are about it most."""
    found = []
    for e in range(EQUATIONS):
        scales = []
        for block in (block for each in case.given for block in each.columns):
            for white, size in zip(block.white.T, block.size, strict=True):
                power = (white.reshape(-1, EQUATIONS) ** 2).sum(axis=0)
                scales += [power[e] / size**2] if power.argmax() == e else []
        found += [excess[e] / np.median(scales)] if scales else []
    return float(np.mean(found))


def _oracle(case: Case, structure: Structure, noise: ModelError) -> dict[int, float]:
    """Own parts by least squares on all rows, those of the priors below them."""
    at, found = case.dense(structure, noise), {}
    root = np.tile(1.0 / (noise.scale * np.sqrt(noise.times)), TIMES)[:, None]
    excess = _excess(at.squares, noise.times)
    blocks = {c: (block, own) for (c, _), block, own in zip(sorted(structure), at.blocks, at.own, strict=True)}
    factors = list(case.factors.values())
    for c in {*blocks, *range(len(factors))}:
        me = case.given[c]
        others = [block for other, (block, _) in blocks.items() if other != c]
        always = [j for j in range(len(factors)) if j != c]
        does = blocks[c][0].white @ at.mean[blocks[c][1]] if c in blocks else np.zeros(ROWS)
        if me.number is not None:
            does = does + case.always.white[:, c] * (factors[c] + at.mean[c] - 1.0)
        if me.kind == "asymmetric_friction":
            plain = [each for each in case.given if each.kind == "coulomb_friction" and each.joint == me.joint]
            others += [each.columns[0] for each in plain]
        X = np.concatenate([case.always.white[:, always], *(each.white for each in others)], axis=1)
        std = np.concatenate([case.always.std[always], *(each.std for each in others)])
        right = np.concatenate([root[:, 0] * does, np.zeros(len(std))])
        rows = np.concatenate([root * X, np.diag(1.0 / std)])
        own = right - rows @ np.linalg.lstsq(rows, right, rcond=None)[0]
        weights = 1.0 / (noise.scale**2 * noise.times)
        power = weights * (does.reshape(-1, EQUATIONS) ** 2).sum(axis=0)
        there = power > 0.01 * power.max()
        share = np.linalg.norm(blocks[c][0].size * at.mean[blocks[c][1]]) if c in blocks else np.inf
        hidden = float(power[there].sum()) * _typical(case, excess) / float(share) ** 2
        below = NOISE_LEVEL_ERROR * TIMES + CERTAIN_SIGMAS * np.sqrt(2.0 * TIMES * noise.times)
        left = max((weights * excess)[there].sum(), min(hidden, (weights * below)[there].sum()))
        found[c] = float(own @ own) / max(float(left), 1e-9)
    return found


def test_an_orthogonal_effect_has_all_that_it_does() -> None:
    """Own power over what is left beyond the sensors' noise, by the sums of squares of forms that are known."""
    number, one, two, rest = _orthogonal(4, SIZE)
    case = _case((_effect("viscous_friction", one), _effect("backlash", two)), -one - 0.5 * two + 0.2 * rest, number)
    found = power_ratios(_coloured(case), frozenset({(1, 0), (2, 0)}))
    excess = float(_excess(0.2**2 * POWER))
    # The prior's mean of zero takes some 1/(1 + 40^2) of each coefficient.
    assert found == {
        0: pytest.approx(0.0, abs=1e-6),  # a number that stays where it is
        1: pytest.approx(POWER / excess, rel=5e-3),
        2: pytest.approx(0.25 * POWER / excess, rel=5e-3),
    }


def test_what_a_fit_does_not_leave_is_not_left() -> None:
    """The linear equations leave another form as well, of which a fit explains all but a quarter of the power."""
    number, one, rest = _orthogonal(3, SIZE)
    space = _coloured(_case((_effect("viscous_friction", one),), rest - one, number))
    structure: Structure = frozenset({(1, 0)})
    linear, fitted = (power_ratios(space, structure, np.array([x, 0.0]))[1] for x in (0.0, 0.75 * POWER))
    assert fitted / linear == pytest.approx(float(_excess(POWER) / _excess(0.25 * POWER)), rel=1e-2)


def test_what_is_left_at_other_equations_does_not_matter() -> None:
    """Of an effect that acts on the first equation alone."""
    number, one, rest = _orthogonal(3, SIZE)
    other = np.zeros((TIMES, EQUATIONS))
    other[:, 1] = 50.0
    rows = -one + 0.2 * rest
    found = [
        power_ratios(_coloured(_case((_effect("viscous_friction", one),), left, number)), frozenset({(1, 0)}))[1]
        for left in (rows, rows + other.ravel())
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-12)


@pytest.mark.parametrize("left", [0.0, 0.02])
def test_what_chance_leaves_says_nothing_of_unknown_effects(left: float) -> None:
    """Every effect stands out, however small it is; so it does of white noise whose level was misjudged."""
    number, one, two, rest = _orthogonal(4, SIZE)
    effects = (_effect("viscous_friction", one), _effect("backlash", two))
    structure = frozenset({(1, 0), (2, 0)})
    found = power_ratios(_coloured(_case(effects, -one - 0.01 * two + left * rest, number)), structure)
    assert min(found[1], found[2]) > 1e6
    noisy = _case(effects, -one - 0.01 * two + 0.5 * rest, number)
    assert min(power_ratios(noisy.space(), structure)[c] for c in (1, 2)) > 1e6


def test_what_one_joint_leaves_may_hide_at_another() -> None:
    """Nothing is left at the effect's own equation: what it stands out of is the root mean square over all."""
    number, one, rest = _orthogonal(3, SIZE)
    there = np.roll(rest.reshape(TIMES, EQUATIONS), 1, axis=1).ravel()
    effects = (_effect("viscous_friction", one), _effect("backlash", there, joint="b"), _effect("payload", 2.0 * there))
    case = _case(effects, -one, number)
    found = power_ratios(_coloured(case), frozenset({(1, 0)}))[1]
    assert found > 1e6
    left = np.roll(_orthogonal(4, SIZE)[3].reshape(TIMES, EQUATIONS), 1, axis=1).ravel()
    found = power_ratios(_coloured(_case(effects, -one + 0.3 * left, number)), frozenset({(1, 0)}))[1]
    # The root mean square over the two equations of what is left would be more than noise can hide here.
    below = NOISE_LEVEL_ERROR * TIMES + CERTAIN_SIGMAS * np.sqrt(2.0 * TIMES * ALIKE)
    assert below < 0.5 * float(_excess(0.3**2 * POWER))
    assert found == pytest.approx(POWER / below, rel=2e-2)


def test_a_copy_of_another_effect_has_none() -> None:
    """Both do the same: neither has a part of its own; without the other one, each has all of it."""
    number, one, rest = _orthogonal(3, SIZE)
    case = _case((_effect("viscous_friction", one), _effect("backlash", one)), -one + 0.2 * rest, number)
    space = _coloured(case)
    both = power_ratios(space, frozenset({(1, 0), (2, 0)}))
    # Each does a half, for which the other would have to be 1, 2.5 standard deviations of its prior.
    hidden = 0.5**2 * SEEN / (1.0 + 0.4**2 * SEEN) / (_excess(0.2**2 * POWER) / ALIKE)
    for c in (1, 2):
        assert both[c] == pytest.approx(hidden, rel=1e-2)
        assert power_ratios(space, frozenset({(c, 0)}))[c] > 20.0


@pytest.mark.parametrize("joint", ["a", "b"])
def test_a_law_counts_what_the_plainer_one_that_it_contains_cannot_do(joint: str) -> None:
    """Asymmetric friction is Coulomb friction and a difference; at another joint Coulomb friction does not matter."""
    number, plain, difference, rest = _orthogonal(4, SIZE)
    law = _effect("asymmetric_friction", plain + difference, plain - difference)
    rows = -(0.9 * plain + 0.3 * difference) + 0.2 * rest
    case = _case((law, _effect("coulomb_friction", plain, joint=joint)), rows, number)
    found = power_ratios(_coloured(case), frozenset({(1, 0)}))[1]
    own = 0.3**2 if joint == "a" else 0.9**2 + 0.3**2
    assert found == pytest.approx(own * POWER / _excess(0.2**2 * POWER), rel=2e-2)


@pytest.mark.parametrize(("tolerance", "left"), [(1e-5, 1.0), (1e-2, 0.5), (10.0, 0.0)])
def test_a_number_takes_what_its_tolerance_allows(tolerance: float, left: float) -> None:
    """An effect that a number of the file could be: by ridge regression ``1/(1 + tolerance^2 |x|^2)`` is left of it."""
    one, rest = _orthogonal(2, SIZE)
    case = _case((_effect("viscous_friction", one),), -one + 0.2 * rest, one, std=tolerance)
    mean = case.dense(frozenset({(1, 0)}), case.noise(times=(ALIKE, ALIKE))).mean[-1]
    found = power_ratios(_coloured(case), frozenset({(1, 0)}))[1] / (mean**2 * POWER / float(_excess(0.2**2 * POWER)))
    assert found == pytest.approx((1.0 + tolerance**2 * SEEN) ** -1, rel=1e-2, abs=1e-6)
    assert found == pytest.approx(left, abs=0.01)


def test_a_number_that_is_wrong_stands_out_by_all_that_it_does() -> None:
    """Within its tolerance and beyond it; another number, not set free, by what its tolerance allows."""
    one, two, rest = _orthogonal(3, SIZE)
    for tolerance in (1e-5, 1e-2, 0.03):
        case = _case((), -0.5 * (one + two) + 0.2 * rest, one, two, std=tolerance)
        found = power_ratios(_coloured(case), frozenset({(0, 0)}))
        moved = 0.5 / (1.0 + 1.0 / (tolerance**2 * SEEN))  # by ridge regression
        excess = float(_excess(POWER * (0.2**2 + (0.5 - moved) ** 2)))
        wanted = {
            0: pytest.approx(0.25 * POWER / excess, rel=1e-2),
            1: pytest.approx(moved**2 * POWER / excess, rel=1e-2),
        }
        assert found == wanted


@pytest.mark.parametrize("factor", [1.0, 0.6, 1.5])
def test_a_number_is_as_far_off_as_it_is_from_the_file(factor: float) -> None:
    """Wherever the linearisation stands: all of what it does counts, and not what it moved last."""
    one, rest = _orthogonal(2, SIZE)
    case = _case((), -(1.3 - factor) * one + 0.2 * rest, one, std=0.3, factor=factor)
    excess = float(_excess(0.2**2 * POWER))
    for structure in (frozenset[tuple[int, int]](), frozenset({(0, 0)})):
        assert power_ratios(_coloured(case), structure) == {0: pytest.approx(0.3**2 * POWER / excess, rel=1e-2)}


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
    found, wanted = power_ratios(case.space(noise), structure), _oracle(case, structure, noise)
    assert found.keys() == wanted.keys()
    for c, each in found.items():
        assert each == pytest.approx(wanted[c], rel=1e-6)
