"""fd.diagnose: look for what is missing, confirm it on data that took no part, name it."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose import windows as cutting
from flexdyn.diagnose.covariance import Noise
from flexdyn.diagnose.estimate import Fit, Hypothesis, Workspace, fit
from flexdyn.diagnose.findings import calibrations, finding
from flexdyn.diagnose.gap import Shot, shoot
from flexdyn.diagnose.localise import localise, traces
from flexdyn.diagnose.measured import Measured, measured
from flexdyn.diagnose.nesting import is_simpler, simplified
from flexdyn.diagnose.refine import Refined, of_fit, refine
from flexdyn.diagnose.result import Diagnosis, Finding, Gap, Interrupted
from flexdyn.diagnose.sanity import check_recordings
from flexdyn.diagnose.search import Candidate, Screen, candidates, workspace
from flexdyn.diagnose.windows import Windows
from flexdyn.effects import Effect
from flexdyn.model import FlexibleJointModel
from flexdyn.records import Recording

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
WITHHELD = 0.25
"""Share at the end of every recording that is kept for the check where no other data is given."""
MOST_FINDINGS = 6
SURE = 3.0
"""Standard errors by which windows of the check must be less off with an effect than without it."""
TRIED = 4
"""Candidates of one round that may fail the check before the search ends."""
ROUGH = 1.2
"""Mean square of the equations' white residuals above which the filters, and not the noise, limit the fit."""
NEARLY = 0.002
"""Share of its drop by which a candidate may do worse than the best and still be looked at on the check."""
EXPLAINED = 1.3
"""A median window that is off by no more than so many times the floor is explained."""


@dataclass
class Stage:
    """A confirmed state of the search.

    Attributes:
        fitted: to the equations.
        check: over the windows of the check.
        numbers: its final numbers and how sure they are.
        added: candidate that led here; None at the start.
        rivals: others that would have done as well.
    """

    fitted: Fit
    check: Shot
    numbers: Refined
    added: Candidate | None = None
    rivals: tuple[Candidate, ...] = ()


