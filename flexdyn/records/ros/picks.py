"""The columns of a topic that become columns of the table: by convention, or the requested ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from flexdyn.errors import InputError
from flexdyn.records.ros.columns import channels_of, own_channels
from flexdyn.records.ros.walk import MessageNumber
from flexdyn.records.ros.words import listed, near

_TWO_PUBLISHERS = "several publishers share the topic: name the channels of one group of joints in a channel map"


class Pick(Protocol):
    """Chooses among the columns of a message."""

    def __call__(self, columns: Mapping[str, MessageNumber], row: int) -> dict[str, MessageNumber] | None:
        """Numbers by name of the table's column, or None if the message is not needed."""

    def check(self) -> None:
        """Refuse requested columns that did not occur; called at the end."""


class Conventional:
    """The channels of a topic without a map; every message must have the same ones."""

    def __init__(self, topic: str, msgtype: str, *, own: bool) -> None:
        self.topic, self.msgtype, self.own = topic, msgtype, own
        self.names: frozenset[str] | None = None

    def __call__(self, columns: Mapping[str, MessageNumber], row: int) -> dict[str, MessageNumber]:
        """Numbers by channel."""
        own = self.own
        channels = own_channels(columns, self.topic, self.msgtype) if own else channels_of(columns, self.msgtype)
        if self.names is None:
            self.names = frozenset(channels)
            if not channels:
                remedy = "name columns in a channel map; there are " + (listed(columns) or "none")
                raise InputError("the topic has no channels of joints", key=self.topic, remedy=remedy)
        missing, new = sorted(self.names - set(channels)), sorted(set(channels) - self.names)
        if missing or new:
            verb, other = ("lacks", "has") if missing else ("has", "lacks")
            problem = f"message {row} {verb} {listed(missing or new)}, which the first {other}"
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
            alike = near(missing[0], columns)
            problem = f"message {row} of {self.topic} has no such column, but has other requested ones"
            raise InputError(problem, remedy=f"{alike} if {_TWO_PUBLISHERS}", row=row, channel=missing[0])
        self.found.update(self.names)
        return {out: columns[name] for name, out in self.names.items()}

    def check(self) -> None:
        """Refuse columns that no message had."""
        if missing := [name for name in self.names if name not in self.found]:
            problem, remedy = f"the topic {self.topic} has no such column", near(missing[0], self.known)
            raise InputError(problem, remedy=remedy, channel=missing[0])
