"""Slopes of simulated windows by every number: what a Gauss-Newton step on them takes, and their spread."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.gap import Shot
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.linear import LOOSE
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.effects import Effect
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
Known = Mapping[FileNumber, tuple[float, Array]]
ROBUST = 3.0
"""Surprises of more standard deviations than this weigh less (Cauchy)."""
STEP = 2e-3
"""Relative step of the differences."""
AS_FAR = 0.03
"""Difference of a number's factors up to which the residuals' slopes by it are the same."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Of the surprises, with what weighs them.

    Attributes:
        J: slopes (surprises, numbers + unknowns).
        weight: of the surprises, robust (surprises,).
        prior: 1/sigma^2 of the numbers, 0 of the unknowns (numbers + unknowns,).
        scales: of the unknowns.
        of_numbers: of the residuals by the file's numbers, with the factor at which they were taken
            (windows, rows, channels).
    """

    J: Array
    weight: Array
    prior: Array
    scales: tuple[float, ...]
    of_numbers: Known = field(repr=False)

    @lazy
    def _inverse(self) -> Array:
        H = (self.J * self.weight[:, None]).T @ self.J + np.diag(self.prior)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-300))
        return np.asarray(scale[:, None] * np.linalg.pinv(scale[:, None] * H * scale, rcond=1e-10) * scale)

    def step(self, shot: Shot, at: Hypothesis) -> Array:
        """From a hypothesis and its surprises (numbers + unknowns,)."""
        return np.asarray(-self._inverse @ self._uphill(shot, at))

    def promised(self, shot: Shot, at: Hypothesis) -> float:
        """Drop of the cost that the step promises."""
        uphill = self._uphill(shot, at)
        return float(uphill @ self._inverse @ uphill)

    def _uphill(self, shot: Shot, at: Hypothesis) -> Array:
        """Half the slope of the cost (numbers + unknowns,)."""
        off = np.zeros(len(self.prior))
        off[: len(at.factors)] = np.array(list(at.factors.values())) - 1.0
        return np.asarray(self.J.T @ (self.weight * shot.whitened().ravel()) + self.prior * off)

    def std(self, shot: Shot) -> Array:
        """Standard deviations from the sandwich of windows' gradients (numbers + unknowns,).

        At least those of white surprises: where a few windows hold all that is known, their spread says little.
        """
        surprises = shot.whitened()
        each = self.J * (self.weight * surprises.ravel())[:, None]
        by_window = each.reshape(len(surprises), -1, self.J.shape[1]).sum(axis=1)
        by_window -= by_window.mean(axis=0)
        meat = by_window.T @ by_window + np.diag(self.prior)
        spread = np.sqrt(
            np.maximum(np.diag(self._inverse @ meat @ self._inverse), np.diag(self._inverse).clip(min=0.0))
        )
        return np.asarray(spread * np.concatenate([np.ones(len(spread) - len(self.scales)), np.array(self.scales)]))


def slopes_of(
    hypothesis: Hypothesis, shot: Shot, temper: float, progress: Callable[[float], None] | None, known: Known
) -> Slopes:
    """Slopes of the surprises: one column a factor, then one an unknown, in units of its scale.

    Args:
        hypothesis: whose windows were simulated.
        shot: these windows.
        temper: factor on the priors.
        progress: called with the share that is done.
        known: slopes of the residuals by the file's numbers, each with the factor at which it was taken.
    """
    unknowns = hypothesis.unknowns()
    scales = tuple(size(effect, name) for effect, name in unknowns)
    count = len(hypothesis.factors) + len(unknowns)
    of_numbers: dict[FileNumber, tuple[float, Array]] = {}
    columns: list[Array] = []

    def kept(slope: Array) -> None:
        white = shot.whitened_change(slope).ravel()
        columns.append(np.where(np.isfinite(white), white, 0.0))  # windows that cannot be simulated do not tell
        if progress is not None:
            progress(len(columns) / count)

    for number, factor in hypothesis.factors.items():
        if number in known and abs(known[number][0] - factor) <= AS_FAR:
            of_numbers[number] = known[number]
        else:
            stepped = dataclasses.replace(hypothesis, factors={**hypothesis.factors, number: factor + STEP})
            of_numbers[number] = factor, _slope(shot, stepped.seen())
        kept(of_numbers[number][1])
    for (effect, name), scale in zip(unknowns, scales, strict=True):
        moved = effect.replace(**{name: getattr(effect, name) + STEP * scale})
        effects = tuple(moved if e is effect else e for e in hypothesis.effects)
        kept(_slope(shot, dataclasses.replace(hypothesis, effects=effects).seen()))
    prior = priors(hypothesis, len(scales), temper)
    return Slopes(np.stack(columns, axis=1), weights(shot.whitened()), prior, scales, of_numbers)


def _slope(shot: Shot, stepped: FlexibleJointModel) -> Array:
    """Of the residuals (windows, rows, channels) by what was moved by STEP."""
    return (shot.residual_of(stepped) - shot.residual) / STEP


def size(effect: Effect, name: str) -> float:
    """Of a parameter, by which its steps are measured."""
    value = abs(getattr(effect, name))
    if name in ("phase", "rest", "lower", "upper"):
        return 1.0
    return value if value > 0.0 else 1e-3


def weights(surprises: Array) -> Array:
    """Of surprises, robust (surprises,) [1]."""
    return np.asarray(1.0 / (1.0 + (surprises.ravel() / ROBUST) ** 2))


def priors(hypothesis: Hypothesis, unknowns: int, temper: float) -> Array:
    """1/sigma^2 of the file's numbers, 0 of the unknowns (numbers + unknowns,)."""
    sigma = np.array([LOOSE if n in hypothesis.freed else max(n.tolerance, 1e-9) for n in hypothesis.factors])
    return np.concatenate([temper / sigma**2, np.zeros(unknowns)])
