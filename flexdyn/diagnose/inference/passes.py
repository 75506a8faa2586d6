"""The posterior over structures: linearise, compare, fit, and again from there until nothing changes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.data.filters import FIRST, Filters
from flexdyn.diagnose.equations.covariance import Noise
from flexdyn.diagnose.equations.equations import LINK, SENSOR, Equations
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.hypothesis.workspace import Unweighted, weighed
from flexdyn.diagnose.inference.autoregression import runs_of
from flexdyn.diagnose.inference.catalogue import everything
from flexdyn.diagnose.inference.discrepancy import Discrepancy, Seen
from flexdyn.diagnose.inference.harmonics import peaks
from flexdyn.diagnose.inference.library import WAVES, Library
from flexdyn.diagnose.inference.search import explore
from flexdyn.diagnose.inference.space import NATURAL, Space, Structure
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.diagnose.progress import know, tell
from flexdyn.effects import Effect, JointElasticity, LoadDependentFriction
from flexdyn.model.uncertain_parameters import FileNumber

Array = NDArray[np.float64]
PASSES = 5
"""Linearisations at most."""
ROUNDS = 25
"""Times that model error and structure are estimated in turn, at most."""
STRONG = 0.1
"""Share of the first gain of a pass from which another addition is made before the equations are linearised anew."""
WEIGHTINGS, WELL_WEIGHTED = 4, 0.7
"""Fits of one hypothesis, each weighted by what the last one left, until it leaves more than such a share of that."""
STEPS = 4
"""Gauss-Newton steps between two linearisations."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """What was compared.

    Attributes:
        space: candidates and their matrix, at the best structure and under its model error.
        best: the most likely structure.
        fitted: it, by Gauss-Newton.
        noise: of the channels.
        settled: whether the last pass changed nothing.
        known: log posteriors of the structures that were compared, not normalised.
    """

    space: Space
    best: Structure
    fitted: Fit
    noise: Noise
    settled: bool
    known: Mapping[Structure, float]


def posterior(bare: Unweighted, noise: Noise, start: Hypothesis) -> Posterior:
    """Compare structures on the equations.

    Args:
        bare: the equations of the model as given.
        noise: of the channels, as the records show it.
        start: the file's numbers where they stand.
    """
    own = everything(bare.equations)
    start = dataclasses.replace(start, measured=frozenset({"harmonic"}))
    here, mask, recorded = start, sign_mask(bare.equations, noise), noise
    first: Library | None = None
    compared: set[frozenset[tuple[object, ...]]] = set()
    for k in range(PASSES):
        tell(f"comparing structures: pass {k + 1} of at most {PASSES}", 0.05 + 0.6 * k / PASSES)
        at = bare.equations.of(here.model())
        noise = _quieter(recorded, at, mask)
        work = weighed(bare, noise, mask, _filter_error(bare.equations, here))
        seen = rows_of(at, mask)
        runs = runs_of(mask, list(seen.lengths), len(at.kinds))
        if k == 0:  # the file's numbers first
            here = fit(here, _for_fit(bare, noise, mask, seen, here), steps=3).hypothesis
            at = bare.equations.of(here.model())
            noise = _quieter(recorded, at, mask)
            work = weighed(bare, noise, mask)
        made = linearised(here, work, at=at)
        count = len(here.factors)
        numbers = made.regression.X[:, :count] if made.free is None else made.free.X[:, :count]
        listed = _with_harmonics(at, own, runs)
        columns = Library(
            at, work.whiten, here, numbers, work.nuisance, work.nuisance_sigma, tuple(listed), noise, mask, first
        )
        first = first or columns
        space = Space(columns, work.whiten(at.residual), seen)
        know(space=space)
        stands = frozenset(
            (c, 0) for c, each in enumerate(space.candidates) if each.stands is not None or each.number in here.freed
        )
        best = _compared(space, stands)
        there = hypothesis_of(space, _strong(space, best, stands, STRONG ** (k + 1)), here)
        name = frozenset(_identity(space, each) for each in best)
        settled = _nonlinear(space, best) == _nonlinear(space, stands) or name in compared
        compared.add(name)
        last = settled or k == PASSES - 1
        if last:
            space.known = {}
            best = explore(space, [best])
            there = hypothesis_of(space, best, here, whole=True)
        beliefs = columns.beliefs(there.effects)
        for _ in range(WEIGHTINGS):
            work = _for_fit(bare, noise, mask, seen, there)
            work = dataclasses.replace(work, beliefs=beliefs)
            fitted = _natural(fit(there, work, steps=STEPS if not last else 8), space, work)
            there = fitted.hypothesis
            if fitted.reduced > WELL_WEIGHTED * _reduced(work):
                break
        if last:
            break
        here = fitted.hypothesis
    return Posterior(space, best, fitted, noise, settled, space.known)


def _quieter(recorded: Noise, at: Equations, mask: NDArray[np.bool_]) -> Noise:
    """The torque's noise: what the record changes from sample to sample, or what the equations do, whichever is less.

    Each holds all of the noise and something else: what is asked of the motor, or what the model lacks.
    """
    left = torque_noise(at, at.residual, mask, recorded)
    return dataclasses.replace(recorded, tau=np.maximum(np.minimum(left, recorded.tau), 1e-12))


def _reduced(work: Workspace) -> float:
    """Mean square of the weighted rows of a model error as large as it was taken for [1]."""
    error = work.whiten.error if isinstance(work.whiten, Tempered) else None
    return 1.0 if error is None else float((error.count / error.times).sum() / error.count.sum())


def _for_fit(
    bare: Unweighted, noise: Noise, mask: NDArray[np.bool_], seen: Seen, there: Hypothesis
) -> Workspace:  # fmt: skip
    """Weights for the fit of a hypothesis: the sensors' noise and the model error that it leaves.

    What the first filter does to laws with corners is left out: where a law is still wrong it would excuse that.
    """
    plain = weighed(bare, noise, mask)
    return tempered(plain, error_of(plain, bare.equations.of(there.model()).residual, seen))


def error_of(plain: Workspace, residual: Array, seen: Seen) -> Discrepancy:
    """The model error in a residual (rows,), the encoders' offsets that fit it best taken off."""
    white, offsets = plain.whiten(residual), plain.nuisance
    loose = np.diag(1.0 / plain.nuisance_sigma**2)
    return Discrepancy.of(white - offsets @ np.linalg.solve(offsets.T @ offsets + loose, offsets.T @ white), seen)


