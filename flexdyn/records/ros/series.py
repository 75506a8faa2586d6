"""The messages of one topic: which columns are taken, and how blocks of messages become columns with NumPy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.arrays import Array, Flags
from flexdyn.errors import InputError
from flexdyn.records.bounds import check_size
from flexdyn.records.ros.bag import Bag, Topic
from flexdyn.records.ros.clock import NANO, Integers
from flexdyn.records.ros.columns import channels_of, message_columns, own_channels, stamp_of
from flexdyn.records.ros.walk import Bytes, MessageLayout, MessageNumber
from flexdyn.records.ros.words import nearest_name, shortened_list

_TWO_PUBLISHERS = "several publishers share the topic: name the channels of one group of joints in a channel map"
_BAG_CLOCK = "take the time of recording: source: {clock: bag} in a channel map"
_BLOCK_MESSAGES = 4096
_BLOCK_BYTES = 8 * 2**20
_EXACT = 2**53


class Conventional:
    """The channels of a topic without a map; every message must have the same ones."""

    def __init__(self, topic: str, msgtype: str, *, own: bool) -> None:
        self.topic, self.msgtype, self.own = topic, msgtype, own
        self.names: frozenset[str] | None = None

    def __call__(self, columns: Mapping[str, MessageNumber], row: int) -> dict[str, MessageNumber]:
        """Numbers by channel."""
        channels = own_channels(columns, self.topic, self.msgtype) if self.own else channels_of(columns, self.msgtype)
        if self.names is None:
            self.names = frozenset(channels)
            if not channels:
                remedy = "name columns in a channel map; there are " + (shortened_list(columns) or "none")
                raise InputError("the topic has no channels of joints", key=self.topic, remedy=remedy)
        missing, new = sorted(self.names - set(channels)), sorted(set(channels) - self.names)
        if missing or new:
            verb, other = ("lacks", "has") if missing else ("has", "lacks")
            problem = f"message {row} {verb} {shortened_list(missing or new)}, which the first {other}"
            raise InputError(problem, key=self.topic, remedy=_TWO_PUBLISHERS, row=row, channel=(missing or new)[0])
        return {channel: columns[name] for name, channel in channels.items()}

    def check(self) -> None:
        """Accept: no column was requested."""


class Wanted:
    """Columns that are requested by name; messages without any of them belong to another publisher and are skipped."""

    def __init__(self, topic: str, names: Mapping[str, str]) -> None:
        self.topic, self.names = topic, names
        self.found: set[str] = set()
        self.known: dict[str, None] = {}

    def __call__(self, columns: Mapping[str, MessageNumber], row: int) -> dict[str, MessageNumber] | None:
        """Numbers by the name of the table's column."""
        missing = [name for name in self.names if name not in columns]
        if missing and len(self.known) < 1000:
            self.known.update(dict.fromkeys(columns))
        if len(missing) == len(self.names):
            return None
        if missing:
            alike = nearest_name(missing[0], columns)
            problem = f"message {row} of {self.topic} has no such column, but has other requested ones"
            raise InputError(problem, remedy=f"{alike} if {_TWO_PUBLISHERS}", row=row, channel=missing[0])
        self.found.update(self.names)
        return {out: columns[name] for name, out in self.names.items()}

    def check(self) -> None:
        """Refuse columns that no message had.

        Raises:
            InputError: the topic has no such column.
        """
        if missing := [name for name in self.names if name not in self.found]:
            problem, remedy = f"the topic {self.topic} has no such column", nearest_name(missing[0], self.known)
            raise InputError(problem, remedy=remedy, channel=missing[0])


