"""Units of raw columns, and names of columns that state one: ``Ist [°]``, ``speed (rpm)``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from flexdyn.records.units import UNITLESS, usual

SI: Mapping[str, str] = {
    "angle": "rad",
    "angular velocity": "rad/s",
    "torque": "N m",
    "length": "m",
    "velocity": "m/s",
    "force": "N",
    "temperature": "degC",
    "current": "A",
    "voltage": "V",
    "duty": "1",
    "time": "s",
}
"""Quantities, and the unit that their values are converted to."""

SLIDING: Mapping[str, str] = {"angle": "length", "angular velocity": "velocity", "torque": "force"}
"""The quantity at a prismatic joint for each quantity at a revolute one."""
ELECTRICAL = ("current", "voltage")
"""Quantities that a drive converts to others, such as current to torque; the factor of a channel may give the ratio."""


@dataclass(frozen=True)
class Unit:
    """SI value = raw * numerator / denominator + zero; two numbers, because 1/1000 is exact only as a division."""

    quantity: str
    numerator: float = 1.0
    denominator: float = 1.0
    zero: float = 0.0


_ANGLES = {
    "rad": (1.0, 1.0),
    "mrad": (1.0, 1e3),
    "deg": (math.pi, 180.0),
    "arcmin": (math.pi, 180.0 * 60),
    "arcsec": (math.pi, 180.0 * 3600),
    "turn": (2 * math.pi, 1.0),
    "counts": (2 * math.pi, 1.0),
}
_LENGTHS = {"m": (1.0, 1.0), "cm": (1.0, 1e2), "mm": (1.0, 1e3), "um": (1.0, 1e6)}
_TORQUES = {"N m": (1.0, 1.0), "kN m": (1e3, 1.0), "N cm": (1.0, 1e2), "mN m": (1.0, 1e3), "N mm": (1.0, 1e3)}
_TIMES = {"s": (1.0, 1.0), "ms": (1.0, 1e3), "us": (1.0, 1e6), "ns": (1.0, 1e9), "min": (60.0, 1.0), "h": (3600.0, 1.0)}


def _known_units() -> dict[str, Unit]:
    """All units by name; those of rates follow from angles and lengths, over seconds and minutes."""
    units = {"rpm": Unit("angular velocity", 2 * math.pi, 60.0), "kN": Unit("force", 1e3), "N": Unit("force")}
    units |= {"A": Unit("current"), "mA": Unit("current", 1.0, 1e3)}
    units |= {"V": Unit("voltage"), "mV": Unit("voltage", 1.0, 1e3), "%": Unit("duty", 1.0, 100.0)}
    units |= {"degC": Unit("temperature"), "K": Unit("temperature", zero=-273.15)}
    units |= {"degF": Unit("temperature", 5.0, 9.0, -160.0 / 9.0)}
    for quantity, names in (("angle", _ANGLES), ("length", _LENGTHS), ("torque", _TORQUES), ("time", _TIMES)):
        units |= {name: Unit(quantity, *scale) for name, scale in names.items()}
    for quantity, names in (("angular velocity", _ANGLES), ("velocity", _LENGTHS)):
        for name, (numerator, denominator) in names.items():
            units[f"{name}/s"] = Unit(quantity, numerator, denominator)
            units[f"{name}/min"] = Unit(quantity, numerator, denominator * 60.0)
    return units


UNITS: Mapping[str, Unit] = _known_units()
"""Units that are converted; ``counts`` are divided by the counts per turn as well."""

_UNIT_SPELLINGS = {
    "deg": ("°", "degree", "degrees", "Grad", "grad"),
    "turn": ("turns", "rev", "revs", "revolution", "revolutions"),
    "counts": ("count", "cts", "ticks", "inc", "increments"),
    "um": ("µm", "micron", "microns"),
    "us": ("µs",),
    "degF": ("°F", "fahrenheit", "deg F"),
    "K": ("kelvin", "Kelvin"),
    "A": ("amp", "amps", "ampere", "amperes"),
    "V": ("volt", "volts", "Volt"),
    "%": ("percent", "per cent"),
    "min": ("minute", "minutes"),
    "rpm": ("RPM", "r/min", "1/min", "min-1", "U/min"),
    "turn/s": ("U/s", "rps"),
    "mN m": ("mNm",),
    "kN m": ("kNm",),
    "N cm": ("Ncm",),
    "N mm": ("Nmm",),
}
_PLAIN = {other: unit for unit, others in _UNIT_SPELLINGS.items() for other in others}


def plain_unit(text: str) -> str:
    """The spelling used here of a unit that has several: ``degrees/sec`` is ``deg/s``."""
    text = usual(text)
    if text in _PLAIN or text in UNITS:
        return _PLAIN.get(text, text)
    top, per, bottom = text.partition("/")
    top, bottom = usual(top), {"sec": "s", "second": "s", "minute": "min"}.get(bottom.strip(), bottom.strip())
    return f"{_PLAIN.get(top, top)}{per}{bottom}"


_WITH_UNIT = re.compile(r"(?P<bare>.*?\S)(?P<gap>\s*)(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))")


def split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a column's name; the unit is empty if the name has none.

    A text in brackets at the end is a unit if it is a known one. After a space, a text in square brackets is always a
    unit, unless it is a number, which is an index.
    """
    match = _WITH_UNIT.fullmatch(name)
    if match is None:
        return name, ""
    text = (match["square"] if match["square"] is not None else match["round"]).strip()
    known = plain_unit(text) in UNITS
    stated = match["square"] is not None and match["gap"] and text and not text.isdigit()
    unitless = text in UNITLESS and match["square"] is not None and match["gap"]
    return (match["bare"], text) if known or stated or unitless else (name, "")
