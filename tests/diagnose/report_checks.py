"""What report.json must hold for a claim of report.html to be true.

None of flexdyn's own formatting is used: a number is read as it is printed and may be off by its last digit, as
probabilities are rounded down.
"""

from __future__ import annotations

import math
import re
from typing import Any

Document = dict[str, Any]
LIKELY = {
    "virtually certain": 0.99,
    "extremely likely": 0.95,
    "very likely": 0.90,
    "likely": 0.66,
    "more likely than not": 0.5,
}
STRENGTH = {"very strong": 5.0, "strong": 3.0, "positive": 1.0, "weak": 0.0}


def agrees(text: str, value: float | None, scale: float = 1.0) -> bool:
    """Whether a printed number is a value, to its last digit; what is not finite is null in JSON."""
    text = text.replace(" ", "")
    if text in ("unknown", "beyondmeasure", "-beyondmeasure"):
        return value is None
    if value is None:
        return False
    if text.startswith("above"):
        return value * scale > 0.999
    if text.startswith("below"):
        return value * scale < 0.001
    mantissa, _, exponent = text.partition("e")
    digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(value * scale - float(text)) <= 1.001 * digit


def held(finding: dict[str, Any], phrase: str) -> bool:
    """Whether a phrase names an effect or one of its rivals where they are."""
    return all(_named(name, phrase) for name in (finding, *finding["indistinguishable_from"]))


def _named(suspect: dict[str, Any], phrase: str) -> bool:
    words = phrase.lower()
    if suspect["effect"] == "parameter_error":
        number = suspect["parameter"].removeprefix("link_").replace("_", " ").replace("com", "centre of mass")
        return number in words and "wrong" in words
    places = [suspect.get("channel") or suspect.get("joint") or suspect.get("frame") or ""]
    return suspect["effect"].replace("_", " ") in words and all(place.lower() in words for place in places)


def _one(document: Document, phrase: str, probability: str) -> None:
    """Some finding has this phrase and this probability."""
    fits = [each for each in document["findings"] if held(each, phrase)]
    assert any(agrees(probability, each["probability"]) for each in fits), (phrase, probability)


def agreement(document: Document, count: str | None) -> None:
    """Nothing found; so many calibrated numbers whose interval does not hold what was given."""
    assert document["verdict"] == "no_discrepancy"
    assert document["findings"] == []
    moved = sum(abs(each["factor"] - 1.0) > 1.96 * each["std"] for each in document["calibration"])
    assert moved == int(count or 0)


def many_causes(document: Document, count: str, first: str, probability: str) -> None:
    """The number of findings, and the first of them."""
    assert document["verdict"] in ("explained", "partly_explained")
    assert len(document["findings"]) == int(count)
    assert held(document["findings"][0], first)
    assert agrees(probability, document["findings"][0]["probability"])


def few_causes(document: Document, told: str) -> None:
    """All findings, each with its probability."""
    assert document["verdict"] in ("explained", "partly_explained")
    named(document, told)
    assert told.count("probability") == len(document["findings"])


def named(document: Document, told: str) -> None:
    """A list of findings with their probabilities."""
    for phrase, probability in re.findall(r"(.+?) \((?:together )?probability ([^)]+)\)(?: and )?", told):
        _one(document, phrase, probability)


def only_noise_is_left(document: Document) -> None:
    """The verdict says so."""
    assert document["verdict"] == "explained"


def left(document: Document, most: str | None, share: str, joint: str, depends: str | None) -> None:
    """The joint of which most is left, how much that is, and what it changes with."""
    worst = max(document["left"], key=lambda each: each["share_of_torque"])
    assert document["verdict"] == "partly_explained"
    assert (joint, bool(most)) == (worst["joint"], len(document["left"]) > 1)
    assert agrees(share, worst["share_of_torque"], 100.0)
    assert set(re.split(r", | and ", depends or "")) - {""} == set(worst["depends_on"])


