"""fd.diagnose: look for what is missing, confirm it on data that took no part, name it."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence

import numpy as np

from flexdyn.diagnose import windows as cutting
from flexdyn.diagnose.abreast import abreast
from flexdyn.diagnose.conclusion import concluded
from flexdyn.diagnose.covariance import Noise
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.measured import Measured, measured
from flexdyn.diagnose.noise import torque_noise
from flexdyn.diagnose.result import Diagnosis, Interrupted
from flexdyn.diagnose.sanity import check_recordings
from flexdyn.diagnose.screen import Screen
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.selection import forward
from flexdyn.diagnose.settling import settled
from flexdyn.diagnose.stage import Stage
from flexdyn.diagnose.verify import Check
from flexdyn.diagnose.windows import Windows
from flexdyn.diagnose.workspace import workspace
from flexdyn.model import FlexibleJointModel
from flexdyn.records import Recording

QUIETER = 0.9
"""Share of its level below which a torque's noise is taken anew."""
Progress = Callable[[str, float], None]
WITHHELD = 0.25
"""Share at the end of every recording that is kept for the check where no other data is given."""


def diagnose(
    model: FlexibleJointModel,
    fit: Sequence[Recording],
    check: Sequence[Recording] = (),
    *,
    thorough: bool = False,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find where a model and measurements disagree, name the missing effects, and add them.

    Args:
        model: as it is believed to be, with its tolerance.
        fit: recordings to learn from.
        check: recordings that take no part in the fit; none: the last quarter of every one of `fit` is withheld.
        thorough: where more than noise is left in the end, look again, every candidate's numbers fitted to simulated
            windows first; it takes minutes, worth it for measured robots, which no catalogue explains to the last.
        progress: called with the stage and the share of it that is done.

    Returns:
        The verdict, the findings, the corrected model.

    Raises:
        InputError: recordings that do not fit the model or cannot answer.
    """
    began = time.monotonic()
    say = progress or (lambda stage, share: None)
    fit_records, check_records = (list(fit), list(check)) if check else split(fit)
    data, withheld = (tuple(measured(model, each) for each in group) for group in (fit_records, check_records))
    say("reading the equations", 0.0)
    notes = check_recordings(model, data)
    stages: list[Stage] = []
    try:
        search, windows, start = prepared(model, (fit_records, check_records), (data, withheld), say)
        notes += tuple(search.screen.notes)
        stages.append(search.stage(start))
        forward(search, stages)
        quiet = False
        while softened(search, stages[-1]) or (not quiet and quieter(search, stages[-1])):
            quiet = not softened(search, stages[-1])
            found = stages[-1].fitted.hypothesis
            search, windows, _ = prepared(model, (fit_records, check_records), (data, withheld), say, found)
            # What is rigid has no place in an elastic joint's equations.
            first = stages[0] if any(each.stays for each in stages[-1].named) else search.stage(start)
            stages[:] = [first, search.stage(found, stages[-1].named)]
            forward(search, stages)
        stages.append(settled(search, stages[0], stages[-1]))
        answer = concluded(model, search, stages, windows, thorough=thorough)
    except KeyboardInterrupt:
        known = concluded(model, search, stages, windows, hurry=True) if stages else None
        raise Interrupted(known and _finished(known, notes, began)) from None
    return _finished(answer, notes, began)


def prepared(
    model: FlexibleJointModel,
    records: tuple[Sequence[Recording], Sequence[Recording]],
    data: tuple[tuple[Measured, ...], tuple[Measured, ...]],
    say: Progress,
    found: Hypothesis | None = None,
) -> tuple[Search, Windows, Hypothesis]:
    """What a search needs: equations and windows of the fit and of the check, each with the noise of its own data.

    Args:
        model: as given.
        records: of the fit and of the check.
        data: the same, measured.
        say: progress.
        found: what is known by now; the noise is what it leaves.
    """
    both = abreast(lambda group: workspace(model, group, found), data)
    (space, start, noise), (other, _, its_noise) = both
    check = Check(Windows.of(model, records[1], window_noise(its_noise)), other)
    screen = Screen(space, lambda share: say("proposing", share))
    return Search(space, screen, check, say), Windows.of(model, records[0], window_noise(noise)), start


def softened(search: Search, stage: Stage) -> bool:
    """Whether a joint has become elastic: it has other equations now."""
    return stage.fitted.space is not search.space


def quieter(search: Search, stage: Stage) -> bool:
    """Whether what was found leaves less noise than the model without it seemed to have."""
    made = stage.fitted
    if not stage.named:
        return False
    before = search.space.noise
    after = torque_noise(made.equations, made.equations.residual, made.space.whiten.mask, before)
    return bool((after < QUIETER * before.tau).any())


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
