"""Hypotheses tried on data that takes no part: each question once, whatever threads answer it."""

from __future__ import annotations

import dataclasses
import time
from types import SimpleNamespace
from typing import Any

from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import file_numbers
from flexdyn.diagnose.search import REMEMBERED, Search
from tests.arms import two_link
from tests.oracles.two_link import TwoLink

MODEL = two_link(TwoLink())
GIVEN = Hypothesis(MODEL, dict.fromkeys(file_numbers(MODEL), 1.0))


def other(k: int) -> Hypothesis:
    """With its first number moved."""
    number = next(iter(GIVEN.factors))
    return dataclasses.replace(GIVEN, factors={**GIVEN.factors, number: 1.0 + 1e-3 * k})


class Asked:
    """A check that takes the longer, the earlier it was asked, and remembers what it was asked near."""

    def __init__(self) -> None:
        self.near: dict[Hypothesis, Any] = {}

    def of(self, hypothesis: Hypothesis, near: Any) -> Any:
        """What `Check.of` answers."""
        assert hypothesis not in self.near
        self.near[hypothesis] = near
        time.sleep(0.05 / len(self.near))
        return SimpleNamespace(shot=("shot of", hypothesis))


def test_trials_stand_in_their_order_and_are_made_once() -> None:
    """All that are asked for together begin near the last one before."""
    check: Any = Asked()
    nothing: Any = None
    search = Search(nothing, nothing, check, nothing)
    first = search.trial(GIVEN)
    some = [other(k) for k in range(1, 6)]
    again = dataclasses.replace(some[1])
    found: list[Any] = list(search.trials([GIVEN, *some, again]))
    assert found[0] is first
    assert [each.shot[1].factors for each in found[1:6]] == [each.factors for each in some]
    assert found[6] is found[2]
    assert check.near[GIVEN] is None
    assert len(check.near) == 6
    assert all(near == first.shot for each, near in check.near.items() if each is not GIVEN)
    search.trial(other(7))
    assert check.near[next(reversed(check.near))] == found[5].shot  # not what happened to be done last


def test_old_trials_are_forgotten() -> None:
    """Each holds what every window does."""
    check: Any = Asked()
    nothing: Any = None
    search = Search(nothing, nothing, check, nothing)
    search.trials([other(k) for k in range(REMEMBERED + 3)])
    assert len(search._known) == REMEMBERED
