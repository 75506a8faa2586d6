"""From a model that does not fit to the effects that are missing: propose, add, fit again, until nothing is left."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import columns
from flexdyn.diagnose.covariance import Noise, whitener
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.estimate import Fit, Hypothesis, Workspace, fit
from flexdyn.diagnose.filters import Filters
from flexdyn.diagnose.mask import sign_mask
from flexdyn.diagnose.measured import Measured
from flexdyn.diagnose.noise import encoder_noise, torque_noise
from flexdyn.diagnose.numbers import IN_TOLERANCE, FileNumber, file_numbers
from flexdyn.diagnose.proposal import Point, Proposal
from flexdyn.diagnose.proposals import proposals
from flexdyn.effects import Effect, Payload, SensorOffset
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
KEPT = 5
"""Proposals that are fitted in full before one is chosen."""
WORTH = 0.05
"""Share of the best proposal's score from which another is fitted in full."""
ENOUGH = 10.0
"""Least drop of BIC for which an effect is named."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A proposal at its best grid point, or a number set free."""

    score: float
    proposal: Proposal | None
    point: Point
    values: Array
    number: FileNumber | None = None


def workspace(model: FlexibleJointModel, data: tuple[Measured, ...]) -> tuple[Workspace, Hypothesis, Noise]:
    """Equations, weights and priors of a model over data; the torque's noise comes from what a first fit leaves."""
    equations = Equations(model, data, Filters.of_rate(data[0].dt))
    zero = np.zeros(equations.true.n)
    peak = np.max([np.abs(each.tau).max(axis=0) for each in data], axis=0)
    noise = Noise(encoder_noise(data, "q"), encoder_noise(data, "theta"), 0.002 * np.maximum(peak, 1e-9), zero)
    mask = sign_mask(equations, noise)
    start = Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    raw = np.stack([columns.of_number(equations, number) for number in start.factors], axis=1)
    offsets, sigma = _offsets(equations, noise)
    space, made = None, None
    for _ in range(2):
        whiten = whitener(equations, noise, mask)
        space = Workspace(equations, whiten, whiten(raw), whiten(offsets), sigma)
        made = fit(start, space, steps=3)
        noise = dataclasses.replace(noise, tau=torque_noise(made.equations, made.equations.residual, mask, noise))
    whiten = whitener(equations, noise, mask)
    return Workspace(equations, whiten, whiten(raw), whiten(offsets), sigma), start, noise


def _offsets(equations: Equations, noise: Noise) -> tuple[Array, Array]:
    """A count more or less of each encoder: nobody knows whether it rounds or cuts."""
    raw, sigma = [], []
    for j, joint in enumerate(equations.true.joint_names):
        data = equations.data[0]
        for signal, there in (("q", data.has_q[j]), ("theta", data.has_theta[j] and equations.true.elastic[j])):
            if there:
                raw.append(columns.of_effect(equations, SensorOffset(f"{signal}.{joint}", offset=1e-6), 1e-6))
                sigma.append(2.0 * float(getattr(noise, signal)[j]) + 1e-12)
    return np.stack(raw, axis=1), np.array(sigma)


class Screen:
    """Every proposal's columns, whitened once and kept."""

    def __init__(self, space: Workspace, progress: Callable[[float], None] | None = None) -> None:
        self.space = space
        self.proposals = proposals(space.equations)
        self.columns: list[list[Array]] = []
        for k, proposal in enumerate(self.proposals):
            self.columns.append([self._white(proposal, point) for point in proposal.grid])
            if progress is not None:
                progress((k + 1) / len(self.proposals))

    def _white(self, proposal: Proposal, point: Point) -> Array:
        return np.asarray(self.space.whiten(proposal.columns(self.space.equations, point)), dtype=np.float32)

    def ranked(self, made: Fit, scale: float) -> list[Screened]:
        """All proposals by the drop of BIC that a linear step promises, best first."""
        n = math.log(self.space.rows)
        found = []
        for proposal, grid in zip(self.proposals, self.columns, strict=True):
            if _holds(made, proposal):
                continue
            gains = [made.regression.gain(c.astype(float), proposal.positive, fixed=proposal.fixed) for c in grid]
            best = int(np.argmax([gain.chi2 for gain in gains]))
            score = gains[best].chi2 / scale - proposal.numbers * n
            found.append(Screened(score, proposal, proposal.grid[best], gains[best].values))
        for k, number in enumerate(made.hypothesis.factors):
            if number not in made.hypothesis.freed:
                score = made.regression.freed(k) / scale
                found.append(Screened(score, None, (), np.zeros(0), number))
        return sorted(found, key=lambda each: -each.score)


