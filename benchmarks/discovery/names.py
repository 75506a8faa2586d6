"""Compares what a report names with what was hidden: the place of an effect, its parameters, their intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

Entry = Mapping[str, Any]
SENSORS = ("channel_lag", "encoder_eccentricity", "sensor_offset", "sensor_gain")
UNPLACED = ("payload",)


def text(entry: Entry, key: str) -> str | None:
    """A word of a finding: at its top, or among its parameters."""
    value = entry.get(key)
    if value is None:
        value = (entry.get("parameters") or {}).get(key)
    if isinstance(value, Mapping):
        value = value.get("value")
    return None if value is None else str(value)


def place(entry: Entry) -> tuple[str | None, ...]:
    """What must agree: effect, joint and side; of a sensor its channel; of a wrong number whose and which."""
    effect = str(entry["effect"])
    if effect in UNPLACED:
        return (effect,)
    if effect in SENSORS:
        return (effect, text(entry, "channel"))
    if effect == "parameter_error":
        return (effect, text(entry, "of"), text(entry, "parameter"))
    return (effect, text(entry, "joint"), text(entry, "side"))


def same(finding: Entry, hidden: Entry) -> bool:
    """Whether a finding names what was hidden, at its place."""
    if finding["effect"] in SENSORS and text(finding, "channel") is None:
        return (finding["effect"], text(finding, "joint")) == (hidden["effect"], hidden["joint"])
    return place(finding) == place(hidden)


def label(entry: Entry) -> str:
    """For tables."""
    return " ".join(str(word) for word in place(entry) if word)


def kind(entry: Entry) -> str:
    """A row of the confusion table: the effect and its side."""
    effect = str(entry["effect"])
    if effect == "parameter_error":
        return f"{effect} {text(entry, 'parameter')}"
    if effect in SENSORS:
        return f"{effect} {(text(entry, 'channel') or '').partition('.')[0]}"
    return " ".join(str(word) for word in (effect, text(entry, "side")) if word and effect not in UNPLACED) or effect


def parameter_errors(finding: Entry, hidden: Entry) -> list[dict[str, Any]]:
    """Every parameter that was estimated: relative error, and whether 1.96 standard deviations hold the truth."""
    true = _canonical({key: float(value) for key, value in hidden["parameters"].items()})
    found, spread = _estimates(finding)
    found = _canonical(found)
    rows = []
    for key, value in found.items():
        if key not in true:
            continue
        error = value - true[key]
        if key == "phase":
            error = math.remainder(error, 2.0 * math.pi)
        std = spread.get(key)
        known = std is not None and math.isfinite(std) and std > 0.0
        rows.append(
            {
                "parameter": key,
                "true": true[key],
                "value": value,
                "relative_error": abs(error) / (1.0 if key == "phase" else max(abs(true[key]), 1e-12)),
                "covered": bool(abs(error) <= 1.96 * std) if known and std is not None else None,
            }
        )
    return rows


def _estimates(finding: Entry) -> tuple[dict[str, float], dict[str, float]]:
    values, spread = {}, {}
    for key, entry in (finding.get("parameters") or {}).items():
        if isinstance(entry, Mapping) and isinstance(entry.get("value"), int | float):
            values[key] = float(entry["value"])
            if isinstance(entry.get("std"), int | float):
                spread[key] = float(entry["std"])
        elif isinstance(entry, int | float) and not isinstance(entry, bool):
            values[key] = float(entry)
    return values, spread


def _canonical(parameters: dict[str, float]) -> dict[str, float]:
    """An amplitude and a harmonic of positive sign: -a sin(x) = a sin(x + pi)."""
    found = dict(parameters)
    if "phase" in found and found.get("harmonic", 1.0) < 0.0:
        found["harmonic"], found["phase"] = -found["harmonic"], math.pi - found["phase"]
    if "phase" in found and found.get("amplitude", 1.0) < 0.0:
        found["amplitude"], found["phase"] = -found["amplitude"], found["phase"] + math.pi
    return found
