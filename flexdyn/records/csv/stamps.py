"""Dates and times of day in a column of text, as seconds from the first."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from datetime import UTC, datetime

_STAMP = re.compile(
    r"(?:(?P<iso>\d{4}-\d\d-\d\d)|(?P<day>\d\d)\.(?P<month>\d\d)\.(?P<year>\d{4}))"
    r"[T ](?P<clock>\d\d:\d\d:\d\d)(?:[.,](?P<part>\d{1,9}))?\s?(?P<zone>Z|[+-]\d\d:?\d\d)?"
)
"""ISO 8601 (2024-05-03T12:00:00.123+02:00, a space for the T as pandas writes it) and 03.05.2024 12:00:00,123."""


def is_stamp(cell: str) -> bool:
    """Whether the cell holds a date with a time of day."""
    return _STAMP.fullmatch(cell.strip().strip('"')) is not None


@dataclass
class Stamps:
    """Reads one column of stamps, row by row; stamps without a time zone are taken as UTC.

    Attributes:
        column: of the file, from 0.
        start_ns: of the first stamp that was read, in ns since 1970; None before.
    """

    column: int
    start_ns: int | None = None
    _known: dict[tuple[str, str], int] = field(default_factory=dict, repr=False)

    def seconds(self, cell: str) -> float:
        """Seconds from the first stamp read to this one, exact to the nanosecond.

        Raises:
            ValueError: it is no stamp.
        """
        text = cell.strip()
        match = _STAMP.fullmatch(text)
        if match is None:
            return float(text) if text.lower() == "nan" else _refuse(text)
        day = match["iso"] or f"{match['year']}-{match['month']}-{match['day']}"
        stamp = self._second(f"{day}T{match['clock']}", match["zone"] or "") * 10**9
        stamp += int((match["part"] or "0").ljust(9, "0"))
        if self.start_ns is None:
            self.start_ns = stamp
        return (stamp - self.start_ns) / 1e9

    def _second(self, whole: str, zone: str) -> int:
        """Whole seconds since 1970; the last result is kept, because samples of one second follow each other."""
        key = (whole, zone)
        if key not in self._known:
            made = datetime.fromisoformat(whole + zone)
            self._known = {key: int((made if made.tzinfo else made.replace(tzinfo=UTC)).timestamp())}
        return self._known[key]


def _refuse(text: str) -> float:
    raise ValueError(text)