def not_established(document: Document, phrase: str | None, probability: str | None) -> None:
    """No probability reaches 0.95, and the one that is told is the largest."""
    assert document["verdict"] == "unexplained"
    entries = [*document["findings"], *document["considered"]]
    weak = [each["probability"] for each in entries if each["probability"] is not None]
    assert all(each < 0.95 for each in weak) or phrase is None
    if phrase is not None and probability is not None:
        assert agrees(probability, max(weak))
        best = max(entries, key=lambda each: each["probability"] or 0.0)
        assert _named(best, phrase)


def appears(document: Document, joint: str) -> None:
    """The place with the largest share."""
    assert document["where"][0]["joint"] == joint.split(" ")[-1]
    assert document["where"][0]["share"] == max(each["share"] for each in document["where"])


def unconverged(document: Document, told: str) -> None:
    """It stands in the notes."""
    assert any(told in note for note in document["notes"])


def beyond_convergence(document: Document, told: str | None) -> None:
    """Established findings alone."""
    firm = [each for each in document["findings"] if each["probability"] >= 0.95]
    assert document["verdict"] == "not_converged"
    assert bool(firm) == bool(told)
    named(document, told or "")


def interrupted(document: Document, stage: str | None) -> None:
    """The stage at which it was."""
    assert document["verdict"] == "interrupted"
    stopped = re.sub(r"\W+", " ", document["stopped_at"] or "")
    assert re.sub(r"\W+", " ", (stage or "").replace(", stage ", " ")).split() == stopped.split()


def by_then(document: Document, told: str) -> None:
    """All findings of 0.95 and more, and no others."""
    named(document, told)
    more = re.search(r" and (\d+) more", told)
    firm = sum(each["probability"] >= 0.95 for each in document["findings"])
    assert firm == told.count("probability") + int(more[1] if more else 0)


def nothing_by_then(document: Document, first: str | None) -> None:
    """No finding of 0.95; the first structure where one is told."""
    assert not [each for each in document["findings"] if each["probability"] >= 0.95]
    if first is not None and not first.startswith(("a set", "no effect")):
        assert all(_named(each, first) for each in document["structures"][0]["effects"])


def unopened(document: Document) -> None:
    """Nothing was measured on the test data."""
    assert document["gap"]["test"] is None


def finding(document: Document, phrase: str, each: str | None, words: str, probability: str) -> None:
    """A line of the list at the top: one finding, or one effect at several joints."""
    fits = [entry for entry in document["findings"] if held(entry, phrase)]
    assert fits, phrase
    least = min(entry["probability"] for entry in fits) if each else None
    chosen = [entry for entry in fits if agrees(probability, entry["probability"])]
    assert chosen if least is None else agrees(probability, least), (phrase, probability)
    assert LIKELY[words] <= chosen[0]["probability"]


def gap(document: Document, data: str, before: str, after: str, floor: str) -> None:
    """The three numbers; the data of the fit only where there is nothing else."""
    entry = document["gap"]["test" if data == "test data" else "fit"]
    told = (before, after, floor)
    assert all(agrees(text, entry[key]) for text, key in zip(told, ("before", "after", "floor"), strict=True))
    assert data == "test data" or document["gap"]["test"] is None


def no_gap(document: Document, how: str) -> None:
    """There is none."""
    assert document["gap"] == {"fit": None, "test": None} or document["gap"]["fit"] is None
    assert (document["verdict"] == "interrupted") == (how == "was not")


def worst(document: Document, joint: str, greatest: str | None, *told: str) -> None:
    """Errors of a joint, and that its share is the greatest where that is said."""
    torque = document["errors"][joint]["torque"]
    *errors, unit, first, last = told
    assert all(agrees(text, torque[key]) for text, key in zip(errors, ("before", "after"), strict=True))
    assert unit == torque["unit"]
    assert agrees(first, torque["share_before"], 100.0)
    assert agrees(last, torque["share_after"], 100.0)
    shares = [each["torque"]["share_before"] or 0.0 for each in document["errors"].values()]
    assert not greatest or torque["share_before"] == max(shares)


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
    keys = [_key(each) for each in (entry, *entry["indistinguishable_from"])]
    within: list[Any] = []
    without: list[Any] = []
    for each in document["structures"]:
        (within if any(_key(effect) in keys for effect in each["effects"]) else without).append(each)
    return within, without


