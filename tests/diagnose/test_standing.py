"""Names stand where their numbers and the windows of their joints say so; what falls leaves the model."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.candidates import Candidate
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import file_numbers
from flexdyn.diagnose.refine import Refined
from flexdyn.diagnose.result import Gap
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.standing import standing, surely, verdict
from tests.arms import two_link
from tests.oracles.two_link import TwoLink

DRAG = fd.effects.QuadraticDrag("shoulder", side="link", coefficient=0.3)
OFFSET = fd.effects.TorqueOffset("elbow", offset=0.2)
MODEL = two_link(TwoLink())


def stage(squares: tuple[float, float], gaps: tuple[float, float], *effects: fd.effects.Effect) -> Stage:
    """What equations leave over noise at both joints, by how much windows are off there, and what was named.

    The check's equations leave a tenth of the fit's.
    """
    rows = np.sqrt(np.tile(squares, 100) + 1.0)
    fitted: Any = SimpleNamespace(
        hypothesis=Hypothesis(MODEL, {}, effects=effects),
        space=SimpleNamespace(whiten=SimpleNamespace(mask=np.zeros(200, dtype=bool))),
        equations=SimpleNamespace(kinds=((0, "total"), (1, "total")), true=MODEL),
        regression=SimpleNamespace(left=rows),
    )
    windows = SimpleNamespace(channels=("q.shoulder", "q.elbow"))
    shot = SimpleNamespace(
        scaled=np.tile(gaps, (3, 50, 1)).astype(float), used=np.ones((3, 50, 2), dtype=bool), windows=windows
    )
    trial: Any = SimpleNamespace(shot=shot, excess=10.0 * sum(squares))
    named = tuple(Named(Candidate(fitted, 100.0, 0.0, each, None, 0.0)) for each in effects)
    return Stage(fitted, trial, named)


def searched(left: list[tuple[fd.effects.Effect, ...]], within: Any = None) -> Any:
    """A search that writes down what it is asked to fit again, and that tries whatever it is asked with one result."""

    def again(start: Hypothesis, named: tuple[Named, ...]) -> Stage:
        left.append(start.effects)
        return Stage(stage((1.0, 1.0), (1.0, 1.0), *start.effects).fitted, SimpleNamespace(), named)  # type: ignore[arg-type]

    return SimpleNamespace(stage=again, trial=lambda hypothesis: within)


@pytest.mark.parametrize(
    ("squares", "gaps", "kept"),
    [
        ((2.0, 2.0), (3.0, 3.0), (DRAG, OFFSET)),  # little is left, in equations and windows
        ((2.0, 2.0), (4.0, 3.0), (OFFSET,)),  # more than a tenth of what was in the shoulder's windows, squared
        ((80.0, 2.0), (3.0, 3.0), (OFFSET,)),  # of what was in the shoulder's equations
    ],
)
def test_a_name_stands_where_its_joint_is_explained(
    squares: tuple[float, float], gaps: tuple[float, float], kept: tuple[fd.effects.Effect, ...]
) -> None:
    """Before, equations left 100 at each joint, and windows were ten times the noise off."""
    first, last = stage((100.0, 100.0), (10.0, 10.0)), stage(squares, gaps, DRAG, OFFSET)
    left: list[tuple[fd.effects.Effect, ...]] = []
    after = standing(searched(left, last.trial), first, last, Refined(last.fitted.hypothesis, np.zeros(2)))
    assert tuple(each.candidate.effect for each in after.named) == kept
    assert left == ([] if kept == (DRAG, OFFSET) else [kept])


def test_a_name_does_not_stand_on_numbers_out_of_their_tolerance() -> None:
    """Windows that only a bent number brings near are as far off without it."""
    first, last = stage((100.0, 100.0), (10.0, 10.0)), stage((2.0, 2.0), (3.0, 3.0), DRAG, OFFSET)
    unbent = stage((2.0, 2.0), (3.0, 5.0)).trial
    left: list[tuple[fd.effects.Effect, ...]] = []
    standing(searched(left, unbent), first, last, Refined(last.fitted.hypothesis, np.zeros(2)))
    assert left == [(DRAG,)]


@pytest.mark.parametrize(("std", "kept"), [(0.3, (DRAG, OFFSET)), (0.05, (DRAG,))])
def test_a_number_of_its_joint_that_did_its_work_speaks_against_a_name(
    std: float, kept: tuple[fd.effects.Effect, ...]
) -> None:
    """The elbow's stiffness is half as much again, out of its tolerance, more or less surely."""
    first, last = stage((100.0, 100.0), (10.0, 10.0)), stage((2.0, 2.0), (3.0, 3.0), DRAG, OFFSET)
    stiffness = next(n for n in file_numbers(MODEL) if (n.of, n.parameter) == ("elbow", "stiffness"))
    bent = Refined(Hypothesis(MODEL, {stiffness: 1.5}, effects=(DRAG, OFFSET)), np.array([std, 0.0, 0.0]))
    left: list[tuple[fd.effects.Effect, ...]] = []
    after = standing(searched(left, last.trial), first, last, bent)
    assert tuple(each.candidate.effect for each in after.named) == kept


@pytest.mark.parametrize(("std", "kept"), [(0.01, (DRAG, OFFSET)), (0.1, (DRAG,))])
def test_what_is_not_named_leaves_the_model(std: float, kept: tuple[fd.effects.Effect, ...]) -> None:
    """An offset that is less than three standard deviations from none is not named, so the model must not hold it."""
    last = stage((1.0, 1.0), (1.0, 1.0), DRAG, OFFSET)
    left: list[tuple[fd.effects.Effect, ...]] = []
    numbers = Refined(last.fitted.hypothesis, np.array([0.01, std]))
    after = surely(MODEL, searched(left), last, numbers)
    assert tuple(each.candidate.effect for each in after.named) == kept
    assert left == ([] if kept == (DRAG, OFFSET) else [kept])


@pytest.mark.parametrize(
    ("named", "fit", "check", "near", "said"),
    [
        (False, 1.1, 1.2, True, "no_discrepancy"),
        (False, 1.1, 40.0, True, "unexplained"),  # a stop that the fit never meets
        (True, 1.1, 6.0, True, "explained"),  # one window on the wrong side of a stick
        (True, 1.1, 40.0, True, "unexplained"),
        (True, 4.0, 1.0, True, "unexplained"),
        (True, 1.1, 1.2, False, "unexplained"),
    ],
)
def test_the_verdict_is_of_both_recordings(named: bool, fit: float, check: float, near: bool, said: str) -> None:
    """With a floor of 1, and of less, which counts as 1."""
    gaps = [Gap(50.0, 50.0, fit, 1.0), Gap(50.0, 50.0, check, 0.8)]
    assert verdict(named, gaps, near=near) == said
