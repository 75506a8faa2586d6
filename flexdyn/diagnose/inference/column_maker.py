"""The columns of one number of the file, or of one effect at its grid points, with the priors of their coefficients."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import EFFECT_TORQUE_SHARE, FIXED_SIZE_WIDTH, FREED_TOLERANCES, FREED_WIDTH
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.inference.candidate import Column
from flexdyn.diagnose.inference.catalogue import columns_of
from flexdyn.diagnose.inference.sizes import Sizes
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import Effect, registered


@dataclass(frozen=True, eq=False)
class ColumnMaker:
    """Makes the columns of candidates.

    Attributes:
        equations: of the start.
        work: weights by the sensors' noise, and the offsets of the encoders.
        start: the file's numbers where they stand, and the effects that were found.
        numbers: whitened columns of the file's numbers (rows, numbers).
        proposals: of effects that the model does not hold yet.
        first: the same at the model as given, whose torques scale the priors; None: this one.
        given_sizes: largest shares of the columns made so far.
    """

    equations: Equations
    work: Workspace
    start: Hypothesis
    numbers: Array
    proposals: tuple[Proposal, ...]
    first: ColumnMaker | None = None
    given_sizes: dict[tuple[object, ...], Array] = dataclasses.field(default_factory=dict, init=False)

    @lazy
    def sizes(self) -> Sizes:
        """How large effects are here."""
        return Sizes(self.equations, self.work.noise, self.work.whiten.mask)

    def always(self) -> Column:
        """The file's numbers, within their tolerance, and offsets of the encoders."""
        centre = 1.0 - np.array(list(self.start.factors.values()))
        std = np.concatenate([[max(n.tolerance, 1e-9) for n in self.start.factors], self.work.nuisance_sigma])
        mean = np.concatenate([centre, np.zeros(len(self.work.nuisance_sigma))])
        return Column.of(np.concatenate([self.numbers, self.work.nuisance], axis=1), self.many, std, mean)

    @property
    def many(self) -> int:
        """Equations."""
        return len(self.equations.kinds)

    def freed(self, k: int) -> Column:
        """One number of the file, not held by its tolerance."""
        number = list(self.start.factors)[k]
        std = FREED_WIDTH if number.tolerance < FREED_WIDTH else FREED_TOLERANCES * number.tolerance
        std = number.tolerance if number.trusted else std
        return Column.of(self.numbers[:, [k]], self.many, np.array([std]), size=np.ones(1))

    def columns(self, proposal: Proposal, point: Point) -> Column | None:
        """Of a proposal at a grid point; None where it does nothing there, or nothing finite."""
        width, times = len(proposal.units(point)), self.work.whiten.mask.size // self.many
        return self.of_points(proposal, (point,), np.empty((self.many, width, times), np.float32))[0]

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
        self.work.whiten.apart(np.concatenate(raw), white)
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
        """The columns of a proposal at a grid point, from plain and whitened rows; None where it does nothing."""
        sizes, width = self.sizes, len(raw)
        largest = np.maximum(sizes.largest(raw), [sizes.carried(*unit) for unit in proposal.units(point)])
        if not np.isfinite(largest).all() or (largest == 0.0).any() or not white.any(axis=(0, 2)).all():
            return None
        if proposal.fixed:
            cost = sum(sizes.log_jacobian(effect) for effect, _ in proposal.units(point))
            return Column(white, np.full(width, FIXED_SIZE_WIDTH), np.ones(width), np.ones(width, bool), largest, cost)
        scale = EFFECT_TORQUE_SHARE / np.maximum(largest, self._given_size(proposal, point, largest))
        scale = np.array([natural_spread(proposal.place["effect"], float(each)) for each in scale])
        signs = np.array([*proposal.positive, *[False] * width][:width])
        scales = registered()[proposal.place["effect"]].scales_torque
        gained = sizes.rows_of(proposal.place["joint"]) if scales else 0
        units = zip(proposal.units(point), largest.tolist(), strict=True)
        smallest = min(sizes.smallest(effect, size * most) for (effect, size), most in units)
        least = max(smallest, sizes.resolution(proposal.place) * float(largest.max()))
        return Column(white, scale, np.zeros(width), signs, largest, gained=gained, smallest=least)

    def gear_ratio(self, proposal: Proposal) -> float:
        """Gear ratio of the joint that a proposal is about."""
        joints = self.equations.true.joints
        return abs(float(joints[proposal.joint].gear_ratio)) if proposal.joint in joints else 1.0

    def _given_size(self, proposal: Proposal, point: Point, else_: Array) -> Array:
        """Largest shares of a proposal's columns in the model as given (width,)."""
        if self.first is None:
            self.given_sizes[(tuple(sorted(proposal.place.items())), point)] = else_
            return else_
        return self.first.given_sizes.get((tuple(sorted(proposal.place.items())), point), else_)

    def alone(self, effect: Effect) -> Self:
        """The same at the same numbers and no effect but one."""
        there = dataclasses.replace(self.start, effects=(effect,))
        return dataclasses.replace(self, equations=self.equations.of(there.model()), start=there)


def natural_spread(kind: str, of_drive: float) -> float:
    """Prior standard deviation of an effect's size: of the drive's torque, or by its nature if that is less.

    Errors of positions are as large as assembly makes them, however stiff the spring is on which they pull.
    """
    law = registered()[kind]
    if law.stage in ("sensor", "deflection") and math.isfinite(law.natural_size):
        return law.natural_size
    return min(of_drive, law.natural_size)
