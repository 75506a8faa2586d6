"""A hypothesis about a robot, and the limits of a step."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import IN_TOLERANCE
from flexdyn.diagnose.lazy import kept
from flexdyn.effects import Effect, SensorOffset
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import FileNumber, with_factors

STEP_ROUNDING = 1e-9
"""A smaller share of a step counts as no step [1]."""
LEAST_FACTOR = 0.02
"""Smallest factor of a number of the file: masses, stiffnesses, dampings and levels are positive [1]."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A hypothesis: factors of the file's numbers, numbers that are out of tolerance, missing effects.

    Attributes:
        given: the given model.
        factors: by number of the file; 1 for the given value.
        freed: numbers with a wide prior instead of their tolerance.
        effects: added effects.
        counts: offsets of the encoders of about a count, because rounding is unknown; not reported.
        fits_cycles: whether numbers of cycles are estimated, which usually are chosen from a few values.
    """

    given: FlexibleJointModel
    factors: Mapping[FileNumber, float]
    freed: frozenset[FileNumber] = frozenset()
    effects: tuple[Effect, ...] = ()
    counts: tuple[SensorOffset, ...] = ()
    fits_cycles: bool = False

    @kept
    def model(self) -> FlexibleJointModel:
        """The model of this hypothesis."""
        return with_factors(self.given, self.factors, self.effects)

    @kept
    def seen(self) -> FlexibleJointModel:
        """The model with the offsets of its encoders."""
        return with_factors(self.given, self.factors, (*self.effects, *self.counts))

    def is_beyond(self, number: FileNumber) -> bool:
        """Whether a number is out of its tolerance."""
        return abs(self.factors[number] - 1.0) > IN_TOLERANCE * number.tolerance

    @property
    def displaced(self) -> set[FileNumber]:
        """Numbers that are out of their tolerance though they are not freed: they imitate something."""
        return {number for number in self.factors if number not in self.freed and self.is_beyond(number)}

    def tolerated(self) -> Hypothesis:
        """The same with its numbers back within their tolerance: the cause of their displacement may be gone."""
        factors = dict(self.factors)
        for number in set(factors) - self.freed:
            most = IN_TOLERANCE * number.tolerance
            factors[number] = float(np.clip(factors[number], 1.0 - most, 1.0 + most))
        return dataclasses.replace(self, factors=factors)

    def with_instead(self, effect: Effect, other: Effect) -> Hypothesis:
        """The same with another effect in the place of one of its effects."""
        return dataclasses.replace(self, effects=tuple(other if each is effect else each for each in self.effects))

    def unknowns(self) -> list[tuple[Effect, str]]:
        """Parameters of the added effects that are estimated."""
        return [
            (effect, entry.name)
            for effect in self.effects
            for entry in effect.parameters()
            if (not entry.metadata["chosen"] or (self.fits_cycles and entry.name == effect.cycles))
            and entry.name not in effect.unproposed
            and math.isfinite(getattr(effect, entry.name))
        ]


def count_of(channel: str, offset: float) -> SensorOffset:
    """An offset of an encoder of about a count, see `Hypothesis` [rad or m]."""
    return SensorOffset(channel, offset=offset)


def least_factor(number: FileNumber) -> float:
    """Smallest factor of a number of the file: none of a number that may have either sign."""
    return -math.inf if number.signed else LEAST_FACTOR


def moved(hypothesis: Hypothesis, step: Array, scales: tuple[float, ...]) -> Hypothesis:
    """The hypothesis after a step of its numbers; bounds are respected."""
    pairs = zip(hypothesis.factors.items(), step, strict=False)
    factors = {n: max(f + float(dx), least_factor(n)) for (n, f), dx in pairs}
    changes: dict[Effect, dict[str, float]] = {}
    for (effect, name), dx, scale in zip(hypothesis.unknowns(), step[len(factors) :], scales, strict=False):
        changes.setdefault(effect, {})[name] = bounded(effect, name, float(dx) * scale)
    effects = tuple(e.replace(**changes.get(e, {})).in_usual_range() for e in hypothesis.effects)
    return dataclasses.replace(hypothesis, factors=factors, effects=effects)


def bounded(effect: Effect, name: str, step: float) -> float:
    """A value after a step within its bound; a positive number is at most halved or tripled."""
    declared = effect.declared(name)
    value, lower = getattr(effect, name), declared["lower"]
    if name == effect.cycles:
        return float(np.clip(value + step, max(1.0, 0.9 * value), 1.1 * value))
    if declared["by_factor"] and value > lower == 0.0:
        return float(np.clip(value + step, value / 2.5, value * 2.5))
    return float(min(max(_landed(value + step, lower, step), lower), effect.largest(name)))


def _landed(value: float, bound: float, step: float) -> float:
    """Set a value to its bound if only rounding separates them: a size of 1e-30 is zero."""
    return bound if abs(value - bound) < STEP_ROUNDING * abs(step) else value
