"""A state of the search: a fitted model, what was named to come to it, and how it does on data that took no part."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from dataclasses import dataclass

from flexdyn.diagnose.candidates import Candidate
from flexdyn.diagnose.fitted import Fit
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.verify import Trial
from flexdyn.effects import Effect, JointElasticity


@dataclass(frozen=True, eq=False)
class Alternative:
    """A candidate of the round in which another was named, without what it takes to remember its fit.

    Attributes:
        effect: that would have been added; None for a number set free.
        number: that would have been set free.
        behind: the named one, in BIC.
        gap: of the check with it; NaN where it was not tried.
    """

    effect: Effect | None
    number: FileNumber | None
    behind: float
    gap: float


@dataclass(frozen=True, eq=False)
class Named:
    """One effect of a stage, or one number out of its tolerance.

    Attributes:
        candidate: as it was fitted when it was chosen.
        rivals: others that would have done as well.
        among: the candidates of its round, itself included, best first.
    """

    candidate: Candidate
    rivals: tuple[Candidate, ...] = ()
    among: tuple[Alternative, ...] = ()

    @property
    def joint(self) -> str | None:
        """Where it acts; None where that is no joint."""
        effect, number = self.candidate.effect, self.candidate.number
        return getattr(effect, "joint", None) if number is None else number.joint

    @property
    def stays(self) -> bool:
        """Whether the equations are those of an arm that has it: without it they would say nothing."""
        return isinstance(self.candidate.effect, JointElasticity)


@dataclass(frozen=True, eq=False)
class Stage:
    """A state of the search.

    Attributes:
        fitted: to the equations.
        trial: on the check.
        named: in the order in which they were added; effects stand in the hypothesis in the same order.
    """

    fitted: Fit
    trial: Trial
    named: tuple[Named, ...] = ()

    def without(self, gone: Collection[int]) -> tuple[Hypothesis, tuple[Named, ...]]:
        """The hypothesis less what was named at these places, and what is still named."""
        kept = tuple(each for k, each in enumerate(self.named) if k not in gone)
        places = [k for k, each in enumerate(self.named) if each.candidate.number is None]
        effects = zip(places, self.fitted.hypothesis.effects, strict=True)
        left = tuple(effect for k, effect in effects if k not in gone)
        freed = frozenset(each.candidate.number for each in kept if each.candidate.number is not None)
        return dataclasses.replace(self.fitted.hypothesis, effects=left, freed=freed), kept
