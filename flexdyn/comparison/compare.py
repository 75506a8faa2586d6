"""compare: the errors between two motions, channel by channel."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexdyn.comparison.difference import common_rows, difference, root_mean_square
from flexdyn.comparison.motion_sources import MotionSource, as_sources, unit_in
from flexdyn.errors import InputError, did_you_mean, listed, visible
from flexdyn.io.notebook import Public, card, html_table
from flexdyn.records.signals.gaps import in_gaps

if TYPE_CHECKING:
    from flexdyn.plots.picture import Picture


@dataclass(frozen=True)
class ChannelError:
    """The error of one channel: second motion - first motion.

    Attributes:
        channel: such as ``q.elbow``.
        unit: of all numbers except `relative`; empty if it is not known.
        rms: root of the mean of the squared error over the samples.
        largest: largest absolute error.
        at: time of that error [s].
        bias: mean of the error.
        relative: rms over the standard deviation of the first motion's samples; None if the first does not vary.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> error = fd.compare(run, run)["q.elbow"]
        >>> error.rms, error.unit
        (0.0, 'rad')
    """

    channel: str
    unit: str
    rms: float
    largest: float
    at: float
    bias: float
    relative: float | None


@dataclass(frozen=True, repr=False)
class Comparison(Public):
    """Errors of the second motion against the first, over the common time.

    Attributes:
        first: name of the first, the reference.
        second: name of the second.
        start: first common time [s].
        end: last common time [s].
        samples: number of samples of the first in that time, without gaps of the second; errors are computed there.
        rows: one for each common channel, in the order of the first.
        only_first: channels that the second does not have.
        only_second: channels that the first does not have.
        sources: the two motions themselves.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> errors = fd.compare(run, run)
        >>> errors["q.elbow"].largest
        0.0
    """

    first: str
    second: str
    start: float
    end: float
    samples: int
    rows: tuple[ChannelError, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]
    sources: tuple[MotionSource, MotionSource] = field(repr=False, compare=False)

    def __repr__(self) -> str:
        """The two motions and the time, in one line."""
        span = f"{self.samples} samples from {self.start:g} to {self.end:g} s"
        return visible(f"<Comparison of {self.second} with {self.first}: {len(self.rows)} channels, {span}>")

    def _repr_html_(self) -> str:
        """HTML for notebooks: the errors of every channel."""
        heads = ("channel", "unit", "RMS", "largest", "at [s]", "bias", "relative")
        rows = (
            (each.channel, each.unit or "-", each.rms, each.largest, each.at, each.bias, each.relative)
            for each in self.rows
        )
        return card(repr(self)[1:-1], {}, html_table(heads, rows))

    def __getitem__(self, channel: str) -> ChannelError:
        """Errors of one channel.

        Raises:
            InputError: it is no common channel.
        """
        for row in self.rows:
            if row.channel == channel:
                return row
        remedy = did_you_mean(channel, (row.channel for row in self.rows))
        raise InputError("no such common channel", key=channel, remedy=remedy)

    def __contains__(self, channel: object) -> bool:
        """Whether both have a channel of that name."""
        return any(row.channel == channel for row in self.rows)

    def to_dict(self) -> dict[str, Any]:
        """All results without the samples, in a form for JSON."""
        skipped = ("rows", "sources")
        plain = {key: getattr(self, key) for key in self.__dataclass_fields__ if key not in skipped}
        return plain | {"channels": [asdict(row) for row in self.rows]}

    def plot(self, path: str | Path | None = None) -> Picture:
        """Draw it: errors by channel, and the worst channel of each unit over time.

        Args:
            path: of a file to write, if given: .png, .pdf, .svg, .html.

        Returns:
            The picture, which can be shown and saved.

        Raises:
            InputError: the suffix is not known, or the file cannot be written.
            MissingExtra: matplotlib or plotly is not installed.
        """
        from flexdyn.plots.comparison import draw_comparison

        picture = draw_comparison(self)
        if path is not None:
            picture.save(path)
        return picture


def compare(first: Any, second: Any, *, start: float | None = None, end: float | None = None) -> Comparison:
    """Compute the errors of the second motion against the first, channel by channel.

    Errors are second - first, at the times of the first's samples within the common time. The second motion is
    interpolated linearly between its samples; ``tau`` and ``tau_applied`` are held from one sample to the next. All
    samples have the same weight. For a run the true signals are used, not those of its sensors.

    Args:
        first: the reference, such as a measurement: a run, a recording, or the path of one.
        second: the motion that is compared with it.
        start: first time to be compared [s]; default: the first common time.
        end: last time to be compared [s]; default: the last common time.

    Raises:
        InputError: the two have no channel or no time in common, or a channel in different units.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> rigid = fd.simulate(run.model.rigid(), duration=0.5, v0=[1.0, -2.0])
        >>> bool(fd.compare(run, rigid)["q.elbow"].rms > 0.0)
        True
    """
    one, two = as_sources([first, second])
    common = [name for name in one.recording.channels if name in two.recording]
    if not common:
        problem = f"{one.name} and {two.name} have no channel in common"
        has = [listed(each.recording.channels, 4) for each in (one, two)]
        remedy = f"the one has {has[0]}; the other {has[1]}; rename channels by a map"
        raise InputError(problem, key="channels", remedy=remedy)
    rows = common_rows(one, two, start, end)
    errors = tuple(_channel_error(one, two, name, rows) for name in common)
    t = one.recording.t[rows]
    return Comparison(
        first=one.name,
        second=two.name,
        start=float(t[0]),
        end=float(t[-1]),
        samples=int((~in_gaps(two.recording.t, t)).sum()),
        rows=errors,
        only_first=tuple(name for name in one.recording.channels if name not in two.recording),
        only_second=tuple(name for name in two.recording.channels if name not in one.recording),
        sources=(one, two),
    )


def _channel_error(one: MotionSource, two: MotionSource, channel: str, rows: slice) -> ChannelError:
    """The errors of one channel."""
    unit = unit_in((one, two), channel)
    both = difference(one, two, channel, rows)
    error, worst = both.error, int(np.argmax(np.abs(both.error)))
    spread = root_mean_square(both.first - both.first.mean())
    varies = spread > 1e-12 * float(np.abs(both.first).max())
    return ChannelError(
        channel=channel,
        unit=unit,
        rms=both.rms,
        largest=float(abs(error[worst])),
        at=float(both.t[worst]),
        bias=float(error.mean()),
        relative=both.rms / spread if varies else None,
    )
