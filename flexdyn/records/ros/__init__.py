"""Bags of ROS 1 and ROS 2: .bag, .mcap, .db3 and the folder of a ROS 2 bag, through rosbags; no ROS is needed.

A channel map names raw columns by the fields of a message. If a list belongs to the message's list of joints, the index
is the joint's name: ``position.elbow`` (JointState), ``feedback.positions.elbow`` (JointTrajectoryControllerState),
``position.elbow`` (DynamicJointState: interface, joint), ``wrench.force.x``, ``data.0`` (Float64MultiArray), ``data``
(Float64). Any message made of numbers is read in this way. A column with
its topic in front, ``/joint_states.position.elbow``, is taken from that topic; otherwise from ``source.topic``, or from
the only topic. Columns of several topics make one recording: all are converted to the times of one topic, see
`flexdyn.records.ros.merging`, and a `RecordingWarning` says how.

Without a map the only topic of joint states is read: position is ``q``, velocity ``v``, effort ``tau``. Of the state of
a controller, feedback (older: actual) gives ``q`` and ``v``, and output ``tau``. The assumptions are in
``meta["notes"]``.

Time is the stamp in the header, or with ``clock: bag`` the time of recording: whole nanoseconds, divided once. Stamps
of more than one year (the time of day) are counted from the first one, which is kept in ``meta["start_ns"]``.
"""

from __future__ import annotations

from pathlib import Path

from flexdyn.errors import needed
from flexdyn.records.recording import Recording
from flexdyn.records.request import Request
from flexdyn.records.table import Table


def read(path: Path, request: Request) -> Table:
    """Read the requested topics.

    Args:
        path: of the file.
        request: what is wanted, and how the file is laid out.

    Raises:
        InputError: not a bag, a damaged one, no clear topic, joints that change between messages, no stamps.
        MissingExtra: rosbags is not installed.
    """
    _need_rosbags()
    from flexdyn.records.ros.reading import read_bag

    return read_bag(path, request)


def write(rec: Recording, path: Path, suffix: str) -> None:
    """Write a bag in the format of a suffix (``.bag``, ``.mcap``, ``.db3``); the path may have another suffix.

    Standard signals become JointState on ``/joint_states`` (q, v, tau), ``/motor_states`` (theta, omega, tau_applied)
    and ``/transmission_states`` (effort: tau_s). The lists of a JointState must have the length of its names, so joints
    with other fields than the first get a separate topic below it, ``/joint_states/position``. All other channels
    become DynamicJointState on ``/flexdyn/channels``; data without a place in ROS are in ``/flexdyn/meta``. Stamps are
    times rounded to whole nanoseconds; if they do not determine the times exactly, these are an additional channel
    ``t``. So every double can be read back bit for bit.

    Raises:
        InputError: two samples fall on one nanosecond, or times that ROS cannot hold.
        MissingExtra: rosbags is not installed.
    """
    _need_rosbags()
    from flexdyn.records.ros.writing import write_bag as inner

    inner(rec, path, suffix)


def _need_rosbags() -> None:
    with needed("rosbags", "ros"):
        import rosbags.rosbag2  # noqa: F401
