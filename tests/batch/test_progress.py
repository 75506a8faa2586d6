"""How far a study is: what it says at a rate that is known."""

from __future__ import annotations

import itertools

import pytest

from flexdyn.batch import progress
from flexdyn.batch.progress import Meter, duration


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A clock that is set by hand."""
    now = [0.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


def test_a_steady_study(clock: list[float]) -> None:
    """Ten runs a second: what is left takes a tenth of a second a run; those of before count as done, not as fast."""
    meter = Meter(1000, 400)
    assert (meter.now().rate, meter.now().remaining) == (0.0, None)
    assert str(meter.now()) == "400 of 1000 runs"
    for step in range(1, 31):
        clock[0] = float(step)
        told = meter.add(10, int(step == 30))
    assert told.rate == pytest.approx(10.0)
    assert told.remaining == pytest.approx(30.0)
    assert str(told) == "700 of 1000 runs, 1 failed, 10 runs/s, 30 s left"


def test_the_rate_is_that_of_now(clock: list[float]) -> None:
    """Where the machine becomes ten times slower, the time left follows within half a minute."""
    meter = Meter(10_000)
    for clock[0] in itertools.chain(range(1, 61), range(70, 200, 10)):
        told = meter.add(10, 0)
    assert told.rate == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.2, "0 s"),
        (59.4, "59 s"),
        (60.0, "1 min 0 s"),
        (3599.7, "1 h"),
        (3661.0, "1 h 1 min"),
        (86400 * 3 + 7200, "3 d 2 h"),
    ],
)
def test_times_for_people(seconds: float, words: str) -> None:
    """The two largest units; no minutes where there are none."""
    assert duration(seconds) == words
