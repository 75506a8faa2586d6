"""What report.json must hold for a claim at the top of report.html: verdict, findings, gap, the worst joint."""

from __future__ import annotations

import re

from tests.diagnose.report_told import LIKELY, Document, agrees, held, names_it


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


def _one(document: Document, phrase: str, probability: str) -> None:
    """Some finding has this phrase and this probability."""
    fits = [each for each in document["findings"] if held(each, phrase)]
    assert any(agrees(probability, each["probability"]) for each in fits), (phrase, probability)


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


def something_left(document: Document) -> None:
    """The verdict says so, and no joint is told of."""
    assert document["verdict"] == "partly_explained"
    assert document["left"] == []


def not_established(document: Document, phrase: str | None, probability: str | None) -> None:
    """No probability reaches 0.95, and the one that is told is the largest."""
    assert document["verdict"] == "unexplained"
    entries = [*document["findings"], *document["considered"]]
    weak = [each["probability"] for each in entries if each["probability"] is not None]
    assert all(each < 0.95 for each in weak) or phrase is None
    if phrase is not None and probability is not None:
        assert agrees(probability, max(weak))
        best = max(entries, key=lambda each: each["probability"] or 0.0)
        assert names_it(best, phrase)


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


def untested(document: Document, told: str | None) -> None:
    """Nothing was measured on test data; the findings that are told."""
    assert document["verdict"] == "untested"
    assert {each["role"] for each in document["data"]} == {"fit"}
    if told:
        by_then(document, told)
    else:
        nothing_by_then(document, None)


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
        assert all(names_it(each, first) for each in document["structures"][0]["effects"])


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
