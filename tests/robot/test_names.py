"""Robots known by name: our table of example-robot-data, and the robots shipped with flexdyn."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.errors import InputError
from flexdyn.robot import Tree, load_robot, names, robot_names
from flexdyn.robot.names import shipped_dir

ASKED = [
    "panda",
    "ur3",
    "ur5",
    "ur10",
    "ur3_limited",
    "ur5_limited",
    "ur10_limited",
    "ur3_gripper",
    "ur5_gripper",
    "kinova",
    "z1",
    "xarm7",
    "so100",
    "so101",
    "tiago",
    "tiago_no_hand",
    "tiago_dual",
    "baxter",
    "asr_twodof",
    "double_pendulum",
    "double_pendulum_simple",
    "double_pendulum_continuous",
    "allegro_right_hand",
    "allegro_left_hand",
    "talos_arm",
    "talos_left_arm",
    "finger_edu",
]


@pytest.mark.parametrize("name", names.EXAMPLES)
def test_every_name_of_the_table_loads(
    name: str, rebuild: Callable[[Tree], pin.Model], capfd: pytest.CaptureFixture[str]
) -> None:
    """Quietly, with every joint one number, in Pinocchio's order, and with arrays that rebuild its mass matrix."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = load_robot(name)
    model, tree = robot.pin_model, robot.tree
    assert (robot.name, robot.source) == (name, name)
    assert model.nq == model.nv == model.njoints - 1 == tree.m >= robot.n == tree.n > 0
    original = pin.buildModelFromUrdf(str(names.find_robot(name)[0]))
    assert list(original.names) == list(model.names)
    again = rebuild(tree)
    q = robot.expand(np.random.default_rng(5).normal(size=robot.n))
    one, two = pin.crba(model, model.createData(), q), pin.crba(again, again.createData(), q)
    assert np.allclose(one, two, rtol=1e-9, atol=1e-12)
    assert (robot.lower <= robot.upper).all()
    assert capfd.readouterr() == ("", "")


def test_the_table_holds_every_arm_asked_for() -> None:
    """Arms, grippers, hands, pendulums."""
    assert [name for name in ASKED if name not in names.EXAMPLES] == []
    assert set(names.EXAMPLES) <= set(robot_names())


def test_sizes_of_well_known_arms() -> None:
    """Joint counts as the makers give them; a gripper adds one, unbounded joints add none."""
    counts = {"panda": 8, "ur5": 6, "kinova": 6, "xarm7": 7, "allegro_right_hand": 16, "double_pendulum_continuous": 2}
    assert {name: load_robot(name).n for name in counts} == counts
    assert load_robot("kinova").continuous.count(True) == 3


def test_a_known_name_can_be_locked_and_renamed() -> None:
    """The arm alone of a Panda: seven joints and one end."""
    robot = load_robot("panda", lock={"panda_finger_joint1": 0.02}, name="arm")
    assert (robot.n, robot.name, robot.source) == (7, "arm", "panda")
    assert robot.joint_names == tuple(f"panda_joint{k}" for k in range(1, 8))
    assert not robot.followers
    assert robot.frame("panda_rightfinger").joint == 6
    assert robot.tip in robot.frame_names


@pytest.mark.parametrize(("word", "near"), [("pnada", "panda"), ("UR5", "ur5"), ("ur_10", "ur10")])
def test_an_unknown_name_gets_the_near_miss(word: str, near: str) -> None:
    """Upper case too."""
    with pytest.raises(InputError, match=f"neither a file nor a known robot, got '{word}'; did you mean '{near}'"):
        load_robot(word)


def test_a_missing_file_is_not_taken_for_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A suffix or a slash means a path."""
    monkeypatch.chdir(tmp_path)
    for word in ("arm.urdf", "./panda", "sub/arm"):
        with pytest.raises(InputError, match="no such file"):
            load_robot(word)
    (tmp_path / "panda").mkdir()
    assert load_robot("panda").source == "panda"


def test_a_file_needs_no_suffix(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What exists is a file, whatever its name; its path is kept absolute."""
    monkeypatch.chdir(arm.parent)
    arm.rename(arm.with_name("mine"))
    assert load_robot("mine").source == arm.with_name("mine")


def test_shipped_robots_are_found_by_their_folder(arm: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """robots/<name>/robot.urdf; as robot names, panda and ur5 stay those of example-robot-data."""
    for name in ("my_scara", "panda"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "robot.urdf").write_text(arm.read_text())
    monkeypatch.setattr(names, "shipped_dir", lambda: tmp_path)
    assert "my_scara" in robot_names()
    assert load_robot("my_scara").joint_names == ("shoulder", "elbow")
    assert load_robot("panda").n == 8


def test_shipped_robots_load_without_example_robot_data(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the data are missing, their names are not offered, and asking for one says how to get them."""
    monkeypatch.setattr(names, "example_data_dir", lambda: None)
    assert "panda" not in robot_names()
    with pytest.raises(InputError, match="pip install example-robot-data"):
        load_robot("panda")
    for entry in shipped_dir().glob("*/robot.urdf"):
        assert load_robot(entry).n > 0
