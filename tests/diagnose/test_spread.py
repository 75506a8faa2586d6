"""How noise spreads through a window."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from flexdyn.diagnose.shooting import spread


def test_exponentials_of_stiff_arms_are_those_of_scipy() -> None:
    """Springs of 1e5 N m/rad on light links beside slow joints: rows of very different size."""
    draw = np.random.default_rng(0)
    stack = np.zeros((6, 5, 6, 6))
    stack[..., :2, 2:4] = np.eye(2)
    stack[..., 2, 0] = -1e6 * draw.uniform(0.1, 1.0, (6, 5))
    stack[..., 3, 1] = -2.0
    stack[..., 2:4, 2:4] = draw.normal(0.0, 5.0, (6, 5, 2, 2))
    stack[..., 2:4, 4:] = 30.0 * draw.standard_normal((6, 5, 2, 2))
    found = spread._exponential(0.0025 * stack)
    for one, matrix in zip(found.reshape(-1, 6, 6), stack.reshape(-1, 6, 6), strict=True):
        exact = expm(0.0025 * matrix)
        np.testing.assert_allclose(one, exact, rtol=1e-6, atol=1e-7 * np.abs(exact).max())


def test_what_explodes_is_cut_off() -> None:
    """A motion that grows by more than a double holds has a response that is large and finite."""
    found = spread._exponential(np.full((1, 1, 2, 2), 1e5))
    assert np.isfinite(found).all()
    assert np.abs(found).max() == spread.LARGEST_SLOPE
