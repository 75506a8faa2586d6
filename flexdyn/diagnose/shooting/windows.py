"""Recordings cut into short windows, each simulated from its own first state (multiple shooting)."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags, evenly
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects.sensor import POSITIONS
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording

Index = NDArray[np.int64] | Flags
WINDOW_LENGTH = 0.5
"""Length of a window [s]: contract, section 8."""
MOST_WINDOWS = 400
"""Largest number of windows; of more, evenly spaced ones are used: 200 s are enough, and memory stays bounded."""
WINDOW_GAP_STEPS = 1.5
"""A time step longer than this multiple of the usual one is a gap [1]."""
LEAST_NOISE = 1e-12
"""Least standard deviation of a sensor [rad or m]: residuals are divided by it."""


@dataclass(frozen=True, eq=False)
class PerWindow:
    """Base of what has one entry per window in each of its arrays."""

    def part(self, which: Index) -> Self:
        """A selection of the windows."""
        return dataclasses.replace(self, **{name: array[which] for name, array in self._arrays().items()})

    def replaced(self, which: Index, other: Self) -> Self:
        """A copy in which some windows come from another object, which has only these."""
        arrays = {name: array.copy() for name, array in self._arrays().items()}
        for name, array in arrays.items():
            array[which] = getattr(other, name)
        return dataclasses.replace(self, **arrays)

    def _arrays(self) -> dict[str, NDArray[Any]]:
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of recordings, and the measurements in them.

    Attributes:
        recordings: from which they are cut.
        joints: of the model, in the order of q.
        channels: measured positions, ``q.<joint>`` and ``theta.<joint>``.
        noise: of the channels and torques.
        places: recording and first row of every window (windows, 2).
        rows: number of samples in a window.
        block: number of samples that are averaged before whitening, about 5 ms.
        since: time since the start of its run at which every recording begins [s].
    """

    recordings: tuple[Recording, ...]
    joints: tuple[str, ...]
    channels: tuple[str, ...]
    noise: SampleNoise
    places: NDArray[np.int64]
    rows: int
    block: int
    since: tuple[float, ...]

    @classmethod
    def of(
        cls,
        model: FlexibleJointModel,
        recordings: Sequence[Recording],
        noise: SampleNoise,
        most: int = MOST_WINDOWS,
        since: Sequence[float] = (),
    ) -> Windows:
        """Cut recordings into windows; a window never crosses a gap in time, and the last partial one is dropped.

        Args:
            model: that names the joints.
            recordings: of one rate; each with tau and a measured position.
            noise: of the channels.
            most: largest number of windows; of more, evenly spaced ones are used.
            since: time since the start of its run at which every recording begins [s]; none: each is a whole run.

        Raises:
            InputError: no position is measured, rates differ, or no recording is as long as a window.
        """
        joints = model.joint_names
        names = (f"{signal}.{joint}" for signal in POSITIONS for joint in joints)
        channels = tuple(name for name in names if any(name in recording for recording in recordings))
        if not channels:
            raise InputError("no position was measured", key="channels", remedy="q.JOINT or theta.JOINT is needed")
        periods = [float(np.median(np.diff(recording.t))) for recording in recordings]
        period = float(np.median(periods))
        for own in periods:
            if abs(own - period) > 0.02 * period:
                remedy = "resample it, or diagnose it by itself"
                raise InputError("recordings of different rates", key="rate", value=1.0 / own, remedy=remedy)
        block = max(1, round((0.005 if model.n <= 3 else 0.01) / period))
        rows = block * int(WINDOW_LENGTH / (period * block) + 1e-6)
        places = (
            [(k, row) for k, each in enumerate(recordings) for row in _starts(each.t, period, rows)] if rows else []
        )
        if not places:
            remedy = f"windows of {WINDOW_LENGTH:g} s without a gap are needed"
            raise InputError("the recordings are too short", key="t", remedy=remedy)
        begun = tuple(since) or (0.0,) * len(recordings)
        found = cls(tuple(recordings), joints, channels, noise, np.array(places, np.int64), rows, block, begun)
        return found.thinned(most)

    def thinned(self, most: int) -> Windows:
        """At most `most` windows, evenly spaced."""
        return dataclasses.replace(self, places=self.places[evenly(len(self), most)])

    def lasting(self, seconds: float) -> Windows:
        """Evenly spaced ones that last together so long [s], or all."""
        return self.thinned(max(1, round(seconds / (self.rows * self.period))))

    def divided(self, parts: int) -> Windows:
        """The same samples but for a rest, in windows shorter by a whole factor, each of at least one block."""
        parts = min(parts, self.blocks)
        rows = self.rows // self.block // parts * self.block
        places = [(k, row + part * rows) for k, row in self.places.tolist() for part in range(parts)]
        return dataclasses.replace(self, places=np.array(places, np.int64), rows=rows)

    def preceded(self) -> Windows:
        """Those that do not begin with their recording; all, where there are no others.

        A model with a delay needs torques from before a window. So all models are compared over the same windows.
        """
        later = self.places[:, 1] > 0
        return dataclasses.replace(self, places=self.places[later]) if later.any() else self

    def __len__(self) -> int:
        """Number of windows."""
        return len(self.places)

    @lazy
    def period(self) -> float:
        """Between two samples [s]."""
        return float(np.median(np.diff(self.t, axis=1)))

    @lazy
    def t(self) -> Array:
        """Times within the recording (windows, rows) [s]."""
        return np.stack([self.recordings[k].t[row : row + self.rows] for k, row in self.places])

    @lazy
    def measured(self) -> Array:
        """The readings of the sensors (windows, rows, channels); NaN if a recording lacks the channel."""
        nothing = np.full(self.rows, np.nan)
        stacks = [
            [each[name][row : row + self.rows] if name in each else nothing for name in self.channels]
            for each, row in ((self.recordings[k], row) for k, row in self.places)
        ]
        return np.ascontiguousarray(np.array(stacks).transpose(0, 2, 1))

    @lazy
    def span(self) -> Array:
        """Range of every channel over all windows (channels,)."""
        return np.asarray(np.nanmax(self.measured, axis=(0, 1)) - np.nanmin(self.measured, axis=(0, 1)))

    @property
    def sensor_noise(self) -> Array:
        """Standard deviation of every channel (channels,); of a channel without noise, a tiny number."""
        return np.maximum(self.noise.of_channels(self.channels, self.joints), LEAST_NOISE)

    @property
    def blocks(self) -> int:
        """Blocks in a window."""
        return self.rows // self.block


def _starts(t: Array, period: float, rows: int) -> list[int]:
    """First rows of the windows in one recording."""
    cuts = np.flatnonzero(np.diff(t) > WINDOW_GAP_STEPS * period) + 1
    stretches = itertools.pairwise([0, *cuts.tolist(), len(t)])
    return [row for begin, end in stretches for row in range(begin, end - rows + 1, rows)]
