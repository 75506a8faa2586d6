"""Equations that leave more than noise: priors weigh against what is left."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.diagnose import selection
from flexdyn.diagnose.fitted import tempering
from flexdyn.diagnose.regression import Regression

ROWS, JOINTS = 20_000, 2


def left_over(rows: NDArray[np.float64]) -> Any:
    """What `tempering` reads of a fit that leaves these rows (times, joints)."""
    y = rows.ravel()
    nothing = Regression(y=y, X=np.zeros((y.size, 1)), centre=np.zeros(1), sigma=np.ones(1), rows=y.size)
    kinds = [(j, "total") for j in range(JOINTS)]
    return SimpleNamespace(
        regression=nothing, equations=SimpleNamespace(kinds=kinds), reduced=nothing.data_chi2 / y.size
    )


@pytest.fixture(scope="module")
def white() -> NDArray[np.float64]:
    """Independent rows of unit variance."""
    return np.random.default_rng(6).standard_normal((ROWS, JOINTS))


def test_noise_leaves_the_priors_alone(white: NDArray[np.float64]) -> None:
    """Data that is fitted to its noise, or nearly, is not treated in another way."""
    assert tempering(left_over(white)) == 1.0
    assert tempering(left_over(1.3 * white)) == 1.0


def test_white_rows_weigh_by_their_mean_square(white: NDArray[np.float64]) -> None:
    """Ten times the noise in every row, each independent of the others: a hundred times the prior."""
    assert tempering(left_over(10.0 * white)) == pytest.approx(100.0, rel=0.03)


def test_rows_alike_count_as_one(white: NDArray[np.float64]) -> None:
    """Every row ten times over says no more than one: the correlation time of a block of ten is ten rows."""
    blocks = np.repeat(white[: ROWS // 10], 10, axis=0)
    assert tempering(left_over(10.0 * blocks)) == pytest.approx(1000.0, rel=0.1)


@pytest.mark.parametrize(
    ("reduced", "median", "named", "least"),
    [
        (2.5, 0.7, 1, selection.SLIGHT * 1500.0),
        (1.5, 0.7, 1, 0.0),  # noise limits the equations
        (2.5, 5.0, 1, 0.0),  # windows say that more is missing
        (2.5, 0.7, 0, 0.0),  # the file's numbers may be bent
    ],
)
def test_beside_what_explains_windows_rough_equations_ask_for_more_than_a_little(
    reduced: float, median: float, named: int, least: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 1000 rows; what any law takes of what filters bend is not asked about."""
    asked = []

    def candidates(_space: Any, _screen: Any, _made: Any, least: float) -> list[Any]:
        asked.append(least)
        return []

    def stage(excess: float, names: int) -> Any:
        regression = SimpleNamespace(data_chi2=1000.0 * reduced, rows=1000)
        trial = SimpleNamespace(median=median, floor=1.0, excess=excess, count=np.array([1000.0]))
        fitted = SimpleNamespace(reduced=reduced, regression=regression)
        return SimpleNamespace(fitted=fitted, trial=trial, named=(None,) * names)

    search: Any = SimpleNamespace(say=lambda *_: None, space=None, screen=None, windows=None)
    monkeypatch.setattr(selection, "candidates", candidates)
    stages = [stage(1e6, 0), stage(1500.0, named)]
    selection.forward(search, stages)
    assert asked == [pytest.approx(least)]
    assert len(stages) == 2
