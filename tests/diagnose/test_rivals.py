"""Laws that the data cannot tell apart are not told apart by rounding."""

from __future__ import annotations

import numpy as np
import pytest

from flexdyn.diagnose.verify import SURE, surely_less


def test_rounding_speaks_for_no_law() -> None:
    """The same law by two names leaves the same rows but for the last digits, all on one side."""
    rows = np.random.default_rng(0).chisquare(40, size=60)
    assert abs(surely_less(rows * (1.0 + 1e-9), rows)) < 0.01


@pytest.mark.parametrize("less", [0.9, 0.97])
def test_what_is_less_in_every_block_is_surely_less(less: float) -> None:
    """Both ways round."""
    rows = np.random.default_rng(0).chisquare(40, size=60)
    assert surely_less(rows, less * rows) > SURE
    assert surely_less(less * rows, rows) < -SURE
