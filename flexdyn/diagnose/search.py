"""From a model that does not fit to the effects that are missing: propose, add, fit again, until nothing is left."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import columns
from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.covariance import Noise, encoders_rule, whitener
from flexdyn.diagnose.equations import Equations
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.filters import SECONDS, Filters
from flexdyn.diagnose.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.mask import sign_mask
from flexdyn.diagnose.measured import Measured
from flexdyn.diagnose.noise import encoder_noise, recorded_torque_noise, torque_noise
from flexdyn.diagnose.numbers import FileNumber, file_numbers, with_factors
from flexdyn.diagnose.own_effects import own_effects
from flexdyn.diagnose.proposal import Point, Proposal
from flexdyn.diagnose.proposals import proposals
from flexdyn.effects import Effect, JointElasticity, Payload, SensorOffset, SpringHysteresis
from flexdyn.errors import InputError, SimulationError
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
KEPT, MANY_KEPT = 5, 10
"""Proposals that are fitted in full before one is chosen, and where many promise nearly as much as the best."""
LEADING = 2
"""The best proposals, which are fitted before it is known what is hopeless beside them."""
NEARLY = 0.8
"""Share of the best proposal's score that is nearly as much."""
WORTH = 0.05
"""Share of the best proposal's score from which another is fitted in full."""
MANY = 200.0
"""Recordings must be so many times as long as a wider filter."""
SOFTENINGS, SOFTENED = 4, 0.1
"""Workspaces that are made for a joint that becomes elastic, until its stiffness changes by less than such a share."""
SCALES = {
    "parallel_spring": ("stiffness", 3.0),
    "presliding_friction": ("stiffness", 1.0),
    "spring_hysteresis": ("width", 1.0),
    "stribeck_friction": ("velocity", 1.0),
    "warm_up_friction": ("time_constant", 1.0),
}
"""Laws that become a plainer one as a number grows or falls, and by how many standard deviations it must be away from
none. Of what comes with reversals and passes, windows see more than equations do."""
WIDEST = 3.0
"""Times the range over which a spring was wound: a loop wider than that is a spring."""
FAR_ABOVE = 3.0
"""Times the chi^2 of the best so far above which a candidate is given up after a few steps."""
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


def workspace(
    model: FlexibleJointModel, data: tuple[Measured, ...], start: Hypothesis | None = None
) -> tuple[Workspace, Hypothesis, Noise]:
    """Equations, weights and priors of a model over data; the torque's noise comes from what a first fit leaves.

    Args:
        model: as it was given.
        data: to be explained.
        start: with the effects that were found, where one of them changes which equations there are; None: the model.

    Raises:
        InputError: no equation says anything at any time.
    """
    start = start or Hypothesis(model, dict.fromkeys(file_numbers(model), 1.0))
    torque = np.maximum(recorded_torque_noise(data), 1e-12)
    noise = Noise(encoder_noise(data, "q"), encoder_noise(data, "theta"), torque, np.zeros(model.n))
    space = weighed(_filtered(with_factors(model, {}, start.effects), data, noise), noise, start)
    if space.whiten.mask.all():
        problem = "joints rest, or may rest, so often that no equation says anything"
        remedy = "let all joints move at once for seconds: while one sticks, nobody knows what friction holds"
        raise InputError(problem, file=data[0].name, key="t", remedy=remedy)
    for _ in range(2):
        made = fit(start, space, steps=3)
        left, mask = made.equations.residual, space.whiten.mask
        noise = dataclasses.replace(noise, tau=torque_noise(made.equations, left, mask, noise))
        space = weighed(space.equations, noise, start, mask)
    return space, start, noise


