"""The recording: time and named channels, checked once, immutable from then on."""

from __future__ import annotations

from collections.abc import ItemsView, Iterable, Iterator, KeysView, Mapping, Sequence, ValuesView
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy.typing as npt

from flexdyn.checks import Array
from flexdyn.errors import InputError, did_you_mean
from flexdyn.io.notebook import Public
from flexdyn.records.meta import as_plain, check_prescribed, check_units, locked, settle_units
from flexdyn.records.samples import same_samples, side_by_side
from flexdyn.records.signals import cut, derivatives
from flexdyn.records.signals.beside import beside
from flexdyn.records.signals.decimate import decimated
from flexdyn.records.signals.gaps import gaps_of
from flexdyn.records.signals.resample import resampled
from flexdyn.records.summary import as_card, extent_line
from flexdyn.records.table import Rows, Table, checked
from flexdyn.records.units import split_name, unit_of


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Recording(Public):
    """Samples of an arm over time, measured or simulated; SI units, motor side reflected to the link side.

    Channels are named ``<signal>.<joint>`` with the signals q, v, theta, omega, tau, tau_applied, tau_s, temperature;
    channels with other names are kept. Two recordings are equal if samples (bit for bit), order of channels and meta
    are equal; the name is only a label. Rows in errors count from 0, as in arrays.

    Args:
        t: time [s], (samples,), strictly increasing, two samples or more.
        channels: arrays (samples,) by channel name; copied. Signals have the units of `SIGNALS`.
        meta: anything JSON can hold, copied and locked; ``meta["units"]`` names units by channel where they are not
            those of a revolute joint, such as ``{"q.slide": "m"}``; ``meta["prescribed"]`` names the joints whose
            motion a test rig prescribes.
        name: a label for plots and messages.

    Raises:
        InputError: NaN, columns of different lengths, time that does not increase, bad names, units that are not SI.

    Example:
        >>> rec = fd.Recording([0.0, 0.1, 0.2], {"q.elbow": [0.0, 0.1, 0.3]})
        >>> rec["q.elbow"], rec.joints
        (array([0. , 0.1, 0.3]), ('elbow',))
    """

    t: Array
    channels: Mapping[str, Array]
    meta: Mapping[str, Any]
    name: str

    def __init__(
        self,
        t: npt.ArrayLike,
        channels: Mapping[str, npt.ArrayLike],
        *,
        meta: Mapping[str, Any] | None = None,
        name: str = "",
    ) -> None:
        if not isinstance(channels, Mapping):
            raise InputError("channels is not a mapping", key="channels", value=channels, remedy="give {name: array}")
        if "t" in channels:
            remedy = "give it as the first argument"
            raise InputError("t is among the channels", key="channels", remedy=remedy, channel="t")
        self._fill({"t": t, **channels}, meta, name, Rows(), copy=True)

    @classmethod
    def from_table(cls, table: Table, name: str = "") -> Recording:
        """Make a recording from a file's raw table, using the table's arrays without copying them.

        Args:
            table: columns with ``t``; its arrays must not be changed afterwards.
            name: a label.

        Returns:
            The recording.

        Raises:
            InputError: as the constructor; rows count as in the table.
        """
        settle_units(table)
        recording = cls.__new__(cls)
        recording._fill(table.columns, table.meta, name, table.rows, copy=False)
        return recording

    def _fill(
        self, columns: Mapping[str, npt.ArrayLike], meta: Mapping[str, Any] | None, name: str, rows: Rows, *, copy: bool
    ) -> None:
        """Check columns and meta data, and store them read-only."""
        t, channels = checked(columns, rows, copy=copy)
        known = locked(meta)
        check_units(known.get("units", {}), channels)
        check_prescribed(known.get("prescribed", ()), channels)
        for attribute, value in (("t", t), ("channels", MappingProxyType(channels)), ("meta", known), ("name", name)):
            object.__setattr__(self, attribute, value)

    @classmethod
    def from_xarray(cls, dataset: Any) -> Recording:
        """Make a recording from a dataset, of `to_xarray` (possibly trimmed) or from another source.

        Args:
            dataset: an xarray.Dataset with the coordinate ``t`` [s] and variables over ``t``, or over ``t`` and one
                labelled dimension: ``q`` over ``(t, joint)`` gives ``q.<joint>``. ``units``, if given, must be SI.

        Returns:
            The recording; a dataset of `to_xarray` is converted back bit for bit, order and meta included.

        Raises:
            InputError: it has no ``t``, other dimensions or types, or is no recording for another reason.
            MissingExtra: xarray is not installed.
        """
        from flexdyn.records.dataset import table_of

        return cls.from_table(table_of(dataset), str(dataset.attrs.get("name", "")))

    def to_xarray(self) -> Any:
        """An xarray dataset: signals that every joint has over ``(t, joint)``, other channels over ``t``.

        Returns:
            An xarray.Dataset whose variables have ``units`` and ``long_name``; the conversion loses nothing.

        Raises:
            MissingExtra: xarray is not installed.
        """
        from flexdyn.records.dataset import to_dataset

        return to_dataset(self)

    @classmethod
    def from_pandas(
        cls, frame: Any, *, repair: Iterable[str | Mapping[str, Any]] = (), name: str | None = None
    ) -> Recording:
        """Make a recording from a data frame with one column for each channel.

        Args:
            frame: a pandas.DataFrame with the times [s] in the column ``t`` or as its index; dates and time spans are
                converted to seconds, dates from the first one. Columns of two levels are ``(signal, joint)``; names may
                contain SI units (``q.elbow [rad]``).
            repair: as in `read_recording`; a missing value (NaN, None, NA) is a gap.
            name: a label; default: that of the recording from which the frame was made.

        Returns:
            The recording; a frame of `to_pandas` is converted back bit for bit, meta included.

        Raises:
            InputError: columns without numbers, or it is no recording for another reason.
        """
        from flexdyn.records.frame import table_of_frame
        from flexdyn.records.repairs import repaired, repairs_of

        table, known = table_of_frame(frame)
        return cls.from_table(repaired(table, repairs_of(repair)), known if name is None else name)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame: the index is ``t`` [s], the columns are the channels; the conversion loses nothing.

        Raises:
            MissingExtra: pandas is not installed.
        """
        from flexdyn.records.frame import to_frame

        return to_frame(self)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that have a signal, in order of first appearance."""
        return tuple(dict.fromkeys(parts[1] for parts in map(split_name, self.channels) if parts))

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that some joint has, in order of first appearance."""
        return tuple(dict.fromkeys(parts[0] for parts in map(split_name, self.channels) if parts))

    @property
    def prescribed(self) -> tuple[str, ...]:
        """Joints whose motion a test rig prescribes: their ``tau`` is the force or torque that the rig needs for it."""
        return tuple(self.meta.get("prescribed", ()))

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Gaps: times [s] between which nothing was recorded for more than 10 median periods.

        Nothing is interpolated across a gap: resampling refuses it, differences leave it out, curves are interrupted,
        and a diagnosis uses the pieces between gaps as separate recordings.
        """
        return gaps_of(self.t)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.t[-1]) - float(self.t[0])

    @property
    def rate(self) -> float:
        """Mean sample rate [Hz]."""
        return (len(self.t) - 1) / self.duration

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.t)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the channels, in order; time is no channel, it is ``rec.t``."""
        return iter(self.channels)

    def keys(self) -> KeysView[str]:
        """Names of the channels."""
        return self.channels.keys()

    def values(self) -> ValuesView[Array]:
        """Samples of the channels."""
        return self.channels.values()

    def items(self) -> ItemsView[str, Array]:
        """Names and samples of the channels."""
        return self.channels.items()

    def __contains__(self, channel: object) -> bool:
        """Whether there is a channel of that name."""
        return channel in self.channels

    def __getitem__(self, channel: str) -> Array:
        """Samples of one channel, read-only.

        Raises:
            InputError: there is no such channel; the message names the most similar one.
        """
        try:
            return self.channels[channel]
        except KeyError:
            remedy = "the times are rec.t" if channel == "t" else did_you_mean(channel, self.channels)
            raise InputError("no such channel", key=str(channel), remedy=remedy, channel=channel) from None

    def has(self, signal: str, joint: str) -> bool:
        """Whether the joint has that signal."""
        return f"{signal}.{joint}" in self.channels

    def signal(self, name: str, joints: Sequence[str]) -> Array:
        """One signal of several joints side by side.

        Args:
            name: such as ``"tau"``.
            joints: joints in the order of the columns.

        Returns:
            A new array (samples, len(joints)).

        Raises:
            InputError: a joint lacks the signal.
        """
        return side_by_side(self, name, joints)

    resample = resampled
    decimate = decimated
    trim = cut.trimmed
    split = cut.split
    shifted = cut.shifted
    smoothed = derivatives.smoothed_channels
    noise = derivatives.noise_of

    def beside(self, *others: Recording, method: str = "linear") -> Recording:
        """The recording with the channels of others, at its own times; see `flexdyn.records.signals.beside.beside`."""
        return beside(self, others, method)

    def unit(self, channel: str) -> str:
        """Unit of ``t`` or a channel, from ``meta["units"]`` or the signal; empty if it is not known."""
        return unit_of(channel, self.meta.get("units"))

    def same_as(self, other: Recording) -> bool:
        """Whether times and channels are the same, bit for bit and in order; meta is not compared (CSV drops it)."""
        return same_samples(self, other)

    def __eq__(self, other: object) -> bool:
        """Same samples bit for bit, same channels in the same order, same meta."""
        if not isinstance(other, Recording):
            return NotImplemented
        return self.same_as(other) and as_plain(self.meta) == as_plain(other.meta)

    def __hash__(self) -> int:
        """Hash of equal recordings; the samples between the first and the last are not used."""
        return hash((len(self.t), float(self.t[0]), float(self.t[-1]), tuple(self.channels)))

    def __repr__(self) -> str:
        """Joints, signals, duration and rate in one line."""
        return extent_line(self)

    def _repr_html_(self) -> str:
        """HTML for notebooks: extent, gaps, and the range of each channel."""
        return as_card(self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Read-only mappings cannot be pickled: send plain ones, which are checked again when they are unpickled."""
        return (Recording.from_table, (Table({"t": self.t, **self.channels}, as_plain(self.meta)), self.name))
