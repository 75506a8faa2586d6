"""The most promising of what may be missing, each fitted in full."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.estimate import fit
from flexdyn.diagnose.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.screen import Screen, Screened, extended
from flexdyn.diagnose.workspace import workspace
from flexdyn.effects import Effect, JointElasticity, Payload, SpringHysteresis
from flexdyn.errors import InputError, SimulationError

KEPT, MANY_KEPT = 5, 10
"""Proposals that are fitted in full before one is chosen, and where many promise nearly as much as the best."""
LEADING = 2
"""The best proposals, which are fitted before it is known what is hopeless beside them."""
NEARLY = 0.8
"""Share of the best proposal's score that is nearly as much."""
WORTH = 0.05
"""Share of what the leading proposals turned out to be good for from which another is fitted in full.
Columns that bend at every reversal promise anything."""
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
    ranked = [each for each in screen.ranked(made, scale) if each.score >= max(ENOUGH, least / scale)]
    if not ranked:
        return []
    best = ranked[0].score
    leading = [each for each in ranked[:LEADING] if each.score >= WORTH * best]
    first = abreast(lambda choice: _fitted(made, space, choice, scale, hopeless), leading)
    reached = [each.chi2 for each in first if each is not None]
    most = min(hopeless, FAR_ABOVE * min(reached, default=math.inf))
    kept = min(max([0.0, *((made.chi2 - chi2) / scale for chi2 in reached)]), best)
    many = MANY_KEPT if space.equations.made_up.any() else KEPT  # where a position is made up, columns guide less
    least_of = [WORTH * kept if k < many else NEARLY * best for k in range(len(leading), MANY_KEPT)]
    rest = [each for each, low in zip(ranked[len(leading) :], least_of, strict=False) if each.score >= low]
    others = abreast(lambda choice: _fitted(made, space, choice, scale, most), rest)
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
    start = start.tolerated()  # what bent the numbers were other equations
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
