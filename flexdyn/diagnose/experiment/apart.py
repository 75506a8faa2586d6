"""How far two hypotheses part over a motion that was not made yet, the rival's numbers fitted again."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.covariance import SampleNoise, whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.diagnose.hypothesis.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.effects import Payload, SensorOffset
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import FileNumber

Array = NDArray[np.float64]
NEW_MOTION_STEPS = 2
"""Gauss-Newton steps by which a hypothesis bends to a new motion."""


@dataclass(frozen=True, eq=False)
class Known:
    """A hypothesis and what the recordings made so far say about its numbers.

    Attributes:
        fitted: to them.
        root: with d the numbers' distance from the best ones, ``|root d|^2`` is what chi^2 grows by there, tolerances
            included; columns as those of the fit's regression.
    """

    fitted: Fit
    root: Array

    @classmethod
    def of(cls, fitted: Fit) -> Known:
        """Of a fit; where more than noise is left in it, it says less by as much."""
        rows = fitted.regression
        whole = np.vstack([rows.X, np.diag(1.0 / rows.sigma)])
        return cls(fitted, np.asarray(np.linalg.qr(whole, mode="r")) / np.sqrt(max(1.0, fitted.reduced)))

    def marginal(self, count: int) -> Array:
        """The root of the first numbers alone (count, count), whatever the others are."""
        others = self.root.shape[1] - count
        turned = np.asarray(np.linalg.qr(np.roll(self.root, others, axis=1), mode="r"))
        return turned[others:, others:]


@dataclass(frozen=True, eq=False)
class Refit:
    """A hypothesis bent to a motion; all rows are white and noise-free.

    Attributes:
        X: derivatives, then those of what is known (rows, columns).
        y: residual, likewise.
        rows: of them that are of the motion.
    """

    X: Array
    y: Array
    rows: int

    def left(self, passes: float = 1.0) -> Array:
        """What it leaves in rows of the motion and in what was known, the motion made so many times over (rows,)."""
        weight = np.ones(len(self.y))
        weight[: self.rows] = np.sqrt(passes)
        X, y = self.X * weight[:, None], self.y * weight
        length = np.sqrt((X**2).sum(axis=0))
        X = X / np.where(length > 0.0, length, 1.0)
        return np.asarray(y - X @ np.linalg.lstsq(X, y, rcond=1e-10)[0])

    def step(self) -> Array:
        """Of all numbers (columns,)."""
        length = np.sqrt((self.X**2).sum(axis=0))
        scale = np.where(length > 0.0, length, 1.0)
        return np.asarray(-np.linalg.lstsq(self.X / scale, self.y, rcond=1e-10)[0] / scale)

    def chi2(self, passes: float = 1.0) -> float:
        """Sum of squares of what is left."""
        left = self.left(passes)
        return float(left @ left)


def loaded(model: FlexibleJointModel, load: Payload | None) -> FlexibleJointModel:
    """The model of an arm that carries something known."""
    return model if load is None else model.replace(effects=[*model.effects, load])


def laden(hypothesis: Hypothesis, load: Payload | None) -> Hypothesis:
    """The same hypothesis about an arm that carries something known."""
    return dataclasses.replace(hypothesis, given=loaded(hypothesis.given, load))


def space_along(
    space: Workspace, numbers: Iterable[FileNumber], run: Measured, noise: SampleNoise, load: Payload | None = None
) -> Workspace:
    """Equations along a motion that was simulated, with weights as real noise will have them.

    Args:
        space: of the recordings.
        numbers: of the file, that may bend.
        run: the motion, without noise.
        noise: of its channels.
        load: that the arm carries.
    """
    along = Equations(loaded(space.equations.model, load), (run,), space.equations.filters)
    whiten = whitener(along, noise, sign_mask(along, noise))
    counts = [columns.of_effect(along, SensorOffset(name, offset=1e-6), 1e-6) for name in space.channels]
    slopes, nuisance = whiten(number_columns.of_numbers(along, list(numbers))), whiten(np.stack(counts, axis=1))
    return dataclasses.replace(space, equations=along, whiten=whiten, numbers=slopes, nuisance=nuisance)


def refitted(known: Known, space: Workspace, load: Payload | None = None, steps: int = NEW_MOTION_STEPS) -> Refit:
    """A hypothesis bent to a motion as far as what is known about its numbers lets it; the best of a few steps.

    Its encoders' offsets begin as the recordings made so far want them: a count more or less, as no law else may have.
    """
    first = laden(known.fitted.hypothesis, load)
    offsets = {effect.channel: effect.offset for effect in first.counts}
    counted = space.nuisance @ np.array([offsets.get(name, 0.0) for name in space.channels])
    numbers, old = len(first.factors), np.array(known.fitted.scales)
    nuisances = space.nuisance.shape[1]
    current, found = first, []
    for _ in range(steps):
        made = linearised(current, space)
        ratio = np.ones(known.root.shape[1])
        ratio[numbers : numbers + len(old)] = np.array(made.scales) / old
        gone = np.concatenate([_distance(first, current, old), np.zeros(nuisances)])
        rows = made.regression
        bent = Refit(
            np.vstack([rows.X, known.root * ratio]), np.concatenate([rows.y + counted, known.root @ gone]), len(rows.y)
        )
        found.append(bent)
        current = moved(current, bent.step(), made.scales)
    return min(found, key=Refit.chi2)


def _distance(first: Hypothesis, now: Hypothesis, scales: Array) -> Array:
    """How far numbers have been moved, in units of the first scales."""
    factors = [now.factors[number] - factor for number, factor in first.factors.items()]
    pairs = zip(first.unknowns(), now.unknowns(), scales, strict=True)
    return np.array([*factors, *((getattr(b, m) - getattr(a, k)) / s for (a, k), (b, m), s in pairs)])
