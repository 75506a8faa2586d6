"""Fields of message types: as defined in the bag, else as in ROS."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from flexdyn.errors import InputError
from flexdyn.records.ros.columns import CONTROLLER_STATE, DYNAMIC_JOINT_STATE
from flexdyn.records.ros.walk import Fields
from flexdyn.records.table import damage_named

_LONGEST_DEFINITION = 2**17


def _fields(kind: str, *names: str) -> str:
    return "".join(f"{kind} {name}\n" for name in names)


_TRAJECTORY_POINT, _MULTI_POINT = "trajectory_msgs/JointTrajectoryPoint", "trajectory_msgs/MultiDOFJointTrajectoryPoint"
_NAMES = ("reference", "feedback", "error", "output")
_POINTS, _OLD_POINTS = _fields(_TRAJECTORY_POINT, *_NAMES), _fields(_TRAJECTORY_POINT, "desired", "actual")
_MULTI = _fields(_MULTI_POINT, *(f"multi_dof_{name}" for name in _NAMES))
_OLD_MULTI = _fields(_MULTI_POINT, "multi_dof_desired", "multi_dof_actual")
_HEAD = "std_msgs/Header header\nstring[] joint_names\n"
_MULTI_JOINTS = "string[] multi_dof_joint_names\n"
_NEW = f"{_HEAD}{_POINTS}{_MULTI_JOINTS}{_MULTI}"
_GAINS = ("p", "i", "d", "i_clamp")
_LOOP = ("set_point", "process_value", "process_value_dot", "error", "time_step", "command")

INTERFACE_VALUE = "control_msgs/msg/InterfaceValue"

# control_msgs is not among the types that rosbags brings; its fields changed over the years.
_CONTROL: dict[str, tuple[str, ...]] = {
    CONTROLLER_STATE: (
        f"{_HEAD}{_OLD_POINTS}{_fields(_TRAJECTORY_POINT, 'error')}",
        f"{_HEAD}{_POINTS}{_OLD_POINTS}{_MULTI_JOINTS}{_MULTI}{_OLD_MULTI}",
        _NEW,
        f"{_NEW}float64 speed_scaling_factor\n",
    ),
    "control_msgs/msg/JointControllerState": (
        f"std_msgs/Header header\n{_fields('float64', *_LOOP, *_GAINS)}bool antiwindup\n",
    ),
    DYNAMIC_JOINT_STATE: (f"{_HEAD}control_msgs/InterfaceValue[] interface_values\n",),
    INTERFACE_VALUE: ("string[] interface_names\nfloat64[] values\n",),
}


def stored(definition: MessageDefinition, msgtype: str, *, cdr: bool) -> Iterator[Fields]:
    """Fields of a message type and of its parts: one answer if the bag defines it, else all versions that ROS has had.

    Args:
        definition: in the bag, if any.
        msgtype: such as ``sensor_msgs/msg/JointState``.
        cdr: whether the bag is one of ROS 2.

    Raises:
        InputError: the definition cannot be parsed, or there is none and ROS has no such type.
    """
    fields: dict[str, Any] = {}
    if definition.format != MessageDefinitionFormat.NONE:
        if len(definition.data) > _LONGEST_DEFINITION:
            raise InputError("a message definition is longer than 128 KiB", value=msgtype)
        with damage_named(f"the definition of {msgtype} cannot be read"):
            fields = _parsed(definition, msgtype)
        yield {**_without_constants(get_typestore(Stores.EMPTY).fielddefs), **_without_constants(fields)}
        return
    known = _without_constants(get_typestore(Stores.ROS2_HUMBLE if cdr else Stores.ROS1_NOETIC).fielddefs)
    for name, texts in _CONTROL.items():
        known.update(_without_constants(get_types_from_msg(texts[0], name)))
    if msgtype not in known:
        problem = "the bag does not hold the definition of its messages, and ROS has no such type"
        raise InputError(problem, value=msgtype, remedy="convert the bag to MCAP where the type is installed")
    if msgtype not in _CONTROL:
        yield known
    for text in _CONTROL.get(msgtype, ()):
        yield {**known, **_without_constants(get_types_from_msg(text, msgtype))}


def control_types() -> dict[str, Any]:
    """The parsed definitions that `DynamicJointState` needs beyond those of rosbags, to be registered for writing."""
    types: dict[str, Any] = {}
    for msgtype in (INTERFACE_VALUE, DYNAMIC_JOINT_STATE):
        types |= get_types_from_msg(_CONTROL[msgtype][0], msgtype)
    return types


def _parsed(definition: MessageDefinition, msgtype: str) -> dict[str, Any]:
    """Types that a definition has, by name, from MSG or IDL."""
    if definition.format == MessageDefinitionFormat.MSG:
        return dict(get_types_from_msg(definition.data, msgtype))
    fields: dict[str, Any] = {}
    line = "=" * 80 + "\n"
    parts = definition.data.split(line)[1:] if definition.data.startswith(f"{line}IDL: ") else [f"\n{definition.data}"]
    for part in parts:
        fields.update(get_types_from_idl(part.split("\n", 1)[1]))
    return fields


def _without_constants(types: Any) -> dict[str, Any]:
    """Fields by type, without the constants."""
    return {name: parsed[1] for name, parsed in types.items()}
