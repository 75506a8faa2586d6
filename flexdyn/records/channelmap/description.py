"""A channel map: the meaning of a log's columns, as plain immutable data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, field, fields
from typing import Any

from flexdyn.io.locked import thawed
from flexdyn.records.channelmap.expression import Expression
from flexdyn.records.repairs import Repair
from flexdyn.records.request import Layout, Request
from flexdyn.records.units import split_name

MAP_FORMAT = 1
TIME = "t"


@dataclass(frozen=True)
class Channel:
    """One channel and the source of its numbers: value = sign * (raw in SI) [/ or * gear ratio] + offset.

    Attributes:
        name: ``<signal>.<joint>`` or any other.
        source: raw column by name, or by number from 1 in text files.
        unit: of the raw numbers, or of `full_scale`; None: the unit in the file, else SI.
        sign: 1 or -1.
        offset: added last, in the channel's SI unit.
        factor: SI per raw unit, if there is no unit.
        counts_per_turn: of an encoder.
        full_counts: of a PWM or an ADC: raw counts at the full scale.
        full_scale: value at the full scale, in `unit`; 1 for a duty. A current becomes a torque by the torque constant.
        side: ``motor`` if the raw numbers are those of the motor's shaft: positions and velocities are then divided by
            the gear ratio, torques multiplied by it.
        gear_ratio: 1, or rad/m for a prismatic joint.
        torque_constant: N m/A.
        delay: delay of this channel's stamps [s].
    """

    name: str
    source: str | int
    unit: str | None = None
    sign: int = 1
    offset: float = 0.0
    factor: float | None = None
    counts_per_turn: float | None = None
    full_counts: float | None = None
    full_scale: float | None = None
    side: str = "link"
    gear_ratio: float | None = None
    torque_constant: float | None = None
    delay: float = 0.0

    @property
    def signal(self) -> str:
        """Signal of the channel; empty if it is none."""
        return (split_name(self.name) or ("", ""))[0]

    @property
    def joint(self) -> str:
        """Joint of the channel: the part of the name after the first dot."""
        return self.name.partition(".")[2]


@dataclass(frozen=True)
class TimeSource:
    """The source of the times.

    Attributes:
        source: raw column by name, or by number from 1 in text files.
        unit: of that column.
        rate: samples per second, if the file has no column of time [Hz].
        start: ``zero`` subtracts the first time, ``keep`` does not.
        shift: added to all times, after that [s].
    """

    source: str | int = TIME
    unit: str | None = None
    rate: float | None = None
    start: str = "keep"
    shift: float = 0.0


@dataclass(frozen=True)
class Coupling:
    """Motors that move several joints together: x_joints = P x_motors, tau_joints = T tau_motors.

    Attributes:
        joints: whose channels have the motors' values before and the joints' values after the conversion.
        position: P, by rows.
        torque: T, by rows; the inverse transpose of P keeps the power.
        signals: that P acts on; T acts on tau and tau_applied.
    """

    joints: tuple[str, ...]
    position: tuple[tuple[float, ...], ...]
    torque: tuple[tuple[float, ...], ...]
    signals: tuple[str, ...] = ("theta", "omega")


@dataclass(frozen=True)
class ChannelMap:
    """The meaning of a log's columns: names, units, gears, couplings, clocks. Made by `read_map` or `from_dict`.

    Attributes:
        channels: in the map's order.
        time: source of the times.
        couplings: applied last.
        prismatic: joints that the map declares prismatic; for others a unit may show it.
        keep_others: whether columns that the map does not name are kept as they are.
        repair: requested repairs, in order.
        layout: of the file.
        computed: channels made of others, in SI, each with its expression, in order.
        prescribed: joints whose motion a test rig prescribes.

    Example:
        >>> map_ = fd.ChannelMap.from_dict({"flexdyn_map": 1, "time": "stamp", "channels": {"q.elbow": "enc"}})
        >>> [channel.name for channel in map_.channels]
        ['q.elbow']
    """

    channels: tuple[Channel, ...] = ()
    time: TimeSource = field(default_factory=TimeSource)
    couplings: tuple[Coupling, ...] = ()
    prismatic: tuple[str, ...] = ()
    keep_others: bool = False
    repair: tuple[Repair, ...] = ()
    layout: Layout = field(default_factory=Layout)
    computed: tuple[tuple[str, Expression], ...] = ()
    prescribed: tuple[str, ...] = ()

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> ChannelMap:
        """Make the map that the mapping of a map file describes.

        Raises:
            InputError: a key or number that does not fit.
        """
        from flexdyn.records.channelmap.file import map_from_dict

        return map_from_dict(content)

    def to_dict(self) -> dict[str, Any]:
        """The mapping of a map file, as plain data for `from_dict`."""
        content: dict[str, Any] = {"flexdyn_map": MAP_FORMAT}
        entries = {
            "source": _changed(self.layout),
            "time": _changed(self.time),
            "joints": {joint: {"prismatic": True} for joint in self.prismatic},
            "channels": {channel.name: _changed(channel) for channel in self.channels},
            "computed": {name: expression.text for name, expression in self.computed},
            "couplings": [thawed(asdict(coupling)) for coupling in self.couplings],
            "repair": [repair.to_plain() for repair in self.repair],
            "prescribed": list(self.prescribed),
        }
        content |= {key: entry for key, entry in entries.items() if entry}
        return content | {"others": "keep" if self.keep_others else "drop"}

    def request(self, progress: Any = None) -> Request:
        """The request for the reader of the file: only named columns are read."""
        wanted = {channel.source for channel in self.channels}
        if self.time.rate is None:
            wanted.add(self.time.source)
        named = frozenset(wanted)
        return Request(None if self.keep_others else named, self.layout, progress, mapped=True, named=named)


def column_name(source: str | int) -> str:
    """Name of a source in a table: a column that was requested by its number is ``column n``."""
    return source if isinstance(source, str) else f"column {source}"


def _changed(entry: Any) -> dict[str, Any]:
    """Fields that do not have their default, by their keys in a map file."""
    plain: dict[str, Any] = {}
    for item in fields(entry):
        value = getattr(entry, item.name)
        if item.name != "name" and (item.default is MISSING or value != item.default):
            plain["from" if item.name == "source" else item.name] = value
    return plain
