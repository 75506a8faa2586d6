"""The results of a part of the study: checks, numbers, tables, figures and runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.io.text import fill
from flexdyn.io.yaml import read_yaml
from flexdyn.paper.cases import AMPLITUDE, CASES_DURATION, CASES_OBSERVED, PAPER_V, PULSE
from flexdyn.simulation.run import Run

Drawing = Callable[[Any], None]
SHARED: dict[str, Any] = {"paper_v": PAPER_V, "amplitude": AMPLITUDE, "pulse": PULSE, "watched": CASES_OBSERVED}
SHARED |= {"duration": CASES_DURATION, "degrees": np.degrees, "tuple": tuple}
"""What every template may name."""


@dataclass(frozen=True)
class Check:
    """One statement of the study and what was measured: it holds where value <= bound.

    Attributes:
        name: the statement.
        value: measured.
        bound: largest allowed value.
        passed: whether it holds; with a value that is no number it does not.
        note: unit, and how it was measured.
    """

    name: str
    value: float
    bound: float
    passed: bool
    note: str


def checked_statement(name: str, value: Any, bound: float, note: str) -> Check:
    """Measure a statement against its bound."""
    number = float(value)
    return Check(name, number, bound, number <= bound, note)


def stated(name: str, value: Any, **numbers: Any) -> Check:
    """Measure a statement of ``statements.yaml``.

    Args:
        name: its key there.
        value: measured.
        numbers: that its note names.
    """
    text = _statements()["checks"][name]
    return checked_statement(text["name"], value, float(text["bound"]), text["note"].format(**numbers))


@dataclass(frozen=True)
class Figure:
    """A figure to be drawn.

    Attributes:
        name: of its files, without suffix.
        caption: what it shows.
        draw: draws into an empty matplotlib figure of the size given.
        size: width and height [inch].
    """

    name: str
    caption: str
    draw: Drawing
    size: tuple[float, float]


def figure(name: str, draw: Drawing) -> Figure:
    """A figure with the caption and the size that ``statements.yaml`` has for it."""
    text = _statements()["figures"][name]
    return Figure(name, text["caption"], draw, tuple(text["size"]))


@cache
def _statements() -> Mapping[str, Any]:
    return read_yaml(Path(__file__).with_name("statements.yaml"))


@dataclass(frozen=True)
class Chapter:
    """A part of the study.

    Attributes:
        title: of its section in the summary.
        text: paragraphs and tables in Markdown.
        checks: its statements.
        numbers: everything measured, for the JSON summary.
        figures: to be drawn.
        runs: to be saved for playback, by name.
        files: that it wrote itself.
    """

    title: str
    text: str
    checks: tuple[Check, ...] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)
    figures: tuple[Figure, ...] = ()
    runs: Mapping[str, Run] = field(default_factory=dict)
    files: tuple[Path, ...] = ()


def prose(template: str, **filled: Any) -> str:
    """Paragraphs and tables: a filled template of this folder.

    Args:
        template: name of its file.
        filled: what its names stand for, beside those that every template may use.
    """
    return fill(f"paper/{template}", **(SHARED | filled))
