"""Where the linearisations are: the first one, and those of which the answer is an average."""

from __future__ import annotations

import dataclasses

import pytest

from flexdyn.diagnose.constants import IN_TOLERANCE
from flexdyn.diagnose.inference.passes import linearised_elsewhere
from flexdyn.diagnose.inference.posterior import _in_tolerance
from tests.diagnose.test_estimate import problem


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("tolerances", "kept"), [(0.5, True), (0.9 * IN_TOLERANCE, True), (1.1 * IN_TOLERANCE, False)])
def test_a_fit_out_of_tolerance_is_no_place_to_linearise(sign: float, tolerances: float, *, kept: bool) -> None:
    """One number beyond three tolerances is enough, in either direction."""
    _, start = problem()
    number = next(iter(start.factors))
    factors = {**start.factors, number: 1.0 + sign * tolerances * number.tolerance}
    fitted = dataclasses.replace(start, factors=factors)
    assert _in_tolerance(fitted, start) is (fitted if kept else start)


def test_a_cycle_of_linearisations_is_averaged() -> None:
    """Only those since the structure was compared before: what came earlier no longer happens."""
    a, b, c, d = (frozenset({(name,)}) for name in "abcd")
    assert linearised_elsewhere([a, b, c], b) == (c,)
    assert linearised_elsewhere([a, b], b) == ()
    assert linearised_elsewhere([a, b, c, d], a) == (b, c, d)


def test_a_search_without_an_end_averages_all_but_the_first() -> None:
    """The first one is at the file's numbers, where nothing has been added yet."""
    a, b, c, d = (frozenset({(name,)}) for name in "abcd")
    assert linearised_elsewhere([a, b, c], d) == (b, c)
