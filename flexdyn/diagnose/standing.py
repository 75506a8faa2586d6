"""Which names stand in the end: those whose numbers say so, and that leave little at their joints."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.findings import finding, out_of_tolerance
from flexdyn.diagnose.refine import Refined
from flexdyn.diagnose.result import Gap
from flexdyn.diagnose.search import Search
from flexdyn.diagnose.stage import Stage
from flexdyn.diagnose.verify import EXPLAINED, Trial
from flexdyn.model import FlexibleJointModel

Array = NDArray[np.float64]
BENT, TRACE = 3.0, 0.01
"""What the equations of a right model may leave over noise: so many times that, or a share of what was there before:
windows hardly see what a stiff spring does fast."""
LEFT = 0.1
"""Share of what was unexplained that may be left for names to stand, where not all is explained: in squares, of rows
and of windows."""

FAR_OFF, ASTRAY = 3.0, 10.0
"""Times the floor that the data of the fit may be off: an end stop that the check never meets is not explained. And
that the check may be off beside names, where one window may be on the wrong side of a stick; without any, no more than
the fit."""


def verdict(named: bool, gaps: Sequence[Gap], *, near: bool) -> str:
    """What the report says of the gap.

    Args:
        named: whether anything is.
        gaps: of the fit and of the check.
        near: whether windows and equations are as near as noise lets them, taken together.
    """
    most = (FAR_OFF, ASTRAY if named else FAR_OFF)
    if not near or any(gap.after > times * max(gap.floor, 1.0) for gap, times in zip(gaps, most, strict=True)):
        return "unexplained"
    return "explained" if named else "no_discrepancy"


def explained(stage: Stage, first: Stage) -> bool:
    """Whether windows are as near as noise lets them, and the equations as near as their filters do."""
    near = stage.trial.median <= EXPLAINED * max(stage.trial.floor, 1.0)
    bent = max(BENT * float(stage.trial.count.sum()), TRACE * first.trial.excess)
    return near and stage.trial.excess <= bent


def idle(model: FlexibleJointModel, stage: Stage, numbers: Refined) -> set[int]:
    """Places of names that their numbers do not stand for."""
    return {
        k
        for k, each in enumerate(stage.named)
        if not each.stays and finding(model, each.candidate, (), numbers, 0.0) is None
    }


def surely(model: FlexibleJointModel, search: Search, stage: Stage, numbers: Refined) -> Stage:
    """The stage without what its numbers do not stand for: the corrected model holds what is named and no more."""
    gone = idle(model, stage, numbers)
    return search.stage(*stage.without(gone)) if gone else stage


def standing(search: Search, first: Stage, last: Stage, numbers: Refined) -> Stage:
    """The stage with those names that leave little unexplained: in all, or at their own joints, if much was there.

    What is missing at one joint says nothing against a name at another. What a name leaves is counted with the numbers
    of the file within their tolerance; one of its own joint that is surely out of it, unnamed, did the name's work.
    """
    within = search.trial(numbers.hypothesis.tolerated())
    before, after = _excess(first), _excess(last)
    windows = np.maximum(_seen(last.trial, last), _seen(within, last)) / _seen(first.trial, last)
    names = last.fitted.equations.true.joint_names
    bent = {number.joint for number in out_of_tolerance(numbers)} - {None}
    most = last.trial.excess > LEFT * first.trial.excess
    gone = set()
    for k, each in enumerate(last.named):
        at = list(range(len(names))) if each.joint is None else [names.index(each.joint)]
        was, left = before[at].sum(), after[at].sum()
        much = most and (left > LEFT * was or was < LEFT * before.sum())
        if much or windows[at].min() > LEFT or each.joint in bent:
            gone.add(k)
    last = search.stage(*last.without(gone)) if gone else last
    return last if last.named else unbent(search, first)


def _seen(trial: Trial, stage: Stage) -> Array:
    """By how much the check's windows are off at every joint, squared, in units of noise and over it (n,)."""
    shot = trial.shot
    squares, used = (shot.scaled**2 * shot.used).sum(axis=(0, 1)), shot.used.sum(axis=(0, 1))
    joints = [name.partition(".")[2] for name in shot.windows.channels]
    names = stage.fitted.equations.true.joint_names
    mine = np.array([[joint == name for joint in joints] for name in names], dtype=float)
    return np.asarray(np.maximum(mine @ squares / np.maximum(mine @ used, 1.0) - 1.0, 1e-9))


def _excess(stage: Stage) -> Array:
    """What the equations of every joint leave over noise on the data of the fit (n,)."""
    made = stage.fitted
    mask, kinds = made.space.whiten.mask, made.equations.kinds
    squares = np.where(mask, 0.0, made.regression.left[: len(mask)] ** 2 - 1.0).reshape(-1, len(kinds)).sum(axis=0)
    of = np.array([i for i, _ in kinds])
    return np.array([max(1.0, float(squares[of == j].sum())) for j in range(made.equations.true.n)])


def unbent(search: Search, first: Stage) -> Stage:
    """The first stage with numbers within their tolerance, as given where that is nearer.

    A gap that nothing explains bends numbers without reason.
    """
    made = first.fitted
    given = dataclasses.replace(made.hypothesis, factors=dict.fromkeys(made.hypothesis.factors, 1.0))
    either = (made.hypothesis.tolerated(), given)
    trial, held = min(zip(search.trials(either), either, strict=True), key=lambda pair: pair[0].gap)
    return Stage(dataclasses.replace(made, hypothesis=held), trial)
