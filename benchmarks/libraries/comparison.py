"""What is compared of a library and of our own code, and the rule that decides between them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from measure import Contestant, race, ratio

SLOWER = 2.0
"""Our own code stays where the library needs more than so many times its processor time."""
ROUNDS = 7


@dataclass(frozen=True)
class Case:
    """One file or input, and whether it comes out right.

    Attributes:
        name: what it is.
        ours: "" where our code is right, else what it does.
        library: the same of the library.
    """

    name: str
    ours: str
    library: str


@dataclass(frozen=True)
class Comparison:
    """One task.

    Attributes:
        task: in words.
        ours: module that does it.
        library: name of the library and of its function.
        cases: right or wrong.
        times: name of the input -> processor time of the library over that of our code.
        missing: why the library is not always there; "" where it is.
    """

    task: str
    ours: str
    library: str
    cases: Sequence[Case]
    times: dict[str, float]
    missing: str = ""

    @property
    def reasons(self) -> list[str]:
        """Why our own code stays; none where the library takes its place."""
        wrong = [case.name for case in self.cases if case.library and not case.ours]
        slow = [f"{times:.1f} times slower ({name})" for name, times in self.times.items() if times > SLOWER]
        told = [f"wrong on {len(wrong)} of {len(self.cases)} inputs"] if wrong else []
        return [*told, *slow, *([self.missing] if self.missing else [])]

    def to_dict(self) -> dict[str, Any]:
        """As the result file holds it."""
        return {
            "task": self.task,
            "ours": self.ours,
            "library": self.library,
            "cases": [vars(case) for case in self.cases],
            "library_time_over_ours": {name: round(times, 2) for name, times in self.times.items()},
            "reasons": self.reasons,
            "decision": "ours" if self.reasons else "library",
        }


def times_of(library: Callable[[], object], ours: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Processor time of the library over that of our code: median of rounds in which both work."""
    times = race([Contestant("library", library), Contestant("ours", ours)], rounds)
    return ratio(times, "library", "ours")


def outcome(work: Callable[[], bool]) -> str:
    """Nothing where the work says that its result is right; else "another result", or the error in a word."""
    try:
        return "" if work() else "another result"
    except Exception as error:  # whatever a library raises is its answer
        return type(error).__name__
