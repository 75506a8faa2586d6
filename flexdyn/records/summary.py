"""A recording in one line of text, and as a table for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexdyn.errors import listed
from flexdyn.io.notebook import card, html_table

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording


def extent_line(rec: Recording) -> str:
    """Joints, signals, duration and rate."""
    label = f"{rec.name!r}, " if rec.name else ""
    joints, signals = (listed(names, 12) or "none" for names in (rec.joints, rec.signals))
    extent = f"{len(rec)} samples, {rec.duration:.6g} s at {rec.rate:.6g} Hz"
    return f"Recording({label}joints: {joints}; signals: {signals}; {extent})"


def as_card(rec: Recording) -> str:
    """HTML: extent, gaps, and the range of each channel."""
    facts = {
        "samples": f"{len(rec)}, {rec.duration:.6g} s at {rec.rate:.6g} Hz",
        "gaps [s]": ", ".join(f"{start:.6g} to {end:.6g}" for start, end in rec.gaps[:3]),
    }
    rows = (
        (name, rec.unit(name) or "-", float(values.min()), float(values.max()), float(values.std()))
        for name, values in rec.channels.items()
    )
    notes = rec.meta.get("notes", ())
    heads = ("channel", "unit", "least", "greatest", "standard deviation")
    label = f" {rec.name}" if rec.name else ""
    return card(f"Recording{label}", facts, html_table(heads, rows), notes=notes if isinstance(notes, tuple) else ())
