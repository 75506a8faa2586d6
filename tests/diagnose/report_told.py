"""How report.html prints numbers, odds and names, and whether that agrees with report.json.

None of flexdyn's own formatting is used: a number is read as it is printed and may be off by its last digit, as
probabilities are rounded down.
"""

from __future__ import annotations

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
    return all(names_it(name, phrase) for name in (finding, *finding["indistinguishable_from"]))


def names_it(suspect: dict[str, Any], phrase: str) -> bool:
    """Whether a phrase names one effect where it is, or the number of the file that is wrong."""
    words = phrase.lower()
    if suspect["effect"] == "parameter_error":
        number = suspect["parameter"].removeprefix("link_").replace("_", " ").replace("com", "centre of mass")
        return number in words and "wrong" in words
    places = [suspect.get("channel") or suspect.get("joint") or suspect.get("frame") or ""]
    return suspect["effect"].replace("_", " ") in words and all(place.lower() in words for place in places)


def key_of(suspect: dict[str, Any]) -> tuple[Any, ...]:
    """What tells one suspect from another: the effect and its place."""
    return tuple(
        suspect.get(key) for key in ("effect", "joint", "side", "channel", "of", "parameter", "other", "frame")
    )