def weighed(equations: Equations, noise: Noise, start: Hypothesis, mask: NDArray[np.bool_] | None = None) -> Workspace:
    """Equations with the weights that a noise gives them.

    Args:
        equations: to be fitted.
        noise: of the channels.
        start: whose numbers of the file are fitted.
        mask: rows that say nothing; None: found by the noise.
    """
    mask = sign_mask(equations, noise) if mask is None else mask
    whiten = whitener(equations, noise, mask)
    raw = np.stack(abreast(partial(columns.of_number, equations), start.factors), axis=1)
    channels, offsets, sigma = _offsets(equations, noise)
    return Workspace(equations, whiten, noise, whiten(raw), whiten(offsets), sigma, channels)


def _filtered(model: FlexibleJointModel, data: tuple[Measured, ...], noise: Noise) -> Equations:
    """The equations behind the narrowest filter that leaves the encoders' noise below the torque's.

    Rows that hold little but noise, times a number of the file, would be smaller for a smaller number.
    """
    found = Equations(model, data, Filters.of_rate(data[0].dt))
    for second in SECONDS[1:]:
        short = min(len(each.t) for each in data) * data[0].dt < MANY * second
        if short or not encoders_rule(found, noise):
            break
        found = Equations(model, data, Filters.of_rate(data[0].dt, second=second))
    return found


def _offsets(equations: Equations, noise: Noise) -> tuple[tuple[str, ...], Array, Array]:
    """A count more or less of each encoder: nobody knows whether it rounds or cuts."""
    names, raw, sigma = [], [], []
    for j, joint in enumerate(equations.true.joint_names):
        data = equations.data[0]
        for signal, there in (("q", data.has_q[j]), ("theta", data.has_theta[j])):
            if there:
                names.append(f"{signal}.{joint}")
                raw.append(columns.of_effect(equations, SensorOffset(names[-1], offset=1e-6), 1e-6))
                sigma.append(2.0 * float(getattr(noise, signal)[j]) + 1e-12)
    return tuple(names), np.stack(raw, axis=1), np.array(sigma)


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
    """The hypothesis with a proposal added, its numbers back within their tolerance."""
    start = made.hypothesis.tolerated()
    if choice.number is not None:
        return start.freed_of(choice.number, made.hypothesis.factors[choice.number])
    effect = choice.proposal.make(choice.point, choice.values) if choice.proposal else None
    if effect is None or effect.is_neutral:
        return None
    return dataclasses.replace(start, effects=(*start.effects, effect))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A proposal fitted in full.

    Attributes:
        fitted: with it.
        drop: of BIC.
        cost: of its description in BIC; a number of the file costs nothing, as it is there already.
        effect: that was added; None for a number set free.
        number: that was set free.
        chi2: that was reached; it compares with those of the same round.
    """

    fitted: Fit
    drop: float
    cost: float
    effect: Effect | None
    number: FileNumber | None
    chi2: float

    def behind(self, best: Candidate) -> float:
        """By how much another candidate of the same round is better, in BIC."""
        scale = max(1.0, best.fitted.reduced)
        return (self.chi2 - best.chi2) / scale + self.cost - best.cost


def candidates(
    space: Workspace, screen: Screen, made: Fit, least: float = 0.0, hopeless: float = math.inf
) -> list[Candidate]:
    """The most promising proposals, fitted in full, best first.

    Args:
        space: of the fit.
        screen: of the proposals.
        made: what they come on top of.
        least: drop of chi^2 that a linear step must promise.
        hopeless: chi^2 that is of no use any more.
    """
    scale = max(1.0, made.reduced) if made.hypothesis.effects or made.hypothesis.freed else 1.0
    ranked = screen.ranked(made, scale)
    kept = MANY_KEPT if space.equations.made_up.any() else KEPT  # where a position is made up, columns guide less
    shares = [WORTH if k < kept else NEARLY for k in range(MANY_KEPT)]
    worth = [
        choice
        for choice, share in zip(ranked, shares, strict=False)
        if choice.score >= max(ENOUGH, least / scale, share * ranked[0].score)
    ]
    first = abreast(lambda choice: _fitted(made, space, choice, scale, hopeless), worth[:LEADING])
    reached = min((each.chi2 for each in first if each is not None), default=math.inf)
    most = min(hopeless, FAR_ABOVE * reached)
    others = abreast(lambda choice: _fitted(made, space, choice, scale, most), worth[LEADING:])
    found = [each for each in (*first, *others) if each is not None]
    laden = any(isinstance(each.effect, Payload) for each in found)
    if not laden and any(each.number is not None and each.number.joint is None for each in found):
        found += _payloads(space, made)
    scale = max(1.0, min((each.fitted.reduced for each in found), default=1.0))
    return sorted(found, key=lambda each: _order(each, scale))


def _fitted(made: Fit, space: Workspace, choice: Screened, scale: float, hopeless: float) -> Candidate | None:
    """A choice fitted in full; None where it makes no sense, or is another one in a limit."""
    after = extended(made, choice)
    if after is None:
        return None
    numbers = choice.proposal.numbers if choice.proposal else 0
    cost = numbers * math.log(space.rows)
    if choice.proposal is not None and isinstance(after.effects[-1], JointElasticity):
        return _softened(made, after, choice, cost, scale)
    try:
        found = _candidate(made, fit(after, space, hopeless=hopeless), cost, choice.number)
    except (InputError, SimulationError):  # a user's law that fails elsewhere, a spring beyond all bounds
        return None
    return found if found.drop >= ENOUGH and not _is_a_limit(found) else None


def _candidate(before: Fit, after: Fit, cost: float, number: FileNumber | None) -> Candidate:
    drop = (before.chi2 - after.reached) / max(1.0, after.reduced) - cost
    effect = None if number is not None else after.hypothesis.effects[-1]
    return Candidate(after, drop, cost, effect, number, after.reached)


def _is_a_limit(candidate: Candidate) -> bool:
    """Whether the data does not hold the scale of a law: it is then what the law becomes, which has its own name."""
    effect = candidate.effect
    if effect is None or effect.name not in SCALES:
        return False
    (name, away), made = SCALES[effect.name], candidate.fitted
    if isinstance(effect, SpringHysteresis) and effect.width > WIDEST * made.equations.wound(effect.joint):
        return True
    std = made.std()[effect, name] / math.sqrt(max(1.0, made.reduced))  # what other laws leave says nothing of this one
    return bool(away * std > getattr(effect, name))


def _softened(before: Fit, start: Hypothesis, choice: Screened, cost: float, scale: float) -> Candidate:
    """A rigid joint made elastic: other equations, whose chi^2 compares with nothing, so the linear step's stands."""
    after = softened(start, before.space)
    chi2 = before.chi2 - (choice.score + cost) * scale
    return Candidate(after, choice.score, cost, after.hypothesis.effects[-1], None, chi2)


