"""Kinova Gen3: its recordings on the clock of its own control cycles, and the plain models of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

Array = NDArray[np.float64]
SWEPT = (1, 4, 5, 7)
"""Joints with a sweep of their own; all others are at 0 in it."""
ALL = (1, 2, 3, 4, 5, 6, 7)
TORQUE_PER_CURRENT = {1: 9.130, 2: 9.130, 3: 9.130, 4: 9.130, 5: 5.852, 6: 5.852, 7: 5.852}
"""What the authors multiply the motor's current by [N m/A], on the joint's side; where it comes from is not said."""
GEAR_RATIO = 100.0
"""Of the strain-wave gears [1]."""
TOLERANCE = 0.05
"""Of the masses, centres and inertias of the manufacturer's URDF [1]."""
CYCLE = 1e-3
"""Of the arm's controller, which the rows of the files follow [s]."""
FAST = 0.1
"""Speed above which the cycles between two rows can be counted from the positions [rad/s]."""


def read_sweep(folder: Path, joint: int) -> fd.Recording:
    """The sweep of one joint."""
    return in_cycles(fd.read_recording(folder / f"joint_{joint}_trapez.csv"), (joint,))


def read_trajectory(folder: Path) -> fd.Recording:
    """All seven joints at once and three times as fast."""
    return in_cycles(fd.read_recording(folder / "trajectory1.csv"), ALL)


def cycles(recording: fd.Recording, joints: Sequence[int]) -> NDArray[np.intp]:
    """Control cycles from each row to the next (rows - 1,): 0 where a row repeats, 2 and more where one is lost.

    The file has no times. A position that moves on by twice what its velocity says is two cycles later.
    """
    q, v = (recording.signal(signal, [f"joint_{j}" for j in joints]) for signal in ("q", "v"))
    fast = np.abs(v[:-1]) > FAST
    ratio = np.where(fast, np.diff(q, axis=0) / np.where(fast, v[:-1] * CYCLE, 1.0), np.nan)
    counted = np.ones(len(ratio))
    some = fast.any(axis=1)
    counted[some] = np.round(np.nanmedian(ratio[some], axis=1))
    return np.maximum(counted, 0.0).astype(np.intp)


def in_cycles(recording: fd.Recording, joints: Sequence[int]) -> fd.Recording:
    """Positions and torques of some joints, without repeated rows, on the even clock of the control cycles."""
    steps = cycles(recording, joints)
    t, kept = np.concatenate([[0], np.cumsum(steps)]) * CYCLE, np.concatenate([[True], steps > 0])
    channels = {}
    for j in joints:
        channels[f"q.joint_{j}"] = recording[f"q.joint_{j}"][kept]
        channels[f"tau.joint_{j}"] = TORQUE_PER_CURRENT[j] * recording[f"current.joint_{j}"][kept]
    return fd.Recording(t[kept], channels, name=recording.name).resample(rate=1.0 / CYCLE)


def plain(folder: Path, joint: int) -> fd.FlexibleJointModel:
    """One joint of the URDF, the others held at 0: rigid, without friction, its rotor's inertia not known."""
    held = {f"joint_{j}": 0.0 for j in ALL if j != joint}
    robot = fd.load_robot(folder / "gen3.urdf", lock=held)
    numbers = {f"joint_{joint}": {"gear_ratio": GEAR_RATIO, "rotor_inertia": "unknown"}}
    return fd.FlexibleJointModel(robot, joints=numbers, tolerance=TOLERANCE)


def whole(folder: Path) -> fd.FlexibleJointModel:
    """All seven joints of the URDF: rigid, without friction and without rotors."""
    return fd.FlexibleJointModel(fd.load_robot(folder / "gen3.urdf"), joints={"*": {"gear_ratio": GEAR_RATIO}})