def tempered(plain: Workspace, error: Discrepancy) -> Workspace:
    """Weights by the sensors' noise and a model error together."""
    return dataclasses.replace(
        plain,
        whiten=Tempered.of(plain.whiten, error),
        numbers=error.whiten(plain.numbers),
        nuisance=error.whiten(plain.nuisance),
    )


def rows_of(at: Equations, mask: NDArray[np.bool_]) -> Seen:
    """Which rows of the equations say something."""
    lengths = tuple(at.filters.count(len(along.t)) for along in at.motions)
    return Seen(~mask.reshape(-1, len(at.kinds)), lengths)


def _natural(fitted: Fit, space: Space, work: Workspace) -> Fit:
    """The fit with harmonics at whole numbers, of cycles or of motor turns, that it does not rule out."""
    std, changes = fitted.std(), {}
    for effect in fitted.hypothesis.effects:
        spread = std.get((effect, "harmonic"))
        if spread is None:
            continue
        owner = next(each for each in space.candidates if each.proposal is not None and each.proposal.is_of(effect))
        now = float(getattr(effect, "harmonic"))  # noqa: B009 - not every effect has one
        for value in owner.natural(now):
            if value != now and (value - now) ** 2 < 2.0 * NATURAL * spread**2:
                changes[effect] = effect.replace(harmonic=value)
                break
    if not changes:
        return fitted
    effects = tuple(changes.get(each, each) for each in fitted.hypothesis.effects)
    return fit(dataclasses.replace(fitted.hypothesis, effects=effects), work, steps=2)


def _compared(space: Space, stands: Structure) -> Structure:
    """The best structure at a linearisation, under the model error that it leaves."""
    space.under(_nothing(space))
    space.under(Discrepancy.of(space.left(stands), space.seen))
    best, seen = stands, set[Structure]()
    for _ in range(ROUNDS):
        best = explore(space, [best], 0)
        if best in seen:
            break
        seen.add(best)
        space.under(Discrepancy.of(space.left(best), space.seen))
    return best


def _nothing(space: Space) -> Discrepancy:
    """No model error: what is left is the sensors' noise."""
    one = np.ones(len(space.equations))
    return Discrepancy(one, one, space.seen.count)


def _strong(space: Space, best: Structure, stands: Structure, least: float) -> Structure:
    """The structure without what is new in it and weak beside the strongest of that.

    Where a strong effect is not linear, its linearisation leaves what weak ones pick up; fitted, it leaves nothing.
    """
    value = space.value(best)
    lost = {each: value - space.value(best - {each}) for each in sorted(best - stands)}
    most = max(lost.values(), default=0.0)
    return best - {each for each, loss in lost.items() if loss < least * most}


def _identity(space: Space, each: tuple[int, int]) -> tuple[object, ...]:
    """Kind and place of a candidate, whatever its numbers are."""
    candidate = space.candidates[each[0]]
    return (candidate.kind, *sorted(candidate.place.items()))


def _nonlinear(space: Space, structure: Structure) -> set[int]:
    """Candidates of a structure but those that stay linear until the end."""
    return {c for c, _ in structure if not _waits(space, c)}


def _waits(space: Space, c: int) -> bool:
    """Whether a candidate makes a rigid joint elastic: all its equations change, so it stays linear until the end."""
    candidate, true = space.candidates[c], space.library.equations.true
    if candidate.kind == LoadDependentFriction.name:
        return not true.elastic[true.index(candidate.place["joint"])]
    return candidate.kind == JointElasticity.name


