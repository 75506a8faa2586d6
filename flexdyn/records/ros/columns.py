"""Named columns from the numbers of a message, and channels of a recording from these columns."""

from __future__ import annotations

from collections.abc import Mapping

from flexdyn.errors import InputError
from flexdyn.records.ros.walk import MessageLayout, MessageNumber, Path
from flexdyn.records.ros.words import check_word

JOINT_STATE = "sensor_msgs/msg/JointState"
CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"
DYNAMIC_JOINT_STATE = "control_msgs/msg/DynamicJointState"

CONVENTIONAL = (JOINT_STATE, CONTROLLER_STATE, DYNAMIC_JOINT_STATE)
"""Message types that make a recording without a channel map."""

FIELDS = ("position", "velocity", "effort")
"""The lists of a JointState."""

OWN_TOPICS: Mapping[str, tuple[str, str, str]] = {
    "joint_states": ("q", "v", "tau"),
    "motor_states": ("theta", "omega", "tau_applied"),
    "transmission_states": ("", "", "tau_s"),
}
"""Topics of a bag written by flexdyn, and the signals that their position, velocity and effort are."""

CHANNELS_TOPIC = "/flexdyn/channels"
"""Topic, in such a bag, of the channels that JointState has no place for."""

_FIELDS_OF_SIGNALS: Mapping[str, tuple[tuple[str, str], ...]] = {
    JOINT_STATE: (("position", "q"), ("velocity", "v"), ("effort", "tau")),
    CONTROLLER_STATE: (
        ("feedback.positions", "q"),
        ("actual.positions", "q"),
        ("feedback.velocities", "v"),
        ("actual.velocities", "v"),
        ("output.effort", "tau"),
        ("feedback.effort", "tau"),
        ("actual.effort", "tau"),
    ),
    DYNAMIC_JOINT_STATE: (("position", "q"), ("velocity", "v"), ("effort", "tau")),
}
"""The columns of each signal; the first one that a message has is used."""


def message_columns(layout: MessageLayout, msgtype: str) -> dict[str, MessageNumber]:
    """The numbers of a message by the name of their column.

    Args:
        layout: of the message.
        msgtype: its type.

    Raises:
        InputError: a list has not the length of the list of joints, or two columns would have one name.
    """
    joints = _texts_of_list(layout, ("name",)) or _texts_of_list(layout, ("joint_names",))
    lengths: dict[Path, int] = {}
    for number in layout.numbers:
        if isinstance(number.path[-1], int):
            lengths[number.path[:-1]] = number.path[-1] + 1
    columns: dict[str, MessageNumber] = {}
    for number in layout.numbers:
        name = _dynamic(layout, number) if msgtype == DYNAMIC_JOINT_STATE else None
        name = name or _number_name(number, joints, lengths, msgtype)
        check_word(name, "column")
        if name in columns:
            raise InputError("two numbers of a message have one name", key=name, remedy="name every joint once")
        columns[name] = number
    return columns


def stamp_of(layout: MessageLayout) -> tuple[MessageNumber, MessageNumber] | None:
    """Seconds and nanoseconds of the header's stamp, if the message has one."""
    found = {number.path: number for number in layout.numbers[:4]}
    for head in (("header", "stamp"), ("stamp",)):
        if (*head, "sec") in found and (*head, "nanosec") in found:
            return found[(*head, "sec")], found[(*head, "nanosec")]
    return None


def channels_of(columns: Mapping[str, MessageNumber], msgtype: str) -> dict[str, str]:
    """The channel of each column without a map; first the positions of all joints, then the others.

    Args:
        columns: of a message.
        msgtype: its type.

    Returns:
        Channel by column.
    """
    channels: dict[str, str] = {}
    for field, signal in _FIELDS_OF_SIGNALS[msgtype]:
        for name in columns:
            joint = name.removeprefix(f"{field}.")
            if joint != name and f"{signal}.{joint}" not in channels.values():
                channels[name] = f"{signal}.{joint}"
    return channels


def is_own(topic: str) -> bool:
    """Whether a topic of a bag that flexdyn wrote holds channels: ``/joint_states``, ``/joint_states/position``."""
    return topic == CHANNELS_TOPIC or any(f"{topic}/".startswith(f"/{name}/") for name in OWN_TOPICS)


def own_channels(columns: Mapping[str, MessageNumber], topic: str, msgtype: str) -> dict[str, str]:
    """The channels of a topic in a bag that flexdyn wrote, by column."""
    if msgtype == DYNAMIC_JOINT_STATE:
        return {name: name for name, number in columns.items() if number.path[0] == "interface_values"}
    signals = dict(zip(FIELDS, OWN_TOPICS[topic.split("/")[1]], strict=True))
    parts = {name: name.partition(".") for name, number in columns.items() if number.path[0] in signals}
    return {name: f"{signals[field]}.{joint}" for name, (field, _, joint) in parts.items()}


def _number_name(number: MessageNumber, joints: list[str], lengths: Mapping[Path, int], msgtype: str) -> str:
    """The name of a number, with its joint's name in place of the index where a list is one of joints."""
    *head, last = number.path
    if joints and isinstance(last, int):
        count = lengths[number.path[:-1]]
        if count == len(joints):
            last = joints[last]
        elif msgtype in CONVENTIONAL and not str(head[0]).startswith("multi_dof"):
            problem = f"{count} numbers for {len(joints)} joints"
            remedy = "lists must have the same length as the names, or be empty"
            raise InputError(problem, key=".".join(map(str, head)), remedy=remedy)
    return ".".join(str(part) for part in (*head, last))


def _dynamic(layout: MessageLayout, number: MessageNumber) -> str | None:
    """``temperature.elbow`` for a value of DynamicJointState; only the interface if the joint has no name."""
    if number.path[0] != "interface_values":
        return None
    _, joint, _, index = number.path
    interface = layout.texts.get(("interface_values", joint, "interface_names", index))
    name = layout.texts.get(("joint_names", joint))
    if interface is None or name is None:
        raise InputError("a value has no interface or no joint", key="interface_values", remedy="name all of them")
    return f"{interface}.{name}" if name else interface


def _texts_of_list(layout: MessageLayout, path: Path) -> list[str]:
    return [text for where, text in layout.texts.items() if where[:-1] == path and isinstance(where[-1], int)]