def _holds(made: Fit, proposal: Proposal) -> bool:
    """Whether the model has this effect at this place already: then its number may be wrong, but nothing is missing."""
    return any(proposal.is_of(effect) for effect in made.equations.model.effects)


def extended(made: Fit, choice: Screened) -> Hypothesis | None:
    """The hypothesis with a proposal added, its numbers back within their tolerance: what bent them may be gone."""
    factors = {
        number: factor if number in made.hypothesis.freed else float(np.clip(factor, *_tolerated(number)))
        for number, factor in made.hypothesis.factors.items()
    }
    start = dataclasses.replace(made.hypothesis, factors=factors)
    if choice.number is not None:
        kept = factors | {choice.number: made.hypothesis.factors[choice.number]}
        return dataclasses.replace(start, factors=kept, freed=start.freed | {choice.number})
    effect = choice.proposal.make(choice.point, choice.values) if choice.proposal else None
    if effect is None or effect.is_neutral:
        return None
    return dataclasses.replace(start, effects=(*start.effects, effect))


def _tolerated(number: FileNumber) -> tuple[float, float]:
    return 1.0 - IN_TOLERANCE * number.tolerance, 1.0 + IN_TOLERANCE * number.tolerance


@dataclass(frozen=True, eq=False)
class Candidate:
    """A proposal fitted in full.

    Attributes:
        fitted: with it.
        drop: of BIC.
        effect: that was added; None for a number set free.
        number: that was set free.
    """

    fitted: Fit
    drop: float
    effect: Effect | None
    number: FileNumber | None


def candidates(space: Workspace, screen: Screen, made: Fit) -> list[Candidate]:
    """The most promising proposals, fitted in full, best first."""
    found = []
    ranked = screen.ranked(made, max(1.0, made.reduced) if made.hypothesis.effects or made.hypothesis.freed else 1.0)
    for choice in ranked[:KEPT]:
        if choice.score < max(ENOUGH, WORTH * ranked[0].score):
            break
        after = extended(made, choice)
        if after is None:
            continue
        trial = fit(after, space)
        drop = (made.chi2 - trial.chi2) / max(1.0, trial.reduced) - cost(choice, space)
        if drop >= ENOUGH:
            effect = None if choice.number is not None else trial.hypothesis.effects[-1]
            found.append(Candidate(trial, drop, effect, choice.number))
    if any(each.number is not None and each.number.joint is None for each in found):
        found += _payloads(space, made)
    return sorted(found, key=_order)


def _order(each: Candidate) -> float:
    """Best first; a payload, which only adds, before a link's number that does the same."""
    return -each.drop - (ENOUGH if isinstance(each.effect, Payload) else 0.0)


def _payloads(space: Workspace, made: Fit) -> list[Candidate]:
    """A mass at the tip beside links' numbers out of tolerance: where a link ends there, it is the same column."""
    effect = Payload(mass=0.05, frame=space.equations.true.robot.tip)
    trial = fit(dataclasses.replace(made.hypothesis, effects=(*made.hypothesis.effects, effect)), space)
    drop = (made.chi2 - trial.chi2) / max(1.0, trial.reduced)
    return [Candidate(trial, drop, trial.hypothesis.effects[-1], None)] if drop >= ENOUGH else []


def cost(choice: Screened, space: Workspace) -> float:
    """What the description of a proposal costs in BIC; a number of the file costs nothing, as it is there already."""
    return choice.proposal.numbers * math.log(space.rows) if choice.proposal else 0.0


__all__ = ["Candidate", "Screen", "Screened", "candidates", "extended", "workspace"]
