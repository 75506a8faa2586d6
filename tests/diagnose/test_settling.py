"""What stays of many names that were added one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

import flexdyn as fd
from flexdyn.diagnose import settling
from flexdyn.diagnose.candidates import Candidate
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.stage import Named, Stage
from tests.arms import two_link
from tests.oracles.two_link import TwoLink

MODEL = two_link(TwoLink())
DRAG = fd.effects.QuadraticDrag("shoulder", side="link", coefficient=0.3)
OTHERS = tuple(
    fd.effects.TorqueRipple("elbow", amplitude=size, harmonic=harmonic, phase=0.0)
    for size, harmonic in ((0.1, 3.0), (0.2, 4.0), (0.3, 5.0))
)


def stage(effects: tuple[fd.effects.Effect, ...], named: tuple[Named, ...] | None = None) -> Stage:
    """With so many effects; the more ripples are left out, the worse the fit, by their amplitude."""
    gone = sum(each.amplitude for each in OTHERS if each not in effects)
    fitted: Any = SimpleNamespace(hypothesis=Hypothesis(MODEL, {}, effects=effects), chi2=100.0 + gone)
    names = tuple(Named(Candidate(fitted, 100.0, 0.0, each, None, 0.0)) for each in effects)
    trial: Any = SimpleNamespace()
    return Stage(fitted, trial, names if named is None else named)


@pytest.mark.parametrize(
    ("needed", "left", "fits"),
    [
        (0, (DRAG,), 4 + 1 + 1),  # all that can be left out at once, and the drag asked about once more
        (1, (DRAG, OTHERS[2]), 4 + 1 + 3 + 2),  # not all together: the weakest first
        (3, (DRAG, *OTHERS), 4),
    ],
)
def test_what_the_check_does_not_miss_leaves(
    needed: int, left: tuple[fd.effects.Effect, ...], fits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The check misses the drag, and ripples where fewer than so many of them are left."""
    asked = []

    def fitted(start: Hypothesis, named: tuple[Named, ...], hopeless: float = math.inf) -> Stage:
        assert hopeless > 250.0  # a fit that is worse only by what is asked about is not given up
        asked.append(start.effects)
        return stage(start.effects, named)

    def all_fitted(starts: Sequence[tuple[Hypothesis, tuple[Named, ...]]], hopeless: float) -> list[Stage]:
        return [fitted(*each, hopeless) for each in starts]

    def missed(less: Stage, more: Stage) -> bool:
        some, all_of = (each.fitted.hypothesis.effects for each in (less, more))
        ripples = sum(each in some for each in OTHERS)
        return (DRAG in all_of and DRAG not in some) or ripples < min(needed, sum(each in all_of for each in OTHERS))

    monkeypatch.setattr(settling, "_missed", missed)
    search: Any = SimpleNamespace(stage=fitted, stages=all_fitted, say=lambda *_: None)
    after = settling.pruned(search, stage((DRAG, *OTHERS)))
    assert after.fitted.hypothesis.effects == left
    assert len(asked) == fits
