"""A panel of a picture in plain data: axes, curves, bars, the lines of a legend."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flexdyn.errors import InputError
from flexdyn.plots.palette import INK

Array = NDArray[np.float64]
LARGEST_DRAWN, SMALLEST_DRAWN = 1e150, 1e-150
"""Numbers beyond the one are not drawn, differences below the other not seen: renderers square them."""
LONGEST_NAME_SHOWN = 48
"""Letters of a name that are shown."""


@dataclass(frozen=True)
class Key:
    """A line in a legend.

    Attributes:
        label: what it says.
        colour: of its sample of a line.
        dash: of it, one of `flexdyn.plots.palette.DASHES`.
        width: of it [pt].
        dots: a row of dots instead.
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
        x: across.
        y: up.
        name: of what it is, such as ``q.elbow``.
        group: label of the line in the legend that shows and hides it.
        colour: of it.
        dash: one of `flexdyn.plots.palette.DASHES`.
        width: [pt].
        dots: dots at the samples, no line; the more there are, the smaller.
        held: every value stays until the next: a staircase.
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
    """A bar with a mark on its far side.

    Attributes:
        name: beside it.
        length: of the bar.
        mark: where the mark sits, on the same axis.
        colour: of the bar.
    """

    name: str
    length: float
    mark: float
    colour: str


@dataclass(frozen=True)
class Box:
    """Where the inside of a panel's axes lies on the page [inch], from the lower left corner."""

    left: float
    bottom: float
    width: float
    height: float


@dataclass(frozen=True, eq=False)
class Panel:
    """A pair of axes and what is in it.

    Attributes:
        title: above it.
        across: label of the axis across, with its unit.
        up: label of the axis up, with its unit.
        curves: in it, the lowest first.
        bars: in it, the uppermost first; a panel has curves or bars.
        x_range: of the axis across.
        y_range: of the axis up; the lowest bar lies at 0.
        colour: of the title.
        timed: the axis across is time, and all such axes move together.
        legend: it has one of its own, on the right of it.
        labelled: numbers and label of the axis across are shown, not those of a panel below it.
        box: where it lies.
        level: a horizontal line at zero.
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

    @property
    def keys(self) -> tuple[Key, ...]:
        """Lines of its legend, in the order of its curves."""
        return tuple(dict.fromkeys(curve.key for curve in self.curves))


def short(name: str) -> str:
    """A name of bounded length, which keeps its end, where numbers stand."""
    return name if len(name) <= LONGEST_NAME_SHOWN else f"{name[:30]}…{name[31 - LONGEST_NAME_SHOWN :]}"


def limits(*values: Array, margin: float = 0.06) -> tuple[float, float]:
    """A range of an axis that holds all values with some air; never one so narrow that rounding errors fill it.

    Args:
        values: at least one number in each; NaN, where a curve breaks off, is passed over.
        margin: air on both sides, as a share of the range.
    """
    low = min(float(np.nanmin(array)) for array in values)
    high = max(float(np.nanmax(array)) for array in values)
    size = max(abs(low), abs(high))
    if size > LARGEST_DRAWN:
        raise InputError(
            "the values are beyond what can be drawn", value=size, remedy=f"the limit is {LARGEST_DRAWN:g}"
        )
    if high - low <= max(1e-9 * size, SMALLEST_DRAWN):
        pad = max(0.1 * size, SMALLEST_DRAWN) if size else 1.0
        return low - pad, high + pad
    air = margin * (high - low)
    return low - air, high + air


def check_times(first: float, last: float) -> None:
    """Refuse a span of time that no axis can show.

    Raises:
        InputError: its ends are too great or too close for numbers between them.
    """
    size = max(abs(first), abs(last))
    if size > LARGEST_DRAWN or last - first <= max(1e-12 * size, SMALLEST_DRAWN):
        problem = f"times from {first!r} to {last!r} s cannot be drawn"
        raise InputError(problem, key="t", remedy="shift or scale the clock by a map")
