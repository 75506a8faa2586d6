"""Where the first linearisation is: at the fit of the file's numbers, unless that leaves their tolerance."""

from __future__ import annotations

import dataclasses

import pytest

from flexdyn.diagnose.hypothesis.hypothesis import IN_TOLERANCE
from flexdyn.diagnose.inference.passes import _in_tolerance
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
