"""What may be missing, each by a linear step: the columns of every proposal, kept, and what they promise."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.own_effects import own_effects
from flexdyn.diagnose.proposal import Point, Proposal
from flexdyn.diagnose.proposals import proposals

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Screened:
    """A proposal at its best grid point, or a number set free."""

    score: float
    proposal: Proposal | None
    point: Point
    values: Array
    number: FileNumber | None = None


class Screen:
    """Every proposal's columns, whitened once and kept.

    Attributes:
        space: of the columns.
        proposals: the catalogue's, then those of users' own effects.
        notes: on effects of users' that are not among them.
    """

    def __init__(self, space: Workspace, progress: Callable[[float], None] | None = None) -> None:
        self.space = space
        own, self.notes = own_effects(space.equations)
        self.proposals = [*proposals(space.equations), *own]
        white = iter(abreast(self._white, [(p, point) for p in self.proposals for point in p.grid], progress))
        self.columns = [[next(white) for _ in proposal.grid] for proposal in self.proposals]

    def _white(self, unknown: tuple[Proposal, Point]) -> Array:
        proposal, point = unknown
        return np.asarray(self.space.whiten(proposal.columns(self.space.equations, point)), dtype=np.float32)

    def ranked(self, made: Fit, scale: float) -> list[Screened]:
        """All proposals by the drop of BIC that a linear step promises, best first."""
        n = math.log(self.space.rows)
        open_ = [pair for pair in zip(self.proposals, self.columns, strict=True) if not _holds(made, pair[0])]
        found = abreast(lambda pair: _screened(made, *pair, scale, n), open_)
        for k, number in enumerate(made.hypothesis.factors):
            if number not in made.hypothesis.freed:
                score = made.regression.freed(k) / scale
                found.append(Screened(score, None, (), np.zeros(0), number))
        return sorted(found, key=lambda each: -each.score)


def _screened(made: Fit, proposal: Proposal, grid: list[Array], scale: float, price: float) -> Screened:
    """A proposal at its best grid point; price: of one number in BIC."""
    gains = [made.regression.gain(c.astype(float), proposal.positive, fixed=proposal.fixed) for c in grid]
    best = int(np.argmax([gain.chi2 for gain in gains]))
    score = gains[best].chi2 / scale - proposal.numbers * price
    return Screened(score, proposal, proposal.grid[best], gains[best].values)


def _holds(made: Fit, proposal: Proposal) -> bool:
    """Whether the model has this effect at this place already: then its number may be wrong, but nothing is missing."""
    return any(proposal.is_of(effect) for effect in made.equations.model.effects)


def extended(made: Fit, choice: Screened) -> Hypothesis | None:
    """The hypothesis with a proposal added."""
    start = made.hypothesis
    if choice.number is not None:
        return start.freed_of(choice.number, made.hypothesis.factors[choice.number])
    effect = choice.proposal.make(choice.point, choice.values) if choice.proposal else None
    if effect is None or effect.is_neutral:
        return None
    return dataclasses.replace(start, effects=(*start.effects, effect))
