"""Which of two structures is told: an exchange of laws must name the new one, and cost no other effect its name."""

from __future__ import annotations

import importlib
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

TOLD = importlib.import_module("flexdyn.diagnose.decision.told")
KEPT, EXCHANGED, NEW = 1, 2, 3


def _posterior(*candidates: int) -> Any:
    """With these in its best structure."""
    return SimpleNamespace(best=frozenset((c, 0) for c in candidates))


@pytest.mark.parametrize(
    ("before", "after", "exchanged"),
    [
        ({KEPT, EXCHANGED}, {KEPT, NEW}, True),
        ({KEPT}, {KEPT, NEW}, True),
        ({KEPT}, {NEW}, False),  # the name of what stays would be lost
        ({KEPT}, {KEPT}, False),  # what was put in place has no name
    ],
)
def test_an_exchange_names_the_new_law_and_costs_no_other_name(
    monkeypatch: pytest.MonkeyPatch, before: set[int], after: set[int], exchanged: bool
) -> None:
    """What is named is given here; the exchange itself is that of `by_plainer_laws`."""
    one, other = _posterior(KEPT, EXCHANGED), _posterior(KEPT, NEW)
    named = {id(one): before, id(other): after}

    def corrected(found: Any, *_: object) -> Any:
        names = [SimpleNamespace(candidate=c) for c in named[id(found)]]
        return SimpleNamespace(names=names, genuine={})

    monkeypatch.setattr(TOLD, "corrected", corrected)
    monkeypatch.setattr(TOLD, "needed_in_fits", lambda found: found)
    monkeypatch.setattr(TOLD, "rivals_in_fits", lambda found: found)
    monkeypatch.setattr(TOLD, "by_plainer_laws", lambda found, genuine: other)
    monkeypatch.setattr(TOLD, "in_one_law", lambda found, names: found)
    monkeypatch.setattr(TOLD, "_without_imitations", lambda compared, found: compared)
    plain = SimpleNamespace(equations=SimpleNamespace(replayed=np.array([False])))
    told, _ = TOLD.told(one, plain)
    assert told is (other if exchanged else one)
