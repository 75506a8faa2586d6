"""Which proposals are fitted in full, and which of these the check is asked about."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from flexdyn.diagnose import candidates as module
from flexdyn.diagnose import selection
from flexdyn.diagnose.candidates import candidates
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import FileNumber, file_numbers
from tests.arms import two_link
from tests.oracles.two_link import TwoLink

MODEL = two_link(TwoLink())
COM = next(n for n in file_numbers(MODEL) if n.parameter == "link_com")
BEFORE = 7000.0


def proposal(score: float) -> Any:
    """What the screen promises."""
    return SimpleNamespace(score=score)


def fitted(chi2: float, number: FileNumber | None = None) -> Any:
    """A candidate that leaves so much."""
    left = SimpleNamespace(reduced=4.0, chi2=chi2)
    return SimpleNamespace(chi2=chi2, cost=0.0, drop=BEFORE - chi2, number=number, effect=None, fitted=left)


@pytest.mark.parametrize(("kept", "asked"), [(3500.0, [3500.0, 900.0, 230.0]), (800.0, [3500.0, 900.0, 230.0, 160.0])])
def test_a_promise_that_was_not_kept_hides_no_other(
    kept: float, asked: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A twentieth of what the leading ones turned out to be good for is enough to be fitted, and ten at least."""
    seen: list[float] = []

    def fit(_made: Any, _space: Any, choice: Any, _scale: float, _hopeless: float) -> Any:
        seen.append(choice.score)
        return fitted(BEFORE - (kept if choice.score == 3500.0 else min(kept, choice.score)))

    monkeypatch.setattr(module, "_fitted", fit)
    screen: Any = SimpleNamespace(ranked=lambda *_: [proposal(x) for x in (3500.0, 900.0, 230.0, 160.0, 12.0, 8.0)])
    space: Any = SimpleNamespace(equations=SimpleNamespace(made_up=SimpleNamespace(any=lambda: True)))
    made: Any = SimpleNamespace(reduced=1.0, chi2=BEFORE, hypothesis=SimpleNamespace(effects=(), freed=frozenset()))
    found = candidates(space, screen, made)
    assert sorted(seen, reverse=True) == asked
    assert [each.chi2 for each in found] == sorted(each.chi2 for each in found)


def test_where_nothing_promises_enough_there_are_none() -> None:
    """Ten is the least."""
    screen: Any = SimpleNamespace(ranked=lambda *_: [proposal(9.0)])
    made: Any = SimpleNamespace(reduced=1.0, chi2=BEFORE, hypothesis=SimpleNamespace(effects=(), freed=frozenset()))
    assert candidates(SimpleNamespace(), screen, made) == []  # type: ignore[arg-type]


@pytest.mark.parametrize(("factor", "asked"), [(1.4, True), (1.05, False)])
def test_a_number_bent_beyond_its_tolerance_is_always_asked_about(factor: float, asked: bool) -> None:
    """Set free it leaves hardly less, as it stands where it belongs already; what leaves most less may be wrong."""
    best, free = fitted(0.8 * BEFORE), fitted(0.99 * BEFORE, COM)
    bent = Hypothesis(MODEL, {**dict.fromkeys(file_numbers(MODEL), 1.0), COM: factor})
    before: Any = SimpleNamespace(
        chi2=BEFORE, hypothesis=bent, factor_std=lambda: dict.fromkeys(bent.factors, 0.01), std=dict
    )
    assert selection._worth_a_try(before, [best, free]) == [best, *[free] * asked]