def _key(suspect: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(
        suspect.get(key) for key in ("effect", "joint", "side", "channel", "of", "parameter", "other", "frame")
    )


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
    others = [_key(each) for each in within[0]["effects"]]
    beyond = [each for each in without[0]["effects"] if _key(each) not in others]
    assert all(_named(each, instead) for each in beyond) if beyond else instead == "nothing"


def rivals(document: Document) -> None:
    """Some finding has another name."""
    assert any(each["indistinguishable_from"] for each in document["findings"])


def rival(document: Document, phrase: str, numbers: str | None, told: str) -> None:
    """A name that a finding may have, with its own probability."""
    entries = [each for each in document["findings"] if each["indistinguishable_from"]]
    names = [name for each in entries for name in (each, *each["indistinguishable_from"]) if _named(name, phrase)]
    assert names, phrase
    own = [name["probability"] for name in names] + _own_probabilities(document, names)
    assert any(agrees(told, value) for value in own), (phrase, told)


def _own_probabilities(document: Document, names: list[Any]) -> list[float]:
    """Of the first name of a finding, whose own probability stands among the candidates."""
    keys = [_key(each) for each in names]
    return [each["probability"] for each in document["considered"] if _key(each) in keys]


def noise_leaves(document: Document, share: str) -> None:
    """What noise leaves; the shares beside it add up."""
    assert agrees(share, document["shares"]["noise"], 100.0)
    given = document["shares"]
    assert math.isclose(given["calibration"] + sum(given["findings"]) + given["left"], 1.0, abs_tol=1e-9)


def dashed(document: Document, floor: str) -> None:
    """The floor of one of the gaps."""
    floors = [entry["floor"] for entry in document["gap"].values() if entry is not None]
    assert any(agrees(floor, value) for value in floors)


def _drift(entry: dict[str, Any]) -> float:
    return abs(float(entry["factor"]) - 1.0) / (float(entry["tolerance"]) or 1.0)


def within_tolerance(document: Document, limit: str) -> None:
    """No number moved farther."""
    assert all(_drift(each) <= float(limit) for each in document["calibration"])


def beyond_tolerance(document: Document, count: str, limit: str) -> None:
    """So many numbers moved farther."""
    assert sum(_drift(each) > float(limit) for each in document["calibration"]) == int(count)


def nothing_to_note(document: Document) -> None:
    """No notes but those of the head."""
    assert [note for note in document["notes"] if "model.yaml" not in note] == []


def nothing_to_measure(document: Document) -> None:
    """No finding has an experiment."""
    assert not [each for each in document["findings"] if each["experiment"]]


def more_motion(document: Document, joint: str, regime: str | None) -> None:
    """A joint at which something is left."""
    assert document["verdict"] in ("unexplained", "partly_explained")
    assert joint in {each["joint"] for each in (*document["where"], *document["left"])}
    assert regime is None or any(each["regime"] == regime for each in document["where"])


def once_more(document: Document) -> None:
    """Something is left."""
    assert document["verdict"] in ("unexplained", "partly_explained")


def second_recording(document: Document) -> None:
    """There were no test data."""
    assert document["gap"]["test"] is None


def to_its_end(document: Document) -> None:
    """It was interrupted."""
    assert document["verdict"] == "interrupted"


def took(document: Document, seconds: str) -> None:
    """To the second."""
    assert abs(document["seconds"] - float(seconds)) <= 0.51


def done(document: Document, version: str, command: str) -> None:
    """Version and command."""
    record = document["record"]
    assert version == record["version"]
    assert command == (record["command"] or "called from Python")


def something_left(document: Document) -> None:
    """The verdict says so, and no joint is told of."""
    assert document["verdict"] == "partly_explained"
    assert document["left"] == []


def planned(document: Document, times: str) -> None:
    """The experiment that is proposed says the same."""
    assert any(f"{times} times the noise" in each["experiment"] for each in document["findings"])
