"""The progress of a study: finished runs, rate, and time left."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from time import monotonic

RATE_WINDOW = 30.0
"""Time over which the rate is averaged [s]: long against a chunk, short against changes of the machine's load."""


@dataclass(frozen=True)
class Progress:
    """A study in progress.

    Attributes:
        done: number of stored runs, earlier ones included.
        count: number of all runs.
        failed: number of failed runs since the start of this process.
        rate: runs per second; 0 while it is not known.
    """

    done: int
    count: int
    failed: int
    rate: float

    @property
    def remaining(self) -> float | None:
        """Time left [s]; None while it is not known."""
        return (self.count - self.done) / self.rate if self.rate > 0 else None

    def __str__(self) -> str:
        """One line for people."""
        failed = f", {self.failed} failed" if self.failed else ""
        rate = f", {self.rate:.3g} runs/s" if self.rate else ""
        left = "" if self.remaining is None else f", {duration(self.remaining)} left"
        return f"{self.done} of {self.count} runs{failed}{rate}{left}"


class Meter:
    """Counts finished runs.

    Args:
        count: number of all runs.
        done: number of runs that were stored before.
    """

    def __init__(self, count: int, done: int = 0) -> None:
        self._count, self._done, self._failed = count, done, 0
        self._seen = deque([(monotonic(), done)])

    def add(self, runs: int, failed: int) -> Progress:
        """Count more finished runs.

        Args:
            runs: their number.
            failed: number of failed ones.
        """
        now = monotonic()
        self._done += runs
        self._failed += failed
        self._seen.append((now, self._done))
        while len(self._seen) > 2 and now - self._seen[1][0] > RATE_WINDOW:
            self._seen.popleft()
        return self.now()

    def now(self) -> Progress:
        """The present progress."""
        (start, before), (end, after) = self._seen[0], self._seen[-1]
        rate = (after - before) / (end - start) if end > start else 0.0
        return Progress(self._done, self._count, self._failed, rate)


def duration(seconds: float) -> str:
    """A time as text, in its two largest units.

    Args:
        seconds: [s].
    """
    whole = max(0, round(seconds))
    units = (("d", whole // 86400), ("h", whole // 3600 % 24), ("min", whole // 60 % 60), ("s", whole % 60))
    first = next((i for i, (_, amount) in enumerate(units) if amount), len(units) - 1)
    return " ".join(f"{amount} {unit}" for unit, amount in units[first : first + 2] if amount or unit == "s")
