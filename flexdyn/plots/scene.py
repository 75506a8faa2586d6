"""The content of a picture: motions, their joints with their colours, a window of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexdyn.arrays import Indices
from flexdyn.checks import check_known
from flexdyn.comparison.difference import common_rows
from flexdyn.comparison.motion_sources import MotionSource, as_sources, samples_in_window, unit_in
from flexdyn.errors import InputError
from flexdyn.plots.palette import hue, shade
from flexdyn.plots.panel import Curve, Key, check_times, short
from flexdyn.plots.thinning import broken, outline, outline_in_plane
from flexdyn.records import Recording
from flexdyn.records.meta import as_plain
from flexdyn.records.table import Table
from flexdyn.records.units import HELD

MOST_DOTS = 150
"""A measured curve of up to this many samples is drawn as dots."""
DEFLECTION = "deflection"
"""Name of the signal theta - q."""


@dataclass(frozen=True)
class SignalTrace:
    """A signal over time or over another signal.

    Attributes:
        up: the signal.
        label: in the legend.
        dash: of its line.
        across: the signal that it is drawn over; empty: time.
    """

    up: str
    label: str
    dash: str = "solid"
    across: str = ""


@dataclass(frozen=True, eq=False)
class PlotScene:
    """Motions in a window of time.

    Attributes:
        sources: the motions; those with rotor and link positions have the deflection as an additional signal.
        joints: to be drawn.
        start: of the window [s].
        end: of the window [s].
    """

    sources: tuple[MotionSource, ...]
    joints: tuple[str, ...]
    start: float | None = None
    end: float | None = None

    @cached_property
    def every_joint(self) -> tuple[str, ...]:
        """Joints of all motions, in order of first appearance: the index of a joint gives its colour."""
        return tuple(dict.fromkeys(joint for source in self.sources for joint in source.joints))

    @cached_property
    def rows(self) -> tuple[Indices, ...]:
        """Samples of each motion in the window."""
        return tuple(samples_in_window(source, self.start, self.end) for source in self.sources)

    @cached_property
    def span(self) -> tuple[float, float]:
        """First and last time of any motion in the window [s]."""
        times = [source.recording.t[rows] for source, rows in zip(self.sources, self.rows, strict=True)]
        first, last = min(float(t[0]) for t in times), max(float(t[-1]) for t in times)
        check_times(first, last)
        return first, last

    @cached_property
    def common(self) -> tuple[slice | None, ...]:
        """Samples of the first motion within the time of each other motion; None if there are none."""
        return tuple(self._common(source) for source in self.sources)

    def _common(self, source: MotionSource) -> slice | None:
        try:
            return common_rows(self.sources[0], source, self.start, self.end)
        except InputError:
            return None

    @property
    def source_keys(self) -> tuple[Key, ...]:
        """One line of a legend for each motion, if there are several."""
        if len(self.sources) == 1:
            return ()
        colour = self.hue(self.joints[0])
        return tuple(
            Key(short(source.name), shade(colour, self.sources, i), width=3.0, dots=self.dotted(i))
            for i, source in enumerate(self.sources)
        )

    def hue(self, joint: str) -> str:
        """Colour of a joint."""
        return hue(self.every_joint.index(joint))

    def dotted(self, place: int) -> bool:
        """Whether a motion is drawn as dots: it was measured, another one was not, and it has few samples."""
        grey = self.sources[place].measured and not all(source.measured for source in self.sources)
        return grey and len(self.rows[place]) <= MOST_DOTS

    def has(self, place: int, signal: str, joint: str) -> bool:
        """Whether a motion has a signal of a joint that differs from other signals in some motion.

        The rotor of a rigid joint and the torque of an actuator without effects do not.
        """
        name, twin = f"{signal}.{joint}", f"{_TWINS.get(signal)}.{joint}"
        if name not in self.sources[place].recording:
            return False
        tables = [source.recording.channels for source in self.sources if name in source.recording]
        return any(twin not in table or not np.array_equal(table[name], table[twin]) for table in tables)

    def unit(self, signal: str, joint: str) -> str:
        """Unit of a signal of a joint."""
        name = f"{'q' if signal == DEFLECTION else signal}.{joint}"
        return unit_in([source for source in self.sources if name in source.recording], name)

    def curve(self, place: int, trace: SignalTrace, joint: str) -> Curve:
        """One signal of one joint of one motion, with fewer points."""
        source, rows = self.sources[place], self.rows[place]
        t, up = source.recording.t[rows], source.recording[f"{trace.up}.{joint}"][rows]
        x = source.recording[f"{trace.across}.{joint}"][rows] if trace.across else t
        kept, full = outline_in_plane(x, up) if trace.across else (outline(t, up), False)
        several = len(self.sources) > 1
        colour = shade(self.hue(joint), self.sources, place)
        grey = source.measured and not all(one.measured for one in self.sources)
        drawn = (x[kept], up[kept]) if trace.across else broken(t, up, kept)
        return Curve(
            *drawn,
            f"{trace.up}.{joint}"
            + (f" over {trace.across}" if trace.across else "")
            + (f", {source.name}" if several else ""),
            short(source.name) if several else trace.label,
            colour,
            dash=trace.dash,
            width=1.9 if grey else 1.3,
            dots=full or self.dotted(place),
            held=trace.up in HELD and not trace.across,
        )


_TWINS = {"theta": "q", "omega": "v", "tau_applied": "tau"}


def make_scene(given: Sequence[Any], joints: Sequence[str] | None, start: float | None, end: float | None) -> PlotScene:
    """Make the content of a picture.

    Args:
        given: runs, recordings, paths.
        joints: to be drawn; None: all.
        start: of the window [s]; None: the beginning.
        end: of the window [s]; None: the end.

    Raises:
        InputError: no motions, a joint that no motion has, an empty window.
    """
    if not given:
        raise InputError("there is nothing to draw", key="runs", remedy="give a run or a recording")
    sources = tuple(_with_deflection(source) for source in as_sources(given))
    known = tuple(dict.fromkeys(joint for source in sources for joint in source.joints))
    if not known:
        remedy = "channels are named <signal>.<joint>, such as q.elbow"
        raise InputError(f"{sources[0].name} has no signal of any joint", key="channels", remedy=remedy)
    for joint in joints or ():
        check_known(joint, known, "no such joint", key="joints", value=joint)
    chosen = tuple(dict.fromkeys(joints)) if joints else known
    scene = PlotScene(sources, chosen, start, end)
    _ = scene.rows  # refuses an empty window
    return scene


def _with_deflection(source: MotionSource) -> MotionSource:
    """The motion with the additional signal theta - q of every joint that has both."""
    recording = source.recording
    columns = {"t": recording.t, **recording.channels}
    for joint in recording.joints:
        if recording.has("q", joint) and recording.has("theta", joint):
            columns[f"{DEFLECTION}.{joint}"] = recording[f"theta.{joint}"] - recording[f"q.{joint}"]
    deflected = Recording.from_table(Table(columns, as_plain(recording.meta)), recording.name)
    return MotionSource(source.name, deflected, source.run)
