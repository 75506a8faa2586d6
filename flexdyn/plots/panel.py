"""A panel of a picture as plain data: axes, curves, bars, the lines of a legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.plots.palette import INK

TIME = "t [s]"
LARGEST_DRAWN, SMALLEST_DRAWN = 1e150, 1e-150
"""Largest number that is drawn, and smallest difference: the renderers compute squares of them."""
MARGIN = 0.06
"""Free space at each end of an axis, as a share of the range of its values [1]."""
LONGEST_NAME_SHOWN = 48
"""Largest number of letters of a name that are shown."""


@dataclass(frozen=True)
class Key:
    """A line in a legend.

    Attributes:
        label: its text.
        colour: of its line.
        dash: of its line, solid, dashed, dashdot or dotted.
        width: of its line [pt].
        dots: whether it shows a row of dots instead.
    """

    label: str
    colour: str = INK
    dash: str = "solid"
    width: float = 1.5
    dots: bool = False


@dataclass(frozen=True, eq=False)
class Curve:
    """A line, or a row of dots.

    Attributes:
        x: horizontal values.
        y: vertical values.
        name: of the signal, such as ``q.elbow``.
        group: label of the line in the legend that shows and hides it.
        colour: of the line.
        dash: solid, dashed, dashdot or dotted.
        width: [pt].
        dots: whether dots are drawn at the samples instead of a line; many dots are smaller.
        held: whether every value is held until the next (steps).
    """

    x: Array
    y: Array
    name: str
    group: str
    colour: str
    dash: str = "solid"
    width: float = 1.3
    dots: bool = False
    held: bool = False

    @property
    def dot(self) -> float:
        """Width of its dots [pt]."""
        return 3.2 if len(self.x) < 500 else 1.6

    @property
    def key(self) -> Key:
        """Its line in the legend of a panel."""
        return Key(self.group, self.colour, self.dash, self.width, self.dots)


@dataclass(frozen=True)
class Bar:
    """A bar with a mark.

    Attributes:
        name: beside it.
        length: of the bar.
        mark: position of the mark on the same axis.
        colour: of the bar.
    """

    name: str
    length: float
    mark: float
    colour: str


@dataclass(frozen=True)
class Box:
    """The place of a panel's axes on the page [inch], from the lower left corner."""

    left: float
    bottom: float
    width: float
    height: float


@dataclass(frozen=True, eq=False)
class Panel:
    """A pair of axes with its content.

    Attributes:
        title: above it.
        across: label of the horizontal axis, with its unit.
        up: label of the vertical axis, with its unit.
        curves: its curves, the lowest first.
        bars: its bars, the uppermost first; a panel has curves or bars.
        x_range: of the horizontal axis.
        y_range: of the vertical axis; the lowest bar is at 0.
        colour: of the title.
        timed: whether the horizontal axis is time; all such axes move together.
        legend: whether it has its own legend, on its right.
        labelled: whether it shows numbers and label of the horizontal axis.
        box: its place.
        level: whether there is a horizontal line at zero.
    """

    title: str
    across: str
    up: str
    curves: tuple[Curve, ...] = ()
    bars: tuple[Bar, ...] = ()
    x_range: tuple[float, float] = (0.0, 1.0)
    y_range: tuple[float, float] = (0.0, 1.0)
    colour: str = INK
    timed: bool = False
    legend: bool = False
    labelled: bool = True
    box: Box = field(default=Box(0.0, 0.0, 1.0, 1.0))
    level: bool = False

    @classmethod
    def over_time(cls, title: str, up: str, curves: Sequence[Curve], span: tuple[float, float], **look: Any) -> Self:
        """A panel whose horizontal axis is time; by default its vertical axis has the range of the curves.

        Args:
            title: above it.
            up: label of the vertical axis, with its unit.
            curves: its curves, the lowest first.
            span: first and last time [s].
            look: further attributes of the panel.
        """
        timed: dict[str, Any] = {"x_range": span, "y_range": limits(*(curve.y for curve in curves)), "timed": True}
        return cls(title, TIME, up, tuple(curves), **timed | look)

    @property
    def keys(self) -> tuple[Key, ...]:
        """Lines of its legend, in the order of its curves."""
        return tuple(dict.fromkeys(curve.key for curve in self.curves))


def short(name: str) -> str:
    """A name of bounded length; its end is kept, because numbers are there."""
    return name if len(name) <= LONGEST_NAME_SHOWN else f"{name[:30]}…{name[31 - LONGEST_NAME_SHOWN :]}"


def limits(*values: Array) -> tuple[float, float]:
    """A range of an axis that contains all values with a margin; it is never so narrow that rounding errors fill it.

    Args:
        values: at least one number in each; NaN, where a curve is interrupted, is ignored.
    """
    low = min(float(np.nanmin(array)) for array in values)
    high = max(float(np.nanmax(array)) for array in values)
    size = max(abs(low), abs(high))
    if size > LARGEST_DRAWN:
        remedy = f"the limit is {LARGEST_DRAWN:g}"
        raise InputError("the values are beyond what can be drawn", value=size, remedy=remedy)
    if high - low <= max(1e-9 * size, SMALLEST_DRAWN):
        pad = max(0.1 * size, SMALLEST_DRAWN) if size else 1.0
        return low - pad, high + pad
    air = MARGIN * (high - low)
    return low - air, high + air


def check_times(first: float, last: float) -> None:
    """Refuse a span of time that an axis cannot show.

    Raises:
        InputError: its ends are too large, or too close for numbers between them.
    """
    size = max(abs(first), abs(last))
    if size > LARGEST_DRAWN or last - first <= max(1e-12 * size, SMALLEST_DRAWN):
        problem = f"times from {first!r} to {last!r} s cannot be drawn"
        raise InputError(problem, key="t", remedy="shift or scale the clock by a map")