def diagnose(
    model: FlexibleJointModel,
    fit: Sequence[Recording],
    check: Sequence[Recording] = (),
    *,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find where a model and measurements disagree, name the missing effects, and add them.

    Args:
        model: as it is believed to be, with its tolerance.
        fit: recordings to learn from.
        check: recordings that take no part in the fit; none: the last quarter of every one of `fit` is withheld.
        progress: called with the stage and the share of it that is done.

    Returns:
        The verdict, the findings, the corrected model.

    Raises:
        InputError: recordings that do not fit the model or cannot answer.
    """
    began = time.monotonic()
    say = progress or (lambda stage, share: None)
    fit_records, check_records = (list(fit), list(check)) if check else split(fit)
    data = tuple(measured(model, each) for each in fit_records)
    say("reading the equations", 0.0)
    notes = check_recordings(model, data)
    space, start, noise = workspace(model, data)
    levels = window_noise(noise)
    windows = (Windows.of(model, fit_records, levels), Windows.of(model, check_records, levels))
    stages: list[Stage] = []
    try:
        _search(space, start, windows, stages, say)
        say("writing down what was found", 0.0)
        found = _reported(model, space, stages, windows)
    except KeyboardInterrupt:
        known = _reported(model, space, stages, windows) if stages else None
        raise Interrupted(known and _finished(known, notes, began)) from None
    return _finished(found, notes, began)


def _finished(found: Diagnosis, notes: tuple[str, ...], began: float) -> Diagnosis:
    return dataclasses.replace(found, notes=(*notes, *found.notes), seconds=time.monotonic() - began)


def split(recordings: Sequence[Recording]) -> tuple[list[Recording], list[Recording]]:
    """The first three quarters of every recording, and the last one."""
    first: list[Recording] = []
    last: list[Recording] = []
    for each in recordings:
        at = int(len(each.t) * (1.0 - WITHHELD))
        for rows, parts in ((slice(0, at), first), (slice(at, None), last)):
            channels = {name: values[rows] for name, values in each.channels.items()}
            parts.append(Recording(each.t[rows], channels, meta=each.meta, name=each.name))
    return first, last


def window_noise(noise: Noise) -> cutting.Noise:
    """The same levels, as windows take them."""
    return cutting.Noise(np.maximum(noise.q, 1e-12), np.maximum(noise.theta, 1e-12), noise.tau)


def _search(
    space: Workspace, start: Hypothesis, windows: tuple[Windows, Windows], stages: list[Stage], say: Progress
) -> None:
    """Add effects one by one, each confirmed by windows that took no part in its fit; `stages` grows meanwhile."""
    fit_windows, check_windows = windows
    made = fit(start, space)
    stages.append(Stage(made, shoot(made.hypothesis.model(), check_windows), of_fit(made)))
    screen = Screen(space, lambda share: say("proposing", share))
    while len(stages) <= MOST_FINDINGS:
        say(f"looking for effect {len(stages)}", 0.0)
        after = _next(space, screen, stages[-1], check_windows)
        if after is None:
            return
        if after.fitted.reduced > ROUGH:
            after = _simulated(after, fit_windows, check_windows, say)
        stages.append(after)
        if after.fitted.reduced > ROUGH and after.check.gap < EXPLAINED:
            return


def _simulated(stage: Stage, fit_windows: Windows, check_windows: Windows, say: Progress) -> Stage:
    """The stage with its numbers fitted to simulated windows, where that is better on the check."""
    what = "fitting simulated windows"
    refined = refine(stage.fitted.hypothesis, fit_windows, progress=lambda share: say(what, share))
    shot = shoot(refined.hypothesis.model(), check_windows)
    if shot.gap > stage.check.gap:
        return stage
    return dataclasses.replace(stage, check=shot, numbers=refined)


def _next(space: Workspace, screen: Screen, now: Stage, windows: Windows) -> Stage | None:
    """The best candidate that the check confirms, with those that do as well."""
    ranked = candidates(space, screen, now.fitted)
    shots: dict[int, Shot] = {}
    for k, candidate in enumerate(ranked[:TRIED]):
        shots[k] = shoot(candidate.fitted.hypothesis.model(), windows)
        if not _confirmed(now, candidate, shots[k]):
            continue
        plain = _plainer(candidate, ranked, shots[k], windows)
        if plain is not None:
            return Stage(plain[0].fitted, plain[1], of_fit(plain[0].fitted), plain[0])
        rivals = []
        for other in ranked[k + 1 :]:
            if candidate.drop - other.drop > 10.0 + NEARLY * candidate.drop:
                break
            shot = shoot(other.fitted.hypothesis.model(), windows)
            if better(shot, shots[k]) < SURE:
                rivals.append(other)
        return Stage(candidate.fitted, shots[k], of_fit(candidate.fitted), candidate, tuple(rivals))
    return None


def _confirmed(now: Stage, candidate: Candidate, shot: Shot) -> bool:
    """Whether the check wants a candidate: surely less off window by window, and no more off in all."""
    if _unbends(now.fitted, candidate.fitted):
        return better(now.check, shot) > -SURE
    return better(now.check, shot) > SURE and shot.gap <= now.check.gap


def _unbends(before: Fit, after: Fit) -> bool:
    """Whether the file's numbers had been bent to do a candidate's work: then the check must only not get worse."""
    gained = before.chi2 - after.chi2
    return before.regression.prior_chi2 - after.regression.prior_chi2 > 0.5 * gained


def _plainer(
    candidate: Candidate, ranked: list[Candidate], shot: Shot, windows: Windows
) -> tuple[Candidate, Shot] | None:
    """An effect that the candidate's contains, where the check does not need what it has more."""
    for other in ranked:
        if other.effect is None or candidate.effect is None or not _same_place(other.effect, candidate.effect):
            continue
        if is_simpler(other.effect.name, candidate.effect.name):
            simple = shoot(other.fitted.hypothesis.model(), windows)
            if better(simple, shot) < SURE:
                return other, simple
    return None


def _same_place(one: Effect, other: Effect) -> bool:
    return all(getattr(one, key, None) == getattr(other, key, None) for key in ("joint", "side"))


def better(before: Shot, after: Shot) -> float:
    """By how many standard errors a model's windows are less off than another's, by gap or by white surprises.

    The gap sees what adds up over a window, the surprises what is wrong at an instant; an effect may show in one of
    them alone.
    """
    gaps = np.log(before.by_window) - np.log(after.by_window)
    surprises = np.log(before.misfit) - np.log(after.misfit)
    return max(_significance(gaps), _significance(surprises))


def _significance(drop: Array) -> float:
    """Mean over standard error, outermost tenths drawn in: a window on the wrong side of a stick decides nothing."""
    drop = drop[np.isfinite(drop)]
    if len(drop) < 2:
        return 0.0
    drop = np.clip(drop, *np.quantile(drop, [0.1, 0.9]))
    return float(drop.mean() / max(float(drop.std(ddof=1)) / np.sqrt(len(drop)), 1e-12))


def _reported(
    model: FlexibleJointModel, space: Workspace, stages: list[Stage], windows: tuple[Windows, Windows]
) -> Diagnosis:
    """What the stages say, with the gap of the model as given, calibrated and corrected."""
    last = simplified(stages[-1].numbers)
    corrected, calibrated = last.hypothesis.model(), stages[0].fitted
    gaps = []
    for each in windows:
        after = shoot(corrected, each)
        given = shoot(calibrated.hypothesis.model(), each)
        gaps.append(Gap(shoot(model, each).gap, given.gap, after.gap, after.floor()))
    findings = _findings(model, stages, last)
    explained = float(np.median(after.by_window)) <= EXPLAINED * max(gaps[1].floor, 1.0)
    verdict = "unexplained" if not explained else "explained" if findings else "no_discrepancy"
    mask = space.whiten.mask
    left = calibrated.regression.left[: len(mask)]  # white rows, a count more or less of the encoders allowed for
    return Diagnosis(
        verdict=verdict,
        findings=findings,
        calibration=calibrations(model, last),
        fit=gaps[0],
        check=gaps[1],
        where=() if verdict == "no_discrepancy" else localise(calibrated.equations, left, mask),
        model=corrected,
        notes=_notes(model, space.equations.data),
        residuals=traces(space.equations, space.equations.of(corrected), mask),
    )


def _findings(model: FlexibleJointModel, stages: list[Stage], last: Refined) -> tuple[Finding, ...]:
    """Confirmed effects with the numbers of the last fit, the one that explains most first."""
    first, final = stages[0].check.gap, stages[-1].check.gap
    found = []
    for before, after in itertools.pairwise(stages):
        gain = (before.check.gap - after.check.gap) / max(first - min(final, 1.0), 1e-9)
        made = finding(model, after.added, after.rivals, last, gain)
        if made is not None:
            found.append((gain, made))
    return tuple(entry for _, entry in sorted(found, key=lambda each: -each[0]))


def _notes(model: FlexibleJointModel, data: tuple[Measured, ...]) -> tuple[str, ...]:
    """What the channels that were measured cannot tell."""
    notes = []
    for j, joint in enumerate(model.joint_names):
        elastic, one = bool(model.elastic[j]), data[0]
        if elastic and not one.has_q[j]:
            notes.append(f"{joint}: no link encoder, so friction on link and motor are told apart by the spring alone")
        if elastic and not one.has_theta[j]:
            notes.append(f"{joint}: no motor encoder, so what happens at the rotor is seen through the spring alone")
    return tuple(notes)
