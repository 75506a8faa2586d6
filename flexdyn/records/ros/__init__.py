"""Bags of ROS 1 and ROS 2: .bag, .mcap, .db3 and the folder of a ROS 2 bag, through rosbags; no ROS is needed.

Raw columns, as a channel map names them, are the fields of a message, with the joint's name for the index where a list
goes along with the message's list of joints: ``position.elbow`` (JointState), ``feedback.positions.elbow``
(JointTrajectoryControllerState), ``position.elbow`` (DynamicJointState: interface, joint), ``wrench.force.x``,
``data.0`` (Float64MultiArray), ``data`` (Float64). Any message made of numbers is read so. With its topic in front,
``/joint_states.position.elbow``, a column is taken from that topic; without, from the one that ``source.topic`` names,
or the only one there is. Columns of several topics make one recording: those of other times are put on the
times of one, see `flexdyn.records.ros.merging`, and a `RecordingWarning` says how.

Without a map the only topic of joint states is read: position is ``q``, velocity ``v``, effort ``tau``; of the state of
a controller, feedback (older: actual) gives ``q`` and ``v``, and output ``tau``. What was assumed stands in
``meta["notes"]``.

Time is the stamp in the header, or with ``clock: bag`` the time of recording: whole nanoseconds, divided once. Stamps
from one year on (the time of day) are counted from the first, which is kept in ``meta["start_ns"]``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexdyn.errors import needed
from flexdyn.records.request import Request
from flexdyn.records.table import Table

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording


def read(path: Path, request: Request) -> Table:
    """Read the topics asked for.

    Raises:
        InputError: not a bag, damaged, no topic to choose, joints that come and go, no stamps.
        MissingExtra: rosbags is not installed.
    """
    _library()
    from flexdyn.records.ros.reading import read as inner

    return inner(path, request)


def write(rec: Recording, path: Path, suffix: str) -> None:
    """Write a bag of the kind that the suffix (``.bag``, ``.mcap``, ``.db3``) names to a path that may have another.

    Standard signals become JointState on ``/joint_states`` (q, v, tau), ``/motor_states`` (theta, omega, tau_applied)
    and ``/transmission_states`` (effort: tau_s); the lists of a JointState go along with its names, so joints with
    other fields than the first get a topic of their own below it, ``/joint_states/position``. Everything else becomes
    DynamicJointState on ``/flexdyn/channels``; what ROS has no place for stands in ``/flexdyn/meta``. Stamps are times
    rounded to whole nanoseconds; where they do not give the times back, these stand among the channels as ``t``. So
    every double comes back bit for bit.

    Raises:
        InputError: two samples fall on one nanosecond, or times that ROS cannot hold.
        MissingExtra: rosbags is not installed.
    """
    _library()
    from flexdyn.records.ros.writing import write as inner

    inner(rec, path, suffix)


def _library() -> None:
    with needed("rosbags", "ros"):
        import rosbags.rosbag2  # noqa: F401
