"""The evidence of structures under a model error: their likelihood, their prior and the sizes of their effects."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy.special import log_ndtr

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.inference.candidate_matrix import CandidateMatrix
from flexdyn.diagnose.inference.evidence import NEGATIVE_SIGMAS
from flexdyn.diagnose.inference.gram import Estimate, Gram
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.model_error import ModelError, Seen
from flexdyn.diagnose.inference.structure_prior import PriorOfPlaces, log_harmonic
from flexdyn.diagnose.inference.torque_shares import share_apart, torque_share
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect, JointEffect

Structure = frozenset[tuple[int, int]]
"""Candidates that a structure holds, each with its grid point."""
Identities = frozenset[tuple[object, ...]]
"""Kind and place of every candidate of a structure."""


class Space:
    """Structures of candidates, compared by their evidence under a model error.

    Args:
        library: that makes the columns.
        rows: what the start leaves, white but for the model error (rows,).
        seen: rows that say something.
        noise_in_slopes: share of the rows' noise that their slopes contain (equations,) [1]; None: all of it.
    """

    def __init__(self, library: Library, rows: Array, seen: Seen, noise_in_slopes: Array | None = None) -> None:
        self.library, self.seen = library, seen
        self.noise_in_slopes = np.ones(seen.valid.shape[1]) if noise_in_slopes is None else noise_in_slopes
        self.matrix = CandidateMatrix(library, rows, seen)
        self.candidates = self.matrix.candidates
        self.places = PriorOfPlaces(self.candidates)

    def under(self, noise: ModelError) -> None:
        """Compare under a model error from now on."""
        self.noise = noise
        self.known: dict[Structure, float] = {}
        self._points: dict[tuple[int, int], float] = {}
        self.weigh(noise)

    def forget(self) -> None:
        """Drop the columns; what was compared stays known."""
        del self.matrix.products, self.gram

    def weigh(self, noise: ModelError) -> None:
        """Take coefficients under the weights of another model error; how many rows tell one thing stays."""
        weights = 1.0 / (noise.scale**2 * self.noise.times)
        self.gram = Gram(self.matrix.products, weights, self.matrix.prior, self.matrix.base)

    def tempered(self, column: int) -> float:
        """Independent pieces of evidence in a row of the equation that a column is about most [1]."""
        return 1.0 / float(self.noise.times[self.matrix.of[column]])

    def grow(self, c: int, point: tuple[float, ...]) -> int | None:
        """Another grid point of a candidate; its place, or None where it does nothing."""
        candidate = self.candidates[c]
        if candidate.proposal is None:
            return None
        if point in candidate.points:
            return candidate.points.index(point)
        column = self.library.columns(candidate.proposal, point)
        if column is None or not self.matrix.add(candidate, point, column):
            return None
        self.gram.grow()
        return len(candidate.points) - 1

    def identities(self, structure: Structure) -> Identities:
        """Kinds and places of a structure's candidates, which are the same in the spaces of all linearisations."""
        return frozenset(self.candidates[c].identity for c, _ in structure)

    def having(self, identities: Identities) -> frozenset[int]:
        """Candidates of these kinds and places, as far as they are in this space."""
        return frozenset(c for c, each in enumerate(self.candidates) if each.identity in identities)

    def columns(self, structure: Structure) -> Indices:
        """Columns of a structure's candidates (k,)."""
        parts = [self.candidates[c].columns[p] for c, p in sorted(structure)]
        return np.concatenate([np.zeros(0, np.intp), *parts]).astype(np.intp)

    def estimate(self, structure: Structure) -> Estimate:
        """The posterior of a structure's coefficients, of its own columns alone."""
        return self.gram.estimate(self.columns(structure))

    def value(self, structure: Structure) -> float:
        """Log posterior of a structure, not normalised, the size of its model error the most likely one; remembered."""
        if structure not in self.known:
            own = self.estimate(structure)
            rest = self.log_volume(structure, own) + self.log_large(structure, own)
            self.known[structure] = self.log_density(own) + rest
        return self.known[structure]

    def log_density(self, own: Estimate) -> float:
        """Log likelihood of what a structure leaves at its best numbers, and of the priors at these.

        Args:
            own: its posterior, of its own columns alone.
        """
        columns, mean = self.gram.with_base(own)
        prior = self.matrix.prior
        off = mean - prior.mean[columns]
        squares = self.gram.squares(own)
        return self.noise.log_likelihood(squares) - 0.5 * float(off @ (prior.precision[columns] * off))

    def log_volume(self, structure: Structure, own: Estimate | None = None) -> float:
        """What a structure's posterior has beside likelihood and priors at the best numbers: Occam's factor.

        Sizes of effects do not count here: whether they are large enough is a matter of the data that measure them.

        Args:
            structure: candidates with their grid points.
            own: its coefficients; None: they are estimated.
        """
        own = own or self.estimate(structure)
        return own.log_volume + self.log_prior(structure) + self._log_positive(structure, own)

    def _log_positive(self, structure: Structure, own: Estimate) -> float:
        """Log probability that masses, stiffnesses, dampings and levels of the file are positive, less that before.

        Only of numbers that are so little known that the normal prior does not say so.
        """
        loose = [k for k in self.loose if (k, 0) not in structure]
        if not loose:
            return 0.0
        mean, spread = self.gram.of_base(own, np.array(loose, np.intp))
        numbers = list(self.library.start.factors.items())
        start = np.array([numbers[k][1] for k in loose])
        tolerance = np.array([numbers[k][0].tolerance for k in loose])
        return float((log_ndtr((start + mean) / spread) - log_ndtr(1.0 / tolerance)).sum())

    @lazy
    def loose(self) -> tuple[int, ...]:
        """Positive numbers of the file whose prior reaches below zero: their places."""
        numbers = enumerate(self.library.start.factors)
        return tuple(k for k, n in numbers if n.tolerance * NEGATIVE_SIGMAS > 1.0 and not n.signed)

    def log_large(self, structure: Structure, own: Estimate) -> float:
        """Log probability that every effect is large enough to be one: the prior leaves out negligible sizes.

        Masses, stiffnesses and levels of the file have factors, which are positive; those of signed numbers may not be.
        """
        if not structure:
            return 0.0
        points, matrix, total = sorted(structure), self.matrix, 0.0
        blocks = [self.candidates[c].columns[p] for c, p in points]
        first = np.cumsum([0, *map(len, blocks)])
        weight, variance = matrix.size[own.columns], np.diag(own.covariance)
        share = np.sqrt(np.add.reduceat((weight * own.mean) ** 2, first[:-1]))
        spread = np.sqrt(np.add.reduceat(weight**2 * variance, first[:-1]))
        least = matrix.smallest[own.columns[first[:-1]]]
        for k, (c, _) in enumerate(points):
            candidate, columns, here = self.candidates[c], blocks[k], slice(first[k], first[k + 1])
            if (number := candidate.number) is not None:
                share[k] = math.inf if number.signed else self.library.start.factors[number] + own.mean[first[k]]
                spread[k], least[k] = math.sqrt(variance[first[k]]), 0.0
                continue
            if matrix.gained[columns[0]] > 0.0:
                # The rows are in applied torque: those of recorded torque have the density of (1 + gain) times as much.
                rows = matrix.gained[columns[0]] * self.tempered(columns[0])
                total += self._in_slopes(c) * rows * math.log(max(1.0 + float(own.mean[first[k]]), 0.01))
            if candidate.stands is not None:
                share[k] = torque_share(candidate, weight[here], own.mean[here])
            if plain := [self.candidates[other].columns[0] for other in self.contained[c]]:
                # It must be large by itself, beyond what a plainer law can do.
                share[k] *= share_apart(self.gram, columns, own.mean[here], plain)
        return total + float(log_ndtr((share - least) / np.maximum(spread, 1e-12)).sum())

    @lazy
    def contained(self) -> dict[int, tuple[int, ...]]:
        """The plainer laws at the same place that each candidate contains."""
        plain = [
            [k for k, other in enumerate(self.candidates) if other.kind in each.law.plainer and other.spot == each.spot]
            for each in self.candidates
        ]
        return {c: tuple(k for k in inside if self.candidates[k].stands is None) for c, inside in enumerate(plain)}

    def best(self) -> Structure:
        """The most likely of those compared."""
        return max(self.known, key=lambda s: (self.known[s], sorted(s)))

    def log_prior(self, structure: Structure) -> float:
        """Log prior of a structure; the points of a candidate's grid are equally likely."""
        return self.places.log_prior(structure) + sum(self._log_point(*each) for each in sorted(structure))

    def _log_point(self, c: int, p: int) -> float:
        """Log prior of a grid point, and what it costs; remembered."""
        if (c, p) not in self._points:
            candidate = self.candidates[c]
            likely = log_harmonic(candidate, p) - math.log(candidate.choices)
            self._points[c, p] = self.costs(c, p) + likely
        return self._points[c, p]

    def costs(self, c: int, p: int) -> float:
        """What a law that forgets the recorded torque costs."""
        column = int(self.candidates[c].columns[p][0])
        return float(self.matrix.cost[column]) * self.tempered(column) * self._in_slopes(c)

    def log_gained(self, effects: Iterable[Effect]) -> float:
        """Log density of recorded torque over that of applied torque by gains among some effects, for fits.

        The residuals of fits have the noise of the recorded torque times 1 + gain. Here is what the linear equations do
        not count of it, because their slopes lack that noise.
        """
        return sum(
            self.library.sizes.log_jacobian(effect)
            * self.tempered(int(each.columns[0][0]))
            * (1.0 - self._in_slopes(c))
            for effect in effects
            for c, each in enumerate(self.candidates)
            if isinstance(effect, JointEffect)
            and effect.scales_torque
            and (each.kind, each.place.get("joint")) == (effect.name, effect.joint)
        )

    def _in_slopes(self, c: int) -> float:
        """Share of the noise that a candidate scales which the slopes contain [1]: only a gain scales all of it."""
        candidate = self.candidates[c]
        if not candidate.law.scales_torque:
            return 1.0
        return float(self.noise_in_slopes[self.matrix.of[int(candidate.columns[0][0])]])

    def left(self, structure: Structure) -> Array:
        """What a structure leaves, white but for the model error (rows,)."""
        columns, mean = self.gram.with_base(self.estimate(structure))
        products = self.matrix.products
        return np.asarray((products.sum(columns, mean) - products.y).T.ravel())