def softened(start: Hypothesis, space: Workspace) -> Fit:
    """The fit of a hypothesis with a new `joint_elasticity` to equations of its own, whose noise its stiffness sets."""
    for _ in range(SOFTENINGS):
        space, start, _ = workspace(start.given, space.equations.data, start)
        made = fit(start, space)
        before, after = (each.effects[-1].values[0] for each in (start, made.hypothesis))
        start = made.hypothesis
        if abs(math.log(after / before)) < SOFTENED:
            break
    return made


def _order(each: Candidate, scale: float) -> float:
    """Best first; a payload, which only adds, before a link's number that does the same."""
    return each.chi2 / scale + each.cost - (ENOUGH if isinstance(each.effect, Payload) else 0.0)


def _payloads(space: Workspace, made: Fit) -> list[Candidate]:
    """A mass at the tip beside links' numbers out of tolerance: where a link ends there, it is the same column."""
    effect = Payload(mass=0.05, frame=space.equations.true.robot.tip)
    trial = fit(dataclasses.replace(made.hypothesis, effects=(*made.hypothesis.effects, effect)), space)
    found = _candidate(made, trial, 0.0, None)
    return [found] if found.drop >= ENOUGH else []


__all__ = ["Candidate", "Screen", "Screened", "candidates", "extended", "workspace"]
