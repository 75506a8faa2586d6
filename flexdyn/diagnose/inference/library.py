"""All candidates as columns: every effect at every place and grid point, and every number without its tolerance."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.equations.columns import of_parameter
from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import MOTOR, TOTAL, TRANSMISSION
from flexdyn.diagnose.equations.terms import of_joint, spring_torque
from flexdyn.diagnose.equations.users_laws import torque_of
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
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import CommandDelay, Effect, JointEffect, TorqueConstantError, registered

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
    def reference(self) -> Array:
        """Root mean square of what each equation is about: torque, or deflection (equations,).

        Computed positions have the torque's noise, which only the second filter takes off their accelerations.
        """
        motions, filters = self.equations.motions, self.equations.filters
        calm = filters.rows if self.equations.made_up.any() else np.asarray
        tau, needed, delta = (
            np.concatenate([calm(getattr(along, name)) for along in motions])
            for name in ("tau", "inverse_dynamics", "delta")
        )
        torque = np.sqrt(np.maximum((tau**2).mean(axis=0), (needed**2).mean(axis=0)))
        torque = np.maximum(torque, 1e-6 * max(float(torque.max()), 1e-300))
        kinds = self.equations.kinds
        return np.array([max(float(delta[:, j].std()), 1e-12) if k == TRANSMISSION else torque[j] for j, k in kinds])

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
        width, largest = len(raw), np.maximum(self._size(raw), [self._carried(*unit) for unit in proposal.units(point)])
        if not np.isfinite(largest).all() or (largest == 0.0).any() or not white.any(axis=(0, 2)).all():
            return None
        if proposal.fixed:
            cost = sum(self.log_jacobian(effect) for effect, _ in proposal.units(point))
            return Column(white, np.full(width, FIXED_SIZE_WIDTH), np.ones(width), np.ones(width, bool), largest, cost)
        scale = EFFECT_TORQUE_SHARE / np.maximum(largest, self._given_size(proposal, point, largest))
        scale = np.array([_natural(proposal.place["effect"], float(each)) for each in scale])
        signs = np.array([*proposal.positive, *[False] * width][:width])
        gained = self._rows_of(proposal.place["joint"]) if proposal.place["effect"] == TorqueConstantError.name else 0
        least = max(SMALLEST_TORQUE_SHARE, self._resolution(proposal.place) * float(largest.max()))
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
        share, least = self.size_of(effect, change)
        parts, size, mean, std, names = [self.whiten(change)], [share], [1.0], [FITTED_SIZE_WIDTH], []
        for each, name in self.start.unknowns():
            if each is not effect or (
                name == "harmonic" and getattr(effect, name) in natural(getattr(effect, name), self._ratio(proposal))
            ):
                continue
            scale = tangent_scale(effect, name)
            raw = scale * of_parameter(self.equations, effect, name, 0.1 * scale)
            largest = self._size(raw[None])[0]
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
        white, cost = np.stack(parts, axis=1), self.log_jacobian(effect)
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
            largest = float(self._size(raw[None])[0])
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

    def size_of(self, effect: Effect, change: Array, least: float = SMALLEST_TORQUE_SHARE) -> tuple[float, float]:
        """Share of its joint's torque that an effect has, and the one from which it is one [1].

        Args:
            effect: of which.
            change: of the residual by it (rows,).
            least: share of the torque below which an effect is none, whatever the encoders resolve [1].
        """
        share = max(float(self._size(change[None])[0]), self._carried(effect))
        angle = abs(float(getattr(effect, effect.position_error or "-", np.inf)))
        place = {key: str(getattr(effect, key)) for key in ("joint", "channel") if hasattr(effect, key)}
        return share, max(least, self._resolution({"effect": effect.name, **place}) / max(angle, 1e-300) * share)

    def _carried(self, effect: Effect, scale: float = 1.0) -> float:
        """Share of its joint's torque that a law of a transmission makes there, over `scale` [1].

        Where one of the two positions is computed, the rows have only what this does to the computed one. 0 elsewhere.
        """
        true = self.equations.true
        if not isinstance(effect, JointEffect) or effect.side != "transmission":
            return 0.0
        j = true.index(effect.joint)
        if not self.equations.made_up[j]:
            return 0.0
        others = [each for each in of_joint(true.all_effects, effect.joint) if each != effect]
        parts = [
            spring_torque(true, [*others, effect], along, j)[:, 0] - spring_torque(true, others, along, j)[:, 0]
            for along in self.equations.motions
        ]
        row = next(k for k, (i, _) in enumerate(self.equations.kinds) if i == j)
        return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)) / (self.reference[row] * scale))

    def _resolution(self, place: Mapping[str, str]) -> float:
        """Step of the encoders [rad or m] for effects on positions: what is smaller may be rounding; 0 for others."""
        signal, _, joint = place.get("channel", "").partition(".")
        if not registered()[place["effect"]].position_error or signal.startswith("tau"):
            return 0.0
        j = self.equations.true.index(place.get("joint") or joint)
        return float(np.sqrt(12.0) * max(self.noise.q[j], self.noise.theta[j]))

    def _ratio(self, proposal: Proposal) -> float:
        """Gear ratio of the joint that a proposal is about."""
        joints = self.equations.true.joints
        return abs(float(joints[proposal.joint].gear_ratio)) if proposal.joint in joints else 1.0

    def _given_size(self, proposal: Proposal, point: Point, else_: Array) -> Array:
        """Largest shares of a proposal's columns in the model as given (width,)."""
        if self.first is None:
            self.sizes[(tuple(sorted(proposal.place.items())), point)] = else_
            return else_
        return self.first.sizes.get((tuple(sorted(proposal.place.items())), point), else_)

    def _rows_of(self, joint: str) -> int:
        """Rows that a gain of a joint's torque scales: those that the recorded torque makes a position for.

        Elsewhere the column of a gain is made of the torque that the model needs, which has no noise of the record.
        """
        j = self.equations.true.index(joint)
        if not self.equations.made_up[j]:
            return 0
        which = [k for k, (i, kind) in enumerate(self.equations.kinds) if i == j and kind in (MOTOR, TOTAL)]
        return int((~self.mask.reshape(-1, len(self.equations.kinds))[:, which]).sum())

    def log_jacobian(self, effect: Effect) -> float:
        """Logarithm of how the applied torque changes with the recorded one, summed over the rows.

        The rows are measured in recorded torque. Where a law cuts it off, it may be anything beyond: its density is
        then one over its range, not one over its noise.
        """
        if isinstance(effect, TorqueConstantError):
            return self._rows_of(effect.joint) * float(np.log(max(1.0 + effect.gain, 0.01)))
        if not isinstance(effect, JointEffect) or effect.stage != "actuator" or isinstance(effect, CommandDelay):
            return 0.0
        j, total = self.equations.true.index(effect.joint), 0.0
        rows = [k for k, (i, kind) in enumerate(self.equations.kinds) if i == j and kind in (MOTOR, TOTAL)]
        floor = self.noise.tau[j] / self.reference[rows[0]]
        for along in self.equations.motions:
            at = self.equations.filters.instants(len(along.t))
            x, u, tau, t = along.theta[at, j], along.omega[at, j], along.tau[at, j], along.t[at]
            step = 1e-3 * float(self.reference[rows[0]])
            ahead, behind = (torque_of(effect, x, u, t=t, tau=tau + sign * step) for sign in (1.0, -1.0))
            slope = np.abs(ahead - behind) / (2.0 * step)
            total += float(np.log(np.clip(slope, floor, 1.0)).sum())
        return total

    def alone(self, effect: Effect) -> Library:
        """The library at the same numbers and no effect but one."""
        there = dataclasses.replace(self.start, effects=(effect,))
        return dataclasses.replace(self, equations=self.equations.of(there.model()), start=there)

    @lazy
    def sizes(self) -> dict[tuple[object, ...], Array]:
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

    def _size(self, raw: Array) -> Array:
        """Largest share of what an equation is about that columns have, (columns, rows) -> (columns,)."""
        table = raw.reshape(len(raw), -1, self._many)
        return np.asarray(
            (np.sqrt(np.einsum("kte,kte->ke", table, table) / table.shape[1]) / self.reference).max(axis=1)
        )

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
