"""A number of a model file: a value, ``unknown``, or a value with an absolute tolerance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flexdyn.checks import as_number, number
from flexdyn.errors import InputError
from flexdyn.io.yaml import check_keys

UNKNOWN = "unknown"
"""The word of a model file for an unknown number."""
KEYS = ("value", "tolerance")
WRITE_UNKNOWN = "write unknown for a number that nobody knows"


@dataclass(frozen=True)
class GivenNumber:
    """A number and how well it is known.

    Attributes:
        value: in its unit; 0 if it is unknown.
        tolerance: absolute, one standard deviation, in the same unit; infinite: the number is unknown; None: the
            relative tolerance of the model applies.
    """

    value: float
    tolerance: float | None = None

    @property
    def is_unknown(self) -> bool:
        """Whether the number is unknown."""
        return self.tolerance == math.inf

    def entry(self) -> Any:
        """As a model file writes it."""
        if self.tolerance is None:
            return self.value
        return UNKNOWN if self.is_unknown else {"value": self.value, "tolerance": self.tolerance}


def given_number(entry: Any, key: str) -> GivenNumber:
    """Read an entry of a model file.

    Args:
        entry: a number, ``unknown`` or ``{value: 0.0, tolerance: 0.02}``.
        key: its path in the file, for messages.

    Raises:
        InputError: it is none of these.
    """
    if isinstance(entry, str) and entry == UNKNOWN:
        return GivenNumber(0.0, math.inf)
    if not isinstance(entry, Mapping):
        found = as_number(entry)
        if math.isnan(found):
            raise InputError("a number is needed", key=key, value=entry, remedy=WRITE_UNKNOWN if entry is None else "")
        return GivenNumber(found)
    check_keys(entry, KEYS, key=key)
    for name in KEYS:
        if name not in entry:
            raise InputError("it is missing", key=f"{key}.{name}", remedy="write {value: 0.0, tolerance: 0.02}")
    value = number(f"{key}.value", entry["value"], remedy=f"{WRITE_UNKNOWN}, in place of the mapping")
    remedy = f"it is absolute, one standard deviation; {WRITE_UNKNOWN}"
    problem = "a number above 0 is needed"
    return GivenNumber(value, number(f"{key}.tolerance", entry["tolerance"], problem, above=0.0, remedy=remedy))


def refusal(key: str, unit: str) -> InputError:
    """The error of a simulation whose model has an unknown number.

    Args:
        key: path of the number in the file.
        unit: of the number.
    """
    remedy = f"write it in {unit}, or estimate it from a recording with flexdyn diagnose"
    return InputError("the number is unknown, and nothing can be computed without it", key=key, remedy=remedy)
