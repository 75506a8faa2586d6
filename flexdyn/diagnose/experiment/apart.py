"""The difference between two hypotheses for a future motion, with the rival's numbers fitted again."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.experiment.reach import with_load
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.simulated.window_fit import slopes
from flexdyn.model.uncertain_parameters import FileNumber

NEW_MOTION_STEPS = 2
"""Number of Gauss-Newton steps with which a hypothesis is fitted to a new motion."""


@dataclass(frozen=True, eq=False)
class Known:
    """A hypothesis and the information of the present recordings about its numbers.

    Attributes:
        fitted: to these recordings.
        root: ``|root d|^2`` is the increase of chi^2, tolerances included, if the numbers differ by d from the best
            ones; columns as those of the fit's regression, without the first states of these recordings.
    """

    fitted: Fit
    root: Array

    @classmethod
    def of(cls, fitted: Fit) -> Known:
        """Information of a fit; it is reduced if more than noise is left."""
        X, bare = fitted.regression.with_priors, fitted.space.bare
        states = np.arange(X.shape[1] - bare.unknown.shape[1], X.shape[1])[bare.of_states]
        begun_first = np.hstack([X[:, states], np.delete(X, states, axis=1)])
        root = np.asarray(np.linalg.qr(begun_first, mode="r"))[len(states) :, len(states) :]
        return cls(fitted, root / np.sqrt(max(1.0, fitted.reduced)))

    @property
    def hypothesis(self) -> Hypothesis:
        """With the fitted numbers."""
        return self.fitted.hypothesis

    def loaded(self, mass: float) -> Known:
        """The same of the arm with a known payload [kg] at its tip."""
        hypothesis = dataclasses.replace(self.hypothesis, given=with_load(self.hypothesis.given, mass))
        return Known(dataclasses.replace(self.fitted, hypothesis=hypothesis), self.root)

    def marginal(self, count: int) -> Array:
        """The root for the first numbers (count, count), with the others free."""
        others = self.root.shape[1] - count
        turned = np.asarray(np.linalg.qr(np.roll(self.root, others, axis=1), mode="r"))
        return turned[others:, others:]


@dataclass(frozen=True, eq=False)
class Refit:
    """A hypothesis fitted to a motion; all rows are white and noise-free.

    Attributes:
        X: derivatives, then those of the previous information (rows, columns).
        y: residual, likewise.
        rows: number of rows that belong to the motion.
    """

    X: Array
    y: Array
    rows: int

    def left(self, passes: float) -> Array:
        """Its residuals in rows of the motion and of the previous information, if the motion is repeated (rows,)."""
        weight = np.ones(len(self.y))
        weight[: self.rows] = np.sqrt(passes)
        X, y = self.X * weight[:, None], self.y * weight
        scaled = X / _lengths(X)
        return np.asarray(y - scaled @ np.linalg.lstsq(scaled, y, rcond=1e-10)[0])

    def step(self) -> Array:
        """Steps of all numbers (columns,)."""
        scale = _lengths(self.X)
        return np.asarray(-np.linalg.lstsq(self.X / scale, self.y, rcond=1e-10)[0] / scale)

    def chi2(self, passes: float = 1.0) -> float:
        """Sum of squares of the residuals."""
        left = self._condensed.left(passes)
        return float(left @ left)

    @lazy
    def _condensed(self) -> Refit:
        """The same sums of squares with as many rows of the motion as there are columns, and one more."""
        R = np.asarray(np.linalg.qr(np.column_stack([self.X, self.y])[: self.rows], mode="r"))
        X, y = (np.concatenate([new, old[self.rows :]]) for new, old in ((R[:, :-1], self.X), (R[:, -1], self.y)))
        return Refit(X, y, len(R))


def _lengths(X: Array) -> Array:
    """Lengths of the columns (columns,); 1 of an empty one."""
    length = np.sqrt((X**2).sum(axis=0))
    return np.where(length > 0.0, length, 1.0)


def space_along(space: Workspace, numbers: Iterable[FileNumber], run: Measured) -> Workspace:
    """Equations along a simulated motion, with weights for the noise of a real recording.

    Args:
        space: of the recordings.
        numbers: of the file, which are fitted.
        run: the motion, without noise.
    """
    along = Equations(space.equations.model, (run,), space.equations.filters)
    return dataclasses.replace(weighed(Unweighted.of(along, space.noise, numbers)), beliefs=space.beliefs)


def refitted(known: Known, space: Workspace, steps: int = NEW_MOTION_STEPS) -> Refit:
    """Fit a hypothesis to a motion, with the previous information about its numbers; the best of a few steps.

    The offsets of its encoders start at their values in the present recordings.
    """
    first = known.hypothesis
    offsets = {effect.channel: effect.offset for effect in first.counts}
    known_offsets = np.array([offsets.get(name, 0.0) for name in space.bare.channels])
    counted = space.nuisance[:, : len(known_offsets)] @ known_offsets
    numbers, old = len(first.factors), np.array(known.fitted.scales)
    nuisances = space.nuisance.shape[1]
    current, found = first, []
    for _ in range(steps):
        made = linearised(current, space)
        ratio = np.ones(known.root.shape[1])
        ratio[numbers : numbers + len(old)] = np.array(made.scales) / old
        gone = np.concatenate([_distance(first, current, old), np.zeros(nuisances)])
        rows = made.regression
        refit = Refit(
            np.vstack([rows.X, known.root * ratio]), np.concatenate([rows.y + counted, known.root @ gone]), len(rows.y)
        )
        found.append(refit)
        current = moved(current, refit.step(), made.scales)
    return min(found, key=Refit.chi2)


def _distance(first: Hypothesis, now: Hypothesis, scales: Array) -> Array:
    """Displacements of the numbers, in units of the first scales."""
    factors = [now.factors[number] - factor for number, factor in first.factors.items()]
    pairs = zip(first.unknowns(), now.unknowns(), scales, strict=True)
    return np.array([*factors, *((getattr(b, m) - getattr(a, k)) / s for (a, k), (b, m), s in pairs)])


def windowed(known: Known, shot: Shot, worth: float | None = None) -> Refit:
    """A hypothesis over the windows of a motion, with the previous information about its numbers.

    Args:
        known: the hypothesis.
        shot: the windows, simulated with the hypothesis that made the motion.
        worth: sum of squares below which neither first states nor numbers are fitted; None: nothing is fitted.
    """
    here = known.hypothesis
    white = shot.whitened(None if worth is None else here.seen()).ravel()
    if worth is None or white @ white < worth:
        return Refit(np.zeros((len(white), 1)), white, len(white))
    shot = shoot(here.seen(), shot.windows)
    white = shot.whitened().ravel()
    J = slopes(here, shot, known.fitted.scales)
    root = known.marginal(J.shape[1])
    return Refit(np.vstack([J, root]), np.concatenate([white, np.zeros(len(root))]), len(white))
