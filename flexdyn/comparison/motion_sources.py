"""Motions that can be drawn and compared: runs, recordings and files, converted to one form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexdyn.arrays import Indices
from flexdyn.errors import InputError, printable
from flexdyn.records import Recording
from flexdyn.records.given import as_recording
from flexdyn.records.units import signal_unit
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.run import Run


@dataclass(frozen=True, eq=False)
class MotionSource:
    """A motion to be drawn or compared.

    Attributes:
        name: its name in pictures and tables.
        recording: its samples; for a run the true ones, not those of its sensors.
        run: the run, if it was given as one.
    """

    name: str
    recording: Recording
    run: Run | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that have a signal."""
        return self.recording.joints

    @property
    def measured(self) -> bool:
        """Whether it was measured: it is no run, and no file of a saved run.

        A file of a saved run has a solver's settings in its meta data; in a format without meta data it has all seven
        signals of a run for every joint.
        """
        if self.run is not None or "solver" in self.recording.meta:
            return False
        return not all(self.recording.has(signal, joint) for joint in self.joints for signal in SIGNALS)

    def stated_unit(self, channel: str) -> str:
        """Unit of a channel from the run's robot or the file's meta data; empty if neither gives it."""
        units = self.recording.meta.get("units", {})
        return self.recording.unit(channel) if self.run is not None or channel in units else ""


def as_source(given: Any) -> MotionSource:
    """Convert anything that can be drawn to a motion.

    Args:
        given: a run, a recording, the path of a recording, or a table of pandas or xarray.

    Raises:
        InputError: it is something else, or the file has a fault.
    """
    if isinstance(given, MotionSource):
        return given
    if isinstance(given, Run):
        return MotionSource(printable(given.model.name).strip() or "run", _true(given), given)
    given = as_recording(given)
    return MotionSource(printable(given.name).strip() or "recording", given)


def as_sources(given: Sequence[Any]) -> tuple[MotionSource, ...]:
    """Convert several motions; those with equal names are numbered.

    Raises:
        InputError: one of them is neither a run nor a recording.
    """
    sources = [as_source(entry) for entry in given]
    names = [source.name for source in sources]
    counts: dict[str, int] = {}
    for i, name in enumerate(names):
        counts[name] = counts.get(name, 0) + 1
        if names.count(name) > 1:
            sources[i] = replace(sources[i], name=f"{name} ({counts[name]})")
    return tuple(sources)


def unit_in(sources: Sequence[MotionSource], channel: str) -> str:
    """Unit of a channel in all motions: the one that a motion states, else the one of its signal.

    Raises:
        InputError: two of them state different units.
    """
    having = [source for source in sources if channel in source.recording]
    stated = {unit: source for source in having if (unit := source.stated_unit(channel))}
    if len(stated) > 1:
        (mine, first), (its, second) = list(stated.items())[:2]
        problem = f"the channel is in {mine} in {first.name} and in {its} in {second.name}"
        raise InputError(problem, key=channel, remedy="a revolute and a prismatic joint share a name: rename one")
    return next(iter(stated), "") or having[0].recording.unit(channel)


def samples_in_window(source: MotionSource, start: float | None, end: float | None) -> Indices:
    """Indices of the samples in a window of time.

    Args:
        source: the motion.
        start: first time [s]; None: the first sample's.
        end: last time [s]; None: the last sample's.

    Raises:
        InputError: fewer than two.
    """
    t = source.recording.t
    low = t[0] if start is None else start
    high = t[-1] if end is None else end
    first, last = np.searchsorted(t, low, "left"), np.searchsorted(t, high, "right")
    if last - first < 2:
        problem = f"{source.name} has {max(0, last - first)} samples from {low:g} to {high:g} s"
        remedy = f"its samples go from {t[0]:g} to {t[-1]:g} s; choose a window with two or more"
        raise InputError(problem, key="start, end", remedy=remedy)
    return np.arange(first, last, dtype=np.intp)


def _true(run: Run) -> Recording:
    """The run's own arrays as a recording."""
    channels, units = {}, {}
    for signal in SIGNALS:
        for j, name in enumerate(run.joint_names):
            channels[f"{signal}.{name}"] = getattr(run, signal)[:, j]
            units[f"{signal}.{name}"] = signal_unit(signal, prismatic=run.model.robot.kinds[j] == "prismatic")
    return Recording(run.t, channels, meta={"units": units}, name=run.model.name)