class Series:
    """Columns of one topic, growing.

    Args:
        bag: that has the messages.
        topic: of it.
        pick: chooses the columns of a message.
        clock: ``message`` or ``bag``.
    """

    def __init__(self, bag: Bag, topic: Topic, pick: Conventional | Wanted, clock: str) -> None:
        self._bag, self._about = bag, topic
        self.topic, self.msgtype, self.pick, self.clock = topic.name, topic.msgtype, pick, clock
        self.count = bag.total if topic.count is None else topic.count  # an upper bound
        self.columns: dict[str, Array] = {}
        self.stamps: Integers = np.empty(0, np.int64)
        self.filled = self.seen = 0
        self._raws: list[bytes] = []
        self._times: list[int] = []
        self._bytes = 0

    def add(self, time: int, raw: bytes) -> bool:
        """Take one message; True if a block was processed.

        Args:
            time: of recording [ns].
            raw: bytes of the message.
        """
        self._times.append(time)
        self._raws.append(raw)
        self._bytes += len(raw)
        if len(self._raws) < _BLOCK_MESSAGES and self._bytes < _BLOCK_BYTES:
            return False
        self.flush()
        return True

    def flush(self) -> None:
        """Process the collected messages.

        Raises:
            InputError: more messages than the index announces, or one of another form than its type has.
        """
        raws, times = self._raws, self._times
        self._raws, self._times, self._bytes = [], [], 0
        if not raws:
            return
        if self.seen + len(raws) > self.count:
            problem = f"more messages than the {self.count} that the index announces"
            raise InputError(problem, key=self.topic, remedy="the bag is damaged; reindex it")
        stamps = self._stamps(times)
        keep = np.zeros(len(raws), bool)
        values: Array = np.empty((len(self.columns), len(raws)))
        lengths = np.fromiter(map(len, raws), np.int64, len(raws))
        for length in dict.fromkeys(lengths.tolist()):
            rows = np.flatnonzero(lengths == length)
            block = np.frombuffer(b"".join([raws[row] for row in rows]), np.uint8).reshape(len(rows), length)
            while len(rows):
                layout = self._bag.layout(self._about, raws[rows[0]])
                same = layout.matches(block)
                numbers = self._picked(layout, int(rows[0]))
                if numbers is not None:
                    if not len(values):
                        values = np.empty((len(self.columns), len(raws)))
                    taken = rows[same]
                    for index, name in enumerate(self.columns):
                        values[index, taken] = self._doubles(name, numbers[name].of(block[same]))
                    if self.clock == "message":
                        stamps[taken] = self._stamped(layout, block[same])
                    keep[taken] = True
                rows, block = rows[~same], block[~same]
        self._append(values, stamps, keep)
        self.seen += len(raws)

    def finish(self) -> None:
        """Process the rest and release the memory that was not needed.

        Raises:
            InputError: a requested column is missing, or every stamp is zero.
        """
        self.flush()
        self.pick.check()
        if self.filled < len(self.stamps):
            self.stamps = self.stamps[: self.filled].copy()
            for name in self.columns:
                self.columns[name] = self.columns[name][: self.filled].copy()
        if self.clock == "message" and self.filled and not self.stamps.any():
            raise InputError("every stamp is zero", key=self.topic, remedy=_BAG_CLOCK, channel="t")

    def _stamps(self, times: list[int]) -> Integers:
        if self.clock == "message":
            return np.empty(len(times), np.int64)
        if not all(isinstance(time, int) and -(2**62) < time < 2**62 for time in times):
            raise InputError("a time of recording is no number of nanoseconds", key=self.topic, channel="t")
        return np.array(times, np.int64)

    def _picked(self, layout: MessageLayout, row: int) -> dict[str, MessageNumber] | None:
        numbers = self.pick(message_columns(layout, self.msgtype), self.seen + row)
        if numbers is not None and not self.columns:
            check_size(8 * self.count * (len(numbers) + 1), self._bag.size)
            self.columns = {name: np.empty(self.count) for name in numbers}
            self.stamps = np.empty(self.count, np.int64)
        return numbers

    def _stamped(self, layout: MessageLayout, block: Bytes) -> Integers:
        """The stamps in the messages of a block [ns]."""
        stamp = stamp_of(layout)
        if stamp is None:
            raise InputError(f"messages of {self.msgtype} have no stamp", key=self.topic, remedy=_BAG_CLOCK)
        seconds, nanoseconds = (part.of(block).astype(np.int64) for part in stamp)
        return np.asarray(seconds * NANO + nanoseconds)

    def _doubles(self, name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        if values.dtype.itemsize == 8 and values.dtype.kind in "iu" and (np.abs(values.astype(float)) > _EXACT).any():
            raise InputError("integers beyond 2^53 are no exact doubles", remedy="leave the column out", channel=name)
        return values

    def _append(self, values: Array, stamps: Integers, keep: Flags) -> None:
        """Store the samples that are kept."""
        if not keep.any():
            return
        end = self.filled + int(keep.sum())
        for column, block in zip(self.columns.values(), values, strict=True):
            column[self.filled : end] = block[keep]
        self.stamps[self.filled : end] = stamps[keep]
        self.filled = end
