"""Panels of metrics: each metric over each parameter, and the influence of each parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexdyn.arrays import Array
from flexdyn.batch.summary import Sensitivity, sensitivity
from flexdyn.plots.arrange import Block
from flexdyn.plots.palette import INK
from flexdyn.plots.panel import Curve, Panel, limits, short

DOTS = 3000
"""Largest number of runs that are drawn."""
UPRIGHT, BESIDE = 24, 24
"""Largest number of letters of a name along a vertical axis, and beside a panel."""
MOST_LINES = 20
"""Largest number of parameters in a tornado diagram."""


@dataclass(frozen=True, eq=False)
class MetricColumns:
    """Metrics and parameters of all runs.

    Attributes:
        metrics: by name, by run (runs,).
        parameters: by path, by run (runs,).
        units: of all of them.
        colours: of all parameters.
    """

    metrics: Mapping[str, Array]
    parameters: Mapping[str, Array]
    units: Mapping[str, str]
    colours: Mapping[str, str]

    @cached_property
    def sensitivities(self) -> Mapping[tuple[str, str], Sensitivity]:
        """Sensitivities by parameter and metric, if they can be computed."""
        found = {
            (path, name): sensitivity(values, metric)
            for path, values in self.parameters.items()
            for name, metric in self.metrics.items()
        }
        return {pair: each for pair, each in found.items() if each is not None}

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(next(iter(self.metrics.values())))

    @property
    def chance(self) -> float:
        """The rank correlation that chance alone does not exceed in 95 of 100 studies."""
        return max((each.chance for each in self.sensitivities.values()), default=1.0)

    def strongest(self, most: int) -> list[str]:
        """The parameters with the largest influence on any metric, in the study's order."""
        effect = dict.fromkeys(self.parameters, 0.0)
        for (path, _), each in self.sensitivities.items():
            effect[path] = max(effect[path], abs(each.rank_correlation))
        kept = sorted(effect, key=lambda path: -effect[path])[:most]
        return [path for path in self.parameters if path in kept]

    def only(self, paths: Sequence[str]) -> MetricColumns:
        """The same with only these parameters."""
        return replace(self, parameters={path: self.parameters[path] for path in paths})

    def label(self, name: str, letters: int = 48) -> str:
        """Name, shortened to a number of letters, and unit."""
        unit = self.units.get(name, "")
        return f"{end_of_name(name, letters)} [{unit}]" if unit not in ("", "1") else end_of_name(name, letters)


def end_of_name(name: str, letters: int) -> str:
    """A name of bounded length; its end is kept, because parameters differ there."""
    return name if len(name) <= letters else f"…{name[1 - letters :]}"


def scatter(columns: MetricColumns) -> list[Block]:
    """A row of panels for each metric, a column for each parameter."""
    rows = []
    for name in columns.metrics:
        last = name == list(columns.metrics)[-1]
        panels = [_dots(columns, path, name) for path in columns.parameters]
        rows.append(tuple(replace(panel, labelled=last) for panel in panels))
    return [Block(tuple(rows), (1.8,) * len(rows), 3.0)]


def tornado(columns: MetricColumns) -> list[Block]:
    """A panel for each metric, a line for each parameter, the strongest uppermost."""
    panels = [panel for name in columns.metrics if (panel := _lines(columns, name)) is not None]
    return [Block(((panel,),), (max(0.5, 0.22 * len(panel.curves)),)) for panel in panels]


def _dots(columns: MetricColumns, path: str, name: str) -> Panel:
    """A metric over a parameter, a dot for each run."""
    x, y = columns.parameters[path], columns.metrics[name]
    there = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if len(there) > DOTS:
        there = there[np.linspace(0, len(there) - 1, DOTS).astype(np.intp)]
    found = columns.sensitivities.get((path, name))
    colour = columns.colours[path]
    curve = Curve(x[there], y[there], f"{name} over {path}", short(path), colour, dots=True)
    finite = [values[np.isfinite(values)] for values in (x, y)]
    ranges = [limits(values) if len(values) else (0.0, 1.0) for values in finite]
    return Panel(
        "" if found is None else f"r = {found.rank_correlation:+.2f}",
        columns.label(path),
        columns.label(name, UPRIGHT),
        (curve,),
        x_range=ranges[0],
        y_range=ranges[1],
        colour=colour if found is not None and abs(found.rank_correlation) > found.chance else INK,
    )


def _lines(columns: MetricColumns, name: str) -> Panel | None:
    """What a metric changes by from the lowest to the highest fifth of each parameter; None if nothing is known."""
    found = [
        (each, path, columns.colours[path])
        for path in columns.parameters
        if (each := columns.sensitivities.get((path, name))) is not None
    ]
    if not found:
        return None
    found.sort(key=lambda entry: -abs(entry[0].high - entry[0].low))
    curves = []
    for rank, (each, path, colour) in enumerate(found[:MOST_LINES], start=1):
        label = (
            f"{end_of_name(path.removeprefix('joints.').removeprefix('command.'), BESIDE)} {each.rank_correlation:+.2f}"
        )
        ends, level = np.array([each.low, each.high]), np.array([rank, rank], dtype=float)
        curves.append(Curve(ends, level, f"{path}: lowest to highest fifth", label, colour, width=7.0))
    reach = max(float(np.abs(curve.x).max()) for curve in curves)
    across = f"change of {columns.label(name)}"
    sides = limits(np.array([-reach, reach]))
    return Panel(short(name), across, "rank", tuple(curves), (), sides, (len(curves) + 0.6, 0.4), legend=True)
