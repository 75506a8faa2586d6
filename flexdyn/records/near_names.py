"""Names of channels that were probably meant as ``<signal>.<joint>``: ``q_elbow`` for ``q.elbow``."""

from __future__ import annotations

import re
from collections.abc import Iterable

from flexdyn.records.units import SIGNALS, split_name

_SIGNALS = "|".join(sorted(SIGNALS, key=len, reverse=True))
_NEARLY = re.compile(rf"({_SIGNALS})[_\-/: ](\S.*)", re.IGNORECASE)
MOST_NEAR_NAMES = 3


def nearly_signals(channels: Iterable[str]) -> dict[str, str]:
    """Probable correct names of channels, by their present names; empty if one channel has a correct name."""
    channels = list(channels)
    found: dict[str, str] = {}
    if any(map(split_name, channels)):
        return found
    for name in channels:
        match = None if name in SIGNALS else _NEARLY.fullmatch(name)
        if match is not None:
            found[name] = f"{match[1].lower()}.{match[2]}"
    return found


def asked_back(channels: Iterable[str], signal: str = "") -> str:
    """The question "did you mean ...?" for such channels, as a remedy; empty if there are none.

    Args:
        channels: of a recording.
        signal: that is missing; empty: any.
    """
    meant = nearly_signals(channels)
    near = [(name, other) for name, other in meant.items() if not signal or other.startswith(f"{signal}.")]
    if not near:
        return ""
    listed = ", ".join(f"{other} for {name}" for name, other in near[:MOST_NEAR_NAMES])
    return f"did you mean {listed}{', ...' if len(near) > MOST_NEAR_NAMES else ''}?"
