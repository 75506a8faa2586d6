"""All candidates as columns: every effect at every place and grid point, and every number without its tolerance."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.equations.columns import of_parameter
from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, kind_and_place
from flexdyn.diagnose.hypothesis.linear import tangent_scale
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal
from flexdyn.diagnose.inference.candidate import Candidate, Column, natural
from flexdyn.diagnose.inference.catalogue import columns_of
from flexdyn.diagnose.inference.priors import (
    EFFECT_TORQUE_SHARE,
    FITTED_SIZE_WIDTH,
    FIXED_SIZE_WIDTH,
    FREED_TOLERANCES,
    FREED_WIDTH,
    SMALLEST_TORQUE_SHARE,
    UNKNOWN_WIDTH,
)
from flexdyn.diagnose.inference.products import Products
from flexdyn.diagnose.inference.sizes import Sizes
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect, JointEffect, TorqueConstantError, registered

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
POINTS_AT_ONCE = 16
"""Grid points whose columns are made white at once: more would not be faster, and take memory."""


@dataclass(frozen=True, eq=False)
class Library:
    """Makes the columns of candidates.

    Attributes:
        equations: of the start.
        whiten: rows by the sensors' noise.
        start: the file's numbers where they stand, and the effects that were found.
        numbers: whitened columns of the file's numbers (rows, numbers).
        offsets: whitened columns of the encoders' offsets (rows, channels).
        offset_std: of their priors (channels,).
        proposals: of effects that the model does not hold yet.
        noise: of the channels.
        mask: rows that say nothing (rows,).
        first: the library at the model as given, whose torques scale the priors; None: this one.
    """

    equations: Equations
    whiten: Whitener
    start: Hypothesis
    numbers: Array
    offsets: Array
    offset_std: Array
    proposals: tuple[Proposal, ...]
    noise: SampleNoise
    mask: NDArray[np.bool_]
    first: Library | None = None

    @lazy
    def sizes(self) -> Sizes:
        """How large effects are here."""
        return Sizes(self.equations, self.noise, self.mask)

    def always(self) -> Column:
        """The file's numbers, within their tolerance, and offsets of the encoders."""
        names = tuple(self.start.factors)
        centre = 1.0 - np.array(list(self.start.factors.values()))
        std = np.concatenate([[max(n.tolerance, 1e-9) for n in names], self.offset_std])
        mean = np.concatenate([centre, np.zeros(len(self.offset_std))])
        return Column.of(np.concatenate([self.numbers, self.offsets], axis=1), self._many, std, mean)

    @property
    def _many(self) -> int:
        """Equations."""
        return len(self.equations.kinds)

    def freed(self, k: int) -> Column:
        """One number of the file, not held by its tolerance."""
        tolerance = list(self.start.factors)[k].tolerance
        std = FREED_WIDTH if tolerance < FREED_WIDTH else FREED_TOLERANCES * tolerance
        return Column.of(self.numbers[:, [k]], self._many, np.array([std]), size=np.ones(1))

    def columns(self, proposal: Proposal, point: Point) -> Column | None:
        """Of a proposal at a grid point; None where it does nothing there, or nothing finite."""
        width, times = len(proposal.units(point)), self.mask.size // self._many
        return self.of_points(proposal, (point,), np.empty((self._many, width, times), np.float32))[0]

    def of_points(
        self, proposal: Proposal, points: Sequence[Point], white: NDArray[np.float32], kept: int | None = None
    ) -> list[Column | None]:
        """Of a proposal at several grid points: rows of many columns are made white at once.

        Args:
            proposal: of which.
            points: of its grid.
            white: takes the rows (equations, columns of all points, rows of an equation).
            kept: where in `Products.X` that is; None: nowhere.
        """
        raw = [columns_of(self.equations, proposal, point) for point in points]
        self.whiten.apart(np.concatenate(raw), white)
        ends, found = np.cumsum([0, *(len(each) for each in raw)]).tolist(), []
        for point, each, (first, last) in zip(points, raw, itertools.pairwise(ends), strict=True):
            column = self._column(proposal, point, each, white[:, first:last])
            if column is None:
                white[:, first:last] = 0.0
            elif kept is not None:
                column = dataclasses.replace(column, kept=kept + first)
            found.append(column)
        return found

    def _column(self, proposal: Proposal, point: Point, raw: Array, white: NDArray[np.float32]) -> Column | None:
        sizes, width = self.sizes, len(raw)
        largest = np.maximum(sizes.largest(raw), [sizes.carried(*unit) for unit in proposal.units(point)])
        if not np.isfinite(largest).all() or (largest == 0.0).any() or not white.any(axis=(0, 2)).all():
            return None
        if proposal.fixed:
            cost = sum(sizes.log_jacobian(effect) for effect, _ in proposal.units(point))
            return Column(white, np.full(width, FIXED_SIZE_WIDTH), np.ones(width), np.ones(width, bool), largest, cost)
        scale = EFFECT_TORQUE_SHARE / np.maximum(largest, self._given_size(proposal, point, largest))
        scale = np.array([_natural(proposal.place["effect"], float(each)) for each in scale])
        signs = np.array([*proposal.positive, *[False] * width][:width])
        gained = sizes.rows_of(proposal.place["joint"]) if proposal.place["effect"] == TorqueConstantError.name else 0
        least = max(SMALLEST_TORQUE_SHARE, sizes.resolution(proposal.place) * float(largest.max()))
        return Column(white, scale, np.zeros(width), signs, largest, gained=gained, smallest=least)

    def standing(
        self, effect: Effect, proposal: Proposal, belief: Callable[[Effect, str], tuple[float, float]]
    ) -> tuple[Column, list[str]]:
        """An effect of the start: its present torque, which may be absent, and the tangents of its parameters.

        A parameter that makes it large is ``N(neutral, (share of the drive)^2)``, so its tangent's coefficient has the
        mean ``neutral - value``. Of others, such as a phase, nothing is known but that the change is no larger than the
        effect may be: the prior of a sine and a cosine of equal width. A harmonic that is a whole number stays.

        Returns:
            the columns, and the names of the parameters that have tangents.
        """
        others = tuple(each for each in self.start.effects if each is not effect)
        without = self.equations.of(dataclasses.replace(self.start, effects=others).model())
        change = self.equations.residual - without.residual
        share, least = self.sizes.of(effect, change)
        parts, size, mean, std, names = [self.whiten(change)], [share], [1.0], [FITTED_SIZE_WIDTH], []
        for each, name in self.start.unknowns():
            if each is not effect or (
                name == "harmonic" and getattr(effect, name) in natural(getattr(effect, name), self._ratio(proposal))
            ):
                continue
            scale = tangent_scale(effect, name)
            raw = scale * of_parameter(self.equations, effect, name, 0.1 * scale)
            largest = self.sizes.largest(raw[None])[0]
            if not np.isfinite(largest) or largest == 0.0:
                continue
            off, spread = belief(effect, name)
            parts.append(self.whiten(raw))
            size.append(largest)
            std.append(spread / scale)
            mean.append(off / scale if np.isfinite(spread) else 0.0)
            names.append(name)
        most = max((d * s for d, s in zip(std[1:], size[1:], strict=True) if np.isfinite(d)), default=np.inf)
        std = [min(d, most / s if np.isinf(d) else d, UNKNOWN_WIDTH) for d, s in zip(std, size, strict=True)]
        white, cost = np.stack(parts, axis=1), self.sizes.log_jacobian(effect)
        return Column.of(white, self._many, np.array(std), np.array(mean), np.array(size), cost, least), names

    def belief(self, effect: Effect, name: str) -> tuple[float, float]:
        """Prior of a parameter: how far its centre is from its value, and its standard deviation, in its unit.

        A parameter that makes the effect large is ``N(neutral, (share of the drive)^2)``; one that the grid is of is
        log-normal about the grid's middle, half its range wide; of others nothing is known.
        """
        value, nothing = getattr(effect, name), effect.neutral.get(name)
        if nothing is not None and np.isfinite(nothing):
            scale = tangent_scale(effect, name)
            raw = of_parameter(self.equations, effect, name, 0.1 * scale)
            largest = float(self.sizes.largest(raw[None])[0])
            spread = _natural(effect.name, EFFECT_TORQUE_SHARE / largest) if 0.0 < largest < np.inf else np.inf
            return (float(nothing) - value, spread) if np.isfinite(spread) else (0.0, np.inf)
        proposal = next(p for p in self.proposals if p.is_of(effect))
        if name not in proposal.axes or len(proposal.grid) < 2 or value <= 0.0:
            return 0.0, np.inf
        grid = [point[proposal.axes.index(name)] for point in proposal.grid]
        if min(grid) <= 0.0:
            return 0.0, np.inf
        low, high = float(np.log(min(grid))), float(np.log(max(grid)))
        return -value * (float(np.log(value)) - 0.5 * (low + high)), value * max(0.5 * (high - low), 0.1)

    def _ratio(self, proposal: Proposal) -> float:
        """Gear ratio of the joint that a proposal is about."""
        joints = self.equations.true.joints
        return abs(float(joints[proposal.joint].gear_ratio)) if proposal.joint in joints else 1.0

    def _given_size(self, proposal: Proposal, point: Point, else_: Array) -> Array:
        """Largest shares of a proposal's columns in the model as given (width,)."""
        if self.first is None:
            self.given_sizes[(tuple(sorted(proposal.place.items())), point)] = else_
            return else_
        return self.first.given_sizes.get((tuple(sorted(proposal.place.items())), point), else_)

    def alone(self, effect: Effect) -> Library:
        """The library at the same numbers and no effect but one."""
        there = dataclasses.replace(self.start, effects=(effect,))
        return dataclasses.replace(self, equations=self.equations.of(there.model()), start=there)

    @lazy
    def given_sizes(self) -> dict[tuple[object, ...], Array]:
        """Largest shares of the columns made so far."""
        return {}

    def beliefs(self, effects: tuple[Effect, ...]) -> Callable[[Effect, str], tuple[float, float]]:
        """Priors of effects' parameters, those that need a column taken once, where the effects stand."""
        at = self.first or self
        known: dict[tuple[object, ...], tuple[float, float]] = {}
        for effect in effects:
            for entry in effect.parameters():
                nothing = effect.neutral.get(entry.name)
                if nothing is not None and np.isfinite(nothing):
                    known[(*kind_and_place(effect), entry.name)] = (float(nothing), at._spread(effect, entry.name))

        def belief(effect: Effect, name: str) -> tuple[float, float]:
            place = (*kind_and_place(effect), name)
            if place in known:
                return known[place][0] - getattr(effect, name), known[place][1]
            return self.belief(effect, name)

        return belief

    def _spread(self, effect: Effect, name: str) -> float:
        """Prior standard deviation of a parameter that makes an effect large."""
        true = self.equations.true
        if isinstance(effect, JointEffect) and effect.takes_load and not true.elastic[true.index(effect.joint)]:
            column = self.columns(next(p for p in self.proposals if p.is_of(effect)), ())
            return np.inf if column is None else float(column.std[0])
        return self.alone(effect).belief(effect, name)[1]

    @property
    def _open(self) -> list[Proposal]:
        """Proposals of effects that the start does not hold."""
        return [p for p in self.proposals if not any(p.is_of(effect) for effect in self.start.effects)]

    def most_columns(self) -> int:
        """Columns that all candidates and every structure have, at most."""
        numbers = 2 * int(self.numbers.shape[1]) + int(self.offsets.shape[1]) + len(self.start.effects)
        tangents = len(self.start.unknowns())
        laws = [len(p.units(point)) for p in self._open for point in p.grid]
        plain = [len(p.units(p.grid[0])) for p in self._open if len(p.grid) == 1]  # small amounts of every law
        return numbers + 2 * tangents + sum(laws) + sum(plain)

    def candidates(self, products: Products) -> tuple[list[Candidate], list[Column]]:
        """All of them, with the columns of their grids in the order of their places; many are written into products."""
        first = self.numbers.shape[1] + self.offsets.shape[1]
        found, columns = [], []
        for k, number in enumerate(self.start.factors):
            found.append(Candidate(number.parameter, None, number, [()], [np.array([first])], 1))
            columns.append(self.freed(k))
            first += 1
        belief = self.beliefs(self.start.effects)
        for effect in self.start.effects:
            proposal = next(p for p in self.proposals if p.is_of(effect))
            column, estimated = self.standing(effect, proposal, belief)
            place = first + np.arange(len(column.std))
            first += len(column.std)
            choices = 1 if set(estimated) & set(proposal.axes) else len(proposal.grid)  # a tangent has a prior itself
            ratio, tangents = self._ratio(proposal), tuple(estimated)
            found.append(Candidate(effect.name, proposal, None, [()], [place], choices, effect, ratio, tangents))
            columns.append(column)
        jobs = []
        for p in (open_ := self._open):
            for k in range(0, len(p.grid), POINTS_AT_ONCE):
                some = p.grid[k : k + POINTS_AT_ONCE]
                width = sum(len(p.units(point)) for point in some)
                begin = products.reserve(width)
                jobs.append((p, some, products.X[:, begin : begin + width], begin))
        made = itertools.chain.from_iterable(abreast(lambda job: self.of_points(*job), jobs))
        for proposal in open_:
            pairs = [(point, next(made)) for point in proposal.grid]
            kept = [(point, each) for point, each in pairs if each is not None]
            if not kept:
                continue
            places = []
            for _, column in kept:
                places.append(first + np.arange(len(column.std)))
                first += len(column.std)
                columns.append(column)
            kind = proposal.place["effect"]
            ratio = self._ratio(proposal)
            points = [point for point, _ in kept]
            found.append(Candidate(kind, proposal, None, points, places, len(kept), ratio=ratio))
        return found, columns


def _natural(kind: str, of_drive: float) -> float:
    """Prior standard deviation of an effect's size: of the drive's torque, or by its nature if that is less.

    Errors of positions are as large as assembly makes them, however stiff the spring is on which they pull.
    """
    law = registered()[kind]
    if law.stage in ("sensor", "deflection") and math.isfinite(law.natural_size):
        return law.natural_size
    return min(of_drive, law.natural_size)
