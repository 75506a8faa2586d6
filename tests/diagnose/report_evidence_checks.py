"""What report.json must hold for a claim of report.html about the evidence of a finding, and its rivals."""

from __future__ import annotations

from typing import Any

from tests.diagnose.report_told import LIKELY, STRENGTH, Document, agrees, key_of, names_it


def probability(
    document: Document, told: str, any_of: str | None, words: str, short: str | None, *, place: int
) -> None:
    """Of the finding whose evidence this is, and the word for it."""
    entry = document["findings"][place]
    assert agrees(told, entry["probability"])
    assert bool(any_of) == bool(entry["indistinguishable_from"])
    assert LIKELY[words] <= entry["probability"]
    assert bool(short) == (entry["probability"] < 0.95)


def bayes(document: Document, told: str, strength: str, against: str | None, *, place: int) -> None:
    """The log Bayes factor and the word for it."""
    value = document["findings"][place]["evidence"]["log_bayes_factor"]
    assert agrees(told, value)
    assert value is None or (abs(value) >= STRENGTH[strength] and bool(against) == (value < 0.0))


def lost(document: Document, share: str, *, place: int) -> None:
    """The gain of the finding, which is one."""
    gain = document["findings"][place]["evidence"]["test_gain"]
    assert agrees(share, gain, 100.0)
    assert gain >= 0.0


def grown(document: Document, share: str, *, place: int) -> None:
    """The gain of the finding, which is none."""
    gain = document["findings"][place]["evidence"]["test_gain"]
    assert agrees(share, gain, -100.0)
    assert gain < 0.0


def _holding(document: Document, place: int) -> tuple[list[Any], list[Any]]:
    """Structures with one of the names of a finding, and those without."""
    entry = document["findings"][place]
    keys = [key_of(each) for each in (entry, *entry["indistinguishable_from"])]
    within: list[Any] = []
    without: list[Any] = []
    for each in document["structures"]:
        (within if any(key_of(effect) in keys for effect in each["effects"]) else without).append(each)
    return within, without


def every_one(document: Document, count: str, *, place: int) -> None:
    """All structures hold it."""
    within, without = _holding(document, place)
    assert (len(within), without) == (int(count), [])


def none_of(document: Document, count: str, *, place: int) -> None:
    """No structure holds it."""
    within, without = _holding(document, place)
    assert (within, len(without)) == ([], int(count))


def some_of(document: Document, some: str, count: str, *, place: int) -> None:
    """So many structures hold it."""
    within, without = _holding(document, place)
    assert (len(within), len(within) + len(without)) == (int(some), int(count))


def without_it(document: Document, instead: str, how: str, behind: str, told: str, *, place: int) -> None:
    """What the best structure without it has instead, and which of the two is better."""
    within, without = (sorted(each, key=lambda s: -s["log_evidence"]) for each in _holding(document, place))
    apart = within[0]["log_evidence"] - without[0]["log_evidence"]
    assert agrees(behind, abs(apart))
    assert how == ("lower" if apart >= 0.0 else "higher")
    assert agrees(told, without[0]["probability"])
    others = [key_of(each) for each in within[0]["effects"]]
    beyond = [each for each in without[0]["effects"] if key_of(each) not in others]
    assert all(names_it(each, instead) for each in beyond) if beyond else instead == "nothing"


def rivals(document: Document) -> None:
    """Some finding has another name."""
    assert any(each["indistinguishable_from"] for each in document["findings"])


def rival(document: Document, phrase: str, numbers: str | None, told: str) -> None:
    """A name that a finding may have, with its own probability."""
    entries = [each for each in document["findings"] if each["indistinguishable_from"]]
    names = [name for each in entries for name in (each, *each["indistinguishable_from"]) if names_it(name, phrase)]
    assert names, phrase
    own = [name["probability"] for name in names] + _own_probabilities(document, names)
    assert any(agrees(told, value) for value in own), (phrase, told)


def _own_probabilities(document: Document, names: list[Any]) -> list[float]:
    """Of the first name of a finding, whose own probability stands among the candidates."""
    keys = [key_of(each) for each in names]
    return [each["probability"] for each in document["considered"] if key_of(each) in keys]
