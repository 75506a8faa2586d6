"""Logs as labs have them: a German spreadsheet's CSV, a ROS 2 bag of two topics, a MATLAB struct."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.io
from numpy.typing import NDArray
from rosbags import rosbag2
from rosbags.typesys import Stores, get_typestore

from first_hour.arm import GEAR_RATIO, JOINTS, TORQUE_CONSTANT

Array = NDArray[np.float64]
MISSING = 97
"""One cell in so many rows is empty."""
LATE = 4e-4
"""By how much the currents' messages are later than those of the positions [s]."""
START = 1_700_000_000_000_000_000
"""Of the bag, time of day [ns]."""
JOINT_STATE = "sensor_msgs/msg/JointState"


def german_csv(file: Path, t: Array, q: Array, tau: Array) -> None:
    """Semicolons, decimal commas, degrees, letters of Windows, a column that nobody filled, and empty cells."""
    lines = ["Zeit [s];Sollwert Wärme [°C];Ist Schulter [°];Ist Ellbogen [°];Moment Schulter [Nm];Moment Ellbogen [Nm]"]
    for row, at in enumerate(t):
        cells = [f"{at:.4f}", "", *(f"{x:.5f}" for x in np.degrees(q[row])), *(f"{x:.4f}" for x in tau[row])]
        if row % MISSING == 5:
            cells[3] = ""
        lines.append(";".join(cells).replace(".", ","))
    file.write_text("\r\n".join(lines) + "\r\n", encoding="latin-1", newline="")


def two_topics(folder: Path, t: Array, q: Array, tau: Array) -> None:
    """A bag's folder: /joint_states with positions, /motor/currents with the motors' currents [A], a little later."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    none = np.zeros(0)
    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
        for topic, late, positions, efforts in (
            ("/joint_states", 0.0, q, None),
            ("/motor/currents", LATE, None, tau / (GEAR_RATIO * TORQUE_CONSTANT)),
        ):
            link = bag.add_connection(topic, JOINT_STATE, typestore=store)
            for row, at in enumerate(t):
                stamp = START + round((at + late) * 1e9)
                time = store.types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
                header = store.types["std_msgs/msg/Header"](time, "")
                lists = (none if values is None else values[row] for values in (positions, None, efforts))
                message = store.types[JOINT_STATE](header, list(JOINTS), *lists)
                bag.write(link, stamp, store.serialize_cdr(message, JOINT_STATE))


def matlab_struct(file: Path, t: Array, q: Array, tau: Array) -> None:
    """One struct: a row of times, matrices of positions in degrees and of torques, a text."""
    scipy.io.savemat(file, {"rec": {"time": t, "pos": np.degrees(q), "trq": tau, "operator": "Mittwochsschicht"}})
