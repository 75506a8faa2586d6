"""One thing that may be missing, and its columns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.diagnose.constants import SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal
from flexdyn.diagnose.inference.priors import EVERY_MOTOR
from flexdyn.effects import Effect, registered
from flexdyn.model.uncertain_parameters import FileNumber


@dataclass(eq=False)
class Candidate:
    """One effect at one place, or one number of the file whose tolerance is wrong.

    Attributes:
        kind: of the effect, or the parameter's name.
        proposal: of the effect; None for a number.
        number: None for an effect.
        points: of the grid, then those that were found between them.
        columns: of the matrix, for every point (width,) each.
        choices: points of the grid, between which the prior is even.
        stands: the effect that the linearisation is at, one point; None: candidates that are not in it.
        ratio: of its joint's gear [1].
        tangents: parameters of the effect that stands whose tangents follow its first column.
    """

    kind: str
    proposal: Proposal | None
    number: FileNumber | None
    points: list[Point]
    columns: list[Indices]
    choices: int
    stands: Effect | None = None
    ratio: float = 1.0
    tangents: tuple[str, ...] = ()

    @cached_property
    def place(self) -> dict[str, str]:
        """Where it acts."""
        if self.proposal is not None:
            return dict(self.proposal.place)
        return {} if self.number is None else {"of": self.number.of, "parameter": self.number.parameter}

    @cached_property
    def spot(self) -> tuple[str | None, str | None]:
        """Joint and side on which it acts."""
        return self.place.get("joint"), self.place.get("side")

    @cached_property
    def identity(self) -> tuple[object, ...]:
        """Kind and place, whatever its numbers are."""
        return (self.kind, *sorted(self.place.items()))

    @cached_property
    def law(self) -> type[Effect]:
        """What its class declares; that of any effect for a number of the file."""
        return registered().get(self.kind, Effect)

    @property
    def group(self) -> str:
        """Kind, by which places are counted; what every motor has is a kind of its own on the motor's side."""
        plain = self.law.prevalence == "everywhere" and self.place.get("side") == "motor"
        return f"{EVERY_MOTOR} {self.kind}" if plain else self.kind

    @cached_property
    def moved_axes(self) -> tuple[int, ...]:
        """Places of the nonlinear numbers that may lie between the grid's points: cycles, and those that fits move."""
        axes = () if self.proposal is None else self.proposal.axes
        return tuple(k for k, name in enumerate(axes) if name == self.law.cycles or name in self.law.moved_axes())

    @property
    def width(self) -> int:
        """Linear numbers."""
        return len(self.columns[0])

    def natural(self, harmonic: float) -> list[float]:
        """The whole number, and the whole number of motor turns, nearest to a harmonic."""
        return natural(harmonic, self.ratio)

    def effect(self, point: int, values: Array) -> Effect | None:
        """The effect with these linear numbers; None where they make no sense, or for a number."""
        return None if self.proposal is None else self.proposal.make(self.points[point], values)


@dataclass(frozen=True, eq=False)
class Column:
    """Columns of one candidate at one grid point.

    Attributes:
        apart: derivatives of the residual, white but for the model error, the equations one after another (equations,
            width, rows of an equation); in single precision, as they are many.
        std: of the coefficients' priors (width,).
        mean: of the priors (width,).
        positive: coefficients that may not be negative (width,).
        size: root mean square torque of each column, as a share of its joint's (width,).
        log_jacobian: what a law that forgets the recorded torque costs (see `Sizes.log_jacobian`).
        gained: rows that a gain of the torque scales, if the coefficient is one.
        smallest: share of its joint's torque from which an effect is one [1].
        kept: where in `Products.X` the rows have been written; None: nowhere.
    """

    apart: NDArray[np.float32]
    std: Array
    mean: Array
    positive: Flags
    size: Array
    log_jacobian: float = 0.0
    gained: int = 0
    smallest: float = SMALLEST_TORQUE_SHARE
    kept: int | None = None

    @classmethod
    def of(
        cls,
        white: NDArray[np.floating],
        equations: int,
        std: Array,
        mean: Array | None = None,
        size: Array | None = None,
        log_jacobian: float = 0.0,
        smallest: float = SMALLEST_TORQUE_SHARE,
    ) -> Column:
        """Of white rows (rows of all equations, width), the coefficients free of bounds."""
        apart = white.reshape(-1, equations, white.shape[1]).transpose(1, 2, 0).astype(np.float32, order="C")
        mean, size = (np.zeros(len(std)) if each is None else each for each in (mean, size))
        return cls(apart, std, mean, np.zeros(len(std), bool), size, log_jacobian, smallest=smallest)

    @property
    def white(self) -> NDArray[np.float32]:
        """The derivatives (rows of all equations, width)."""
        return self.apart.transpose(2, 0, 1).reshape(-1, self.apart.shape[1])


def natural(harmonic: float, ratio: float) -> list[float]:
    """The whole number, and the whole number of turns behind a gear, nearest to a harmonic."""
    found = [float(round(harmonic))]
    if ratio > 1.0 and round(harmonic / ratio) >= 1:
        found.append(ratio * round(harmonic / ratio))
    return sorted((h for h in found if h > 0.0), key=lambda h: abs(h - harmonic))
