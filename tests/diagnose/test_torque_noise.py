"""The level of a noise whose rows differ in how much they show of it."""

from __future__ import annotations

import numpy as np
import pytest

from flexdyn.diagnose.equations.noise import _level
from flexdyn.records.signals.reading_noise import robust_std

LEVEL = 0.2


@pytest.mark.parametrize("spread", [1.0, 1.5, 4.0])
def test_the_level_is_right_however_much_rows_differ(spread: float) -> None:
    """Half of the rows show more of the noise than the others; by the bulk of all rows alone, it would be too small."""
    rng, many = np.random.default_rng(3), 40000
    unit = np.where(rng.random(many) < 0.3, spread**2, 1.0)
    others = np.full(many, 0.01)
    seen = rng.normal(size=many) * np.sqrt(others + unit * LEVEL**2)
    seen[:400] += 30.0  # rows of something else
    plain = np.sqrt((robust_std(seen) ** 2 - np.median(others)) / np.median(unit))
    assert _level(seen, others, unit, 2.0 * float(plain)) == pytest.approx(LEVEL, rel=0.03)
    assert spread < 4.0 or plain > 1.1 * LEVEL
