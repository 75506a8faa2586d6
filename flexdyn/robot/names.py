"""Robots known by name: those that flexdyn ships, and the fixed-base ones of example-robot-data."""

from __future__ import annotations

import functools
import os
import sys
from pathlib import Path

import pinocchio as pin

from flexdyn.errors import InputError, did_you_mean
from flexdyn.io.files import exists

EXAMPLES = {
    "alex_nub_hands": "alex_description/urdf/alex_nub_hands.urdf",
    "alex_sake_hands": "alex_description/urdf/alex_sake_hands.urdf",
    "allegro_left_hand": "allegro_hand_description/urdf/allegro_left_hand.urdf",
    "allegro_right_hand": "allegro_hand_description/urdf/allegro_right_hand.urdf",
    "asr_twodof": "asr_twodof_description/urdf/TwoDofs.urdf",
    "baxter": "baxter_description/urdf/baxter.urdf",
    "double_pendulum": "double_pendulum_description/urdf/double_pendulum.urdf",
    "double_pendulum_continuous": "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
    "double_pendulum_simple": "double_pendulum_description/urdf/double_pendulum_simple.urdf",
    "finger_edu": "finger_edu_description/robots/finger_edu.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "panda": "panda_description/urdf/panda.urdf",
    "panda_collision": "panda_description/urdf/panda_collision.urdf",
    "pr2": "pr2_description/urdf/pr2.urdf",
    "so100": "so_arm_description/urdf/so100.urdf",
    "so101": "so_arm_description/urdf/so101.urdf",
    "talos_arm": "talos_data/robots/talos_left_arm.urdf",
    "talos_left_arm": "talos_data/robots/talos_left_arm.urdf",
    "tiago": "tiago_description/robots/tiago.urdf",
    "tiago_dual": "tiago_description/robots/tiago_dual.urdf",
    "tiago_no_hand": "tiago_description/robots/tiago_no_hand.urdf",
    "tiago_pro": "tiago_pro_description/robots/tiago_pro.urdf",
    "ur10": "ur_description/urdf/ur10_robot.urdf",
    "ur10_limited": "ur_description/urdf/ur10_joint_limited_robot.urdf",
    "ur3": "ur_description/urdf/ur3_robot.urdf",
    "ur3_gripper": "ur_description/urdf/ur3_gripper.urdf",
    "ur3_limited": "ur_description/urdf/ur3_joint_limited_robot.urdf",
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "ur5_gripper": "ur_description/urdf/ur5_gripper.urdf",
    "ur5_limited": "ur_description/urdf/ur5_joint_limited_robot.urdf",
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "z1": "z1_description/urdf/z1.urdf",
}
"""Name -> file below ``share/example-robot-data/robots``; no walking or flying robots, no faulty files."""


def shipped_dir() -> Path:
    """The folder of the shipped robots: inside the installed package, or next to the package in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "robots"
    return inside if inside.is_dir() else package.parent / "robots"


@functools.cache
def example_data_dir() -> Path | None:
    """The folder ``share/example-robot-data`` of the installed data, or None.

    Usually Pinocchio and the data have the same prefix; otherwise the prefix is searched on sys.path.
    """
    below = Path("share", "example-robot-data")
    prefixes = [Path(pin.__file__).resolve().parents[4], Path(sys.prefix)]
    prefixes += [Path(entry) / "cmeel.prefix" for entry in sys.path if entry]
    return next((prefix / below for prefix in prefixes if (prefix / below / "robots").is_dir()), None)


def robot_names() -> tuple[str, ...]:
    """Every name that load_robot knows on this machine, in alphabetical order.

    Example:
        >>> "ur5" in fd.robot_names()
        True
    """
    examples = EXAMPLES if example_data_dir() is not None else {}
    return tuple(sorted({*_shipped(), *examples}))


def find_robot(source: str | Path) -> tuple[Path, str | None]:
    """The URDF file that a path or a name means.

    Args:
        source: a path, or a name of robot_names(). A known name has priority over a file: ``panda`` is the robot even
            if there is a folder of that name; ``./panda`` is the folder.

    Returns:
        The absolute path, and the name if it was one.

    Raises:
        InputError: neither a file nor a known name, or the data of example-robot-data are not installed.
    """
    if isinstance(source, Path):
        return _absolute(source), None
    if source.lstrip().startswith("<"):
        raise InputError("this is URDF text", key="robot", value=source, remedy="save it and give the path of the file")
    if source in EXAMPLES:
        data = example_data_dir()
        if data is None:
            remedy = "install it with: pip install example-robot-data"
            raise InputError("the data of example-robot-data are missing", key="robot", value=source, remedy=remedy)
        return data / "robots" / EXAMPLES[source], source
    if source in _shipped():
        return shipped_dir() / source / "robot.urdf", source
    path = _absolute(Path(source))
    # Only a text that cannot be a path is an unknown name.
    if not source.strip() or (Path(source).name == source and not Path(source).suffix and not exists(path)):
        remedy = did_you_mean(source.lower(), robot_names())
        raise InputError("neither a file nor a known robot", key="robot", value=source, remedy=remedy)
    return path, None


def _shipped() -> tuple[str, ...]:
    return tuple(entry.parent.name for entry in shipped_dir().glob("*/robot.urdf") if entry.parent.name not in EXAMPLES)


def _absolute(path: Path) -> Path:
    try:
        return Path(os.path.abspath(path.expanduser()))
    except RuntimeError:
        return Path(os.path.abspath(path))