def hypothesis_of(space: Space, structure: Structure, here: Hypothesis, *, whole: bool = False) -> Hypothesis:
    """A structure with its coefficients as a hypothesis; what makes joints elastic only in the whole one."""
    estimate = space.estimate(structure)
    value = dict(zip(estimate.columns.tolist(), estimate.mean.tolist(), strict=True))
    names = list(here.factors)
    factors = {n: here.factors[n] + value[k] for k, n in enumerate(names)}
    freed: set[FileNumber] = set()
    effects: list[Effect] = []
    for c, p in sorted(structure):
        candidate = space.candidates[c]
        if candidate.number is not None:
            factors[candidate.number] += value[int(candidate.columns[p][0])]
            freed.add(candidate.number)
        elif candidate.stands is not None:
            effects.append(candidate.stands)
        elif whole or not _waits(space, c):
            x = np.array([value[int(k)] for k in candidate.columns[p]])
            x = np.where(space.prior.positive[candidate.columns[p]], np.maximum(x, 0.0), x)
            effect = candidate.effect(p, x)
            if effect is not None and not effect.is_neutral:
                effects.append(effect)
    effects += _softened(space, structure, effects)
    factors = {n: max(f, 0.02) for n, f in factors.items()}
    return dataclasses.replace(here, factors=factors, freed=frozenset(freed), effects=tuple(effects))


def _softened(space: Space, structure: Structure, effects: list[Effect]) -> list[Effect]:
    """Elasticities that load-dependent friction needs and the structure lacks: as stiff as the data allow."""
    soft = {each.joint for each in effects if isinstance(each, JointElasticity)}
    true, found = space.library.equations.true, list[Effect]()
    for each in effects:
        if not isinstance(each, LoadDependentFriction) or true.elastic[true.index(each.joint)] or each.joint in soft:
            continue
        place = {"effect": JointElasticity.name, "joint": each.joint}
        (c,) = (c for c, other in enumerate(space.candidates) if place.items() <= other.place.items())
        estimate = space.gram.estimate(space.columns(structure | {(c, 0)}))
        k = int(np.flatnonzero(estimate.columns == space.candidates[c].columns[0][0])[0])
        compliance = max(float(estimate.mean[k]), 0.0) + float(np.sqrt(estimate.covariance[k, k]))
        found.append(JointElasticity(each.joint, stiffness=1.0 / compliance))
    return found


def _filter_error(equations: Equations, here: Hypothesis) -> Array | None:
    """Variance of the rows by what the first filter does to the found effects' laws (rows,); None: there are none.

    Laws with corners see a motion that the filter has rounded. A filter of twice the variance rounds twice as much, so
    what changes is what the narrow one did (Richardson).
    """
    if not here.effects:
        return None
    dt = equations.data[0].dt
    first = Filters.of_rate(dt, first=math.sqrt(2.0) * max(FIRST, 1.25 * dt)).first
    filters = dataclasses.replace(equations.filters, first=first)
    wide = Equations(equations.model, equations.data, filters, equations.stiffness)
    total = np.zeros(len(equations.residual))
    for effect in here.effects:
        without = dataclasses.replace(here, effects=tuple(each for each in here.effects if each is not effect))
        parts = []
        for at in (equations, wide):
            whole = at.of(here.model()).residual - at.of(without.model()).residual
            parts.append(_by_recording(at, whole))
        total += np.concatenate([_difference(a, b) for a, b in zip(*parts, strict=True)]) ** 2
    return total


def _by_recording(at: Equations, rows: Array) -> list[tuple[Array, Array]]:
    """Times and rows (times, equations) of every recording."""
    table, found, first = rows.reshape(-1, len(at.kinds)), [], 0
    for along in at.motions:
        t = along.t[at.filters.instants(len(along.t))]
        found.append((t, table[first : first + len(t)]))
        first += len(t)
    return found


def _difference(narrow: tuple[Array, Array], wide: tuple[Array, Array]) -> Array:
    t, rows = narrow
    other = np.stack([np.interp(t, wide[0], column) for column in wide[1].T], axis=1)
    inside = (t >= wide[0][0]) & (t <= wide[0][-1])
    return np.asarray(np.where(inside[:, None], other - rows, 0.0)).ravel()


def _with_harmonics(equations: Equations, known: list[Proposal], runs: NDArray[np.intp]) -> list[Proposal]:
    """Proposals of waves at the harmonics that the residual holds."""
    many = len(equations.kinds)
    found: dict[str, list[float]] = {}
    for row, (j, kind) in enumerate(equations.kinds):
        joint = equations.true.joint_names[j]
        if kind == SENSOR:
            continue
        signal = "q" if kind == LINK else "theta"
        left = equations.residual.reshape(-1, many)[:, row]
        found.setdefault(joint, []).extend(peaks(equations, left, runs[:, row], row, signal))
    return [_at(each, found) for each in known]


def _at(proposal: Proposal, harmonics: Mapping[str, list[float]]) -> Proposal:
    place = proposal.place
    if place["effect"] not in WAVES:
        return proposal
    joint = place.get("joint") or place.get("channel", "").partition(".")[2]
    more = {(h,) for h in harmonics.get(joint, ())}
    return dataclasses.replace(proposal, grid=tuple(sorted({*proposal.grid, *more})))
