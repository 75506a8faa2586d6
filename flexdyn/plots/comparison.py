"""The picture of a comparison: errors by channel, grouped by unit, and the worst channel of each group over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexdyn.comparison.compare import ChannelError, Comparison
from flexdyn.comparison.difference import common_rows, difference
from flexdyn.plots.arrange import Block, arrange
from flexdyn.plots.palette import INK, hue, shade
from flexdyn.plots.panel import Bar, Key, Panel, check_times, limits, short
from flexdyn.plots.picture import Picture
from flexdyn.plots.thinning import curve_over_time
from flexdyn.records.units import is_held, split_name

MOST_BARS = 28
"""Largest number of channels of a unit that are drawn."""
SIDE_BY_SIDE = 3


def draw_comparison(found: Comparison) -> Picture:
    """Errors by channel as bars, one panel for each unit, and below the channel with the largest error in each unit.

    Args:
        found: by `flexdyn.compare`.
    """
    check_times(found.start, found.end)
    groups: dict[str, list[ChannelError]] = {}
    for row in found.rows:
        groups.setdefault(row.unit, []).append(row)
    notes = [
        f"{found.second} less {found.first}, at {found.samples} samples of {found.first} "
        f"from {found.start:.6g} to {found.end:.6g} s. Bar: RMS; mark: largest error."
    ]
    for unit, rows in groups.items():
        if len(rows) > MOST_BARS:
            notes.append(f"The {MOST_BARS} channels in {unit or 'no known unit'} of {len(rows)} with the greatest RMS.")
    units = list(groups)
    blocks = []
    for first in range(0, len(units), SIDE_BY_SIDE):
        chosen = units[first : first + SIDE_BY_SIDE]
        blocks.append(_bars_by_unit(found, {unit: groups[unit] for unit in chosen}))
    worst = [max(rows, key=lambda row: row.rms) for rows in groups.values()]
    apart = [row for row in worst if row.rms > 0]
    for first in range(0, len(apart), SIDE_BY_SIDE):
        blocks.append(_over_time(found, apart[first : first + SIDE_BY_SIDE]))
    keys = tuple(
        Key(short(source.name), shade(hue(0), found.sources, i), width=3.0) for i, source in enumerate(found.sources)
    )
    return arrange(f"{short(found.second)} against {short(found.first)}", notes, keys, blocks)


def _bars_by_unit(found: Comparison, groups: dict[str, list[ChannelError]]) -> Block:
    """A panel of bars for each unit: RMS and largest error of every channel."""
    panels = []
    for unit, rows in groups.items():
        kept = sorted(rows, key=lambda row: -row.rms)[:MOST_BARS]
        bars = tuple(
            Bar(short(row.channel), row.rms, row.largest, _hue(found, row.channel)) for row in rows if row in kept
        )
        _, reach = limits(np.array([0.0, *(bar.mark for bar in bars)]))
        label = f"error [{unit}]" if unit else "error, unit not known"
        panels.append(Panel(f"Errors [{unit}]" if unit else "Errors", label, "", bars=bars, x_range=(0.0, reach)))
    tallest = max(len(panel.bars) for panel in panels)  # bars of one width on the whole page
    panels = [replace(panel, y_range=(len(panel.bars) - tallest - 0.6, len(panel.bars) - 0.4)) for panel in panels]
    longest = max(len(bar.name) for panel in panels for bar in panel.bars)
    return Block((tuple(panels),), (0.2 + 0.19 * tallest,), 2.6, left=min(3.6, 0.3 + 0.075 * longest))


def _over_time(found: Comparison, worst: Sequence[ChannelError]) -> Block:
    """The channels with the largest errors over time: both motions above, their difference below."""
    one, two = found.sources
    rows = common_rows(one, two, found.start, found.end)
    span, above, beneath = (found.start, found.end), [], []
    for row in worst:
        both = difference(one, two, row.channel, rows)
        unit = f" [{row.unit}]" if row.unit else ""
        colour, held = _hue(found, row.channel), is_held(row.channel)
        curves = [
            curve_over_time(both.t, values, f"{row.channel}, {source.name}", source.name, shade_, held=held)
            for source, values, shade_ in (
                (one, both.first, shade(colour, found.sources, 0)),
                (two, both.second, shade(colour, found.sources, 1)),
            )
        ]
        title = f"{short(row.channel)}, largest error"
        above.append(Panel.over_time(title, f"value{unit}", curves, span, colour=colour, labelled=False))
        name = f"{row.channel}, {two.name} less {one.name}"
        error = curve_over_time(both.t, both.error, name, two.name, INK, held=held)
        title = f"RMS {row.rms:.4g}, largest {row.largest:.4g} {row.unit} at {row.at:.4g} s"
        reach = limits(both.error, np.zeros(1))
        beneath.append(Panel.over_time(title, f"error{unit}", [error], span, y_range=reach, level=True))
    return Block((tuple(above), tuple(beneath)), (1.9, 1.0), 3.4)


def _hue(found: Comparison, channel: str) -> str:
    """Colour of the channel's joint, by its index in the first motion; black for a channel without joint."""
    parts = split_name(channel)
    return hue(found.sources[0].joints.index(parts[1])) if parts else INK
