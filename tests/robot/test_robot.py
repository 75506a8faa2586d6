"""What a Robot tells about its joints and frames, and that nobody can change it."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.errors import InputError
from flexdyn.robot import load_robot


def test_joints_limits_and_units(zoo: Path) -> None:
    """Names, kinds, limits and units by independent joint; a continuous joint has no limit."""
    robot = load_robot(zoo)
    assert (robot.name, robot.source, robot.n) == ("zoo", zoo, 4)
    assert robot.kinds == ("revolute", "revolute", "prismatic", "revolute")
    assert robot.continuous == (True, False, False, True)
    assert np.array_equal(robot.lower, [-np.inf, -2, -2, -np.inf])
    assert np.array_equal(robot.upper, [np.inf, 2.5, 2.5, np.inf])
    assert np.array_equal(robot.velocity_limit, [np.inf, 4, 4, np.inf])
    assert np.array_equal(robot.effort_limit, [np.inf, 30, 30, np.inf])
    assert [robot.angle_unit(name) for name in robot.joint_names] == ["rad", "rad", "m", "rad"]
    assert [robot.torque_unit(j) for j in range(4)] == ["N m", "N m", "N", "N m"]


def test_friction_of_followers_reaches_their_leader(zoo: Path) -> None:
    """Power balance: a follower at G times the speed loses G^2 d v^2 and |G| f |v|."""
    robot = load_robot(zoo)
    assert np.allclose(robot.damping, [0.3, 0.1 + 1.5**2 * 0.5, 0, 0])
    assert np.allclose(robot.friction, [0.2, 0.4 + 1.5 * 0.6, 0, 0])


def test_limits_that_a_file_leaves_out_are_none(write: Callable[..., Path], text: Callable[..., str]) -> None:
    """No <limit>, a <limit> without a range: unlimited; half a range ends at 0, as URDF says."""
    inside = "".join(text("link", name) for name in "abcd")
    inside += text("joint", "one", "revolute", "a", "b", "0 0 1", "")
    inside += text("joint", "two", "revolute", "b", "c", "0 0 1", '<limit effort="3" velocity="inf"/>')
    inside += text("joint", "three", "prismatic", "c", "d", "0 0 1", '<limit upper="0.4" effort="3" velocity="2"/>')
    robot = load_robot(write(inside))
    assert np.array_equal(robot.lower, [-np.inf, -np.inf, 0.0])
    assert np.array_equal(robot.upper, [np.inf, np.inf, 0.4])
    assert np.array_equal(robot.velocity_limit, [np.inf, np.inf, 2.0])
    assert robot.continuous == (False, False, False)


def test_tip_is_the_last_link_of_a_chain_and_none_of_a_branched_arm(arm: Path, zoo: Path) -> None:
    """A serial arm has one end, fixed links included; a branched one asks for a frame and names some."""
    assert load_robot(arm).tip == "tool"
    with pytest.raises(InputError, match=r"branched.*'f', 'd'"):
        _ = load_robot(zoo).tip
    with pytest.raises(InputError, match=r"branched.*'panda_leftfinger', 'panda_rightfinger'"):
        _ = load_robot("panda").tip


def test_frames_are_placed_as_pinocchio_places_them(zoo: Path) -> None:
    """Joint placement times frame placement gives the pose of every link; unknown frames get a near miss."""
    robot = load_robot(zoo, lock={"slide": 0.3})
    model = pin.buildModelFromUrdf(str(zoo))
    made, reduced = model.createData(), robot.pin_model
    data = reduced.createData()
    state = pin.neutral(model)
    state[model.idx_qs[model.getJointId("slide")]] = 0.3
    still = {"side": 0.2, "far": -0.03}
    for name, value in still.items():
        state[model.idx_qs[model.getJointId(name)]] = value
    pin.framesForwardKinematics(model, made, state)
    pin.forwardKinematics(reduced, data, robot.expand(np.zeros(robot.n)))
    for name in ("base", "a", "plate", "c", "d", "f"):
        frame = robot.frame(name)
        pose = data.oMi[frame.joint + 1] * pin.SE3(frame.rotation, frame.translation)
        expected = made.oMf[model.getFrameId(name, pin.FrameType.BODY)]
        assert np.allclose(pose.homogeneous, expected.homogeneous, atol=1e-12), name
    assert robot.frame("base").joint == -1
    with pytest.raises(InputError, match="did you mean 'plate'"):
        robot.frame("plat")


def test_a_payload_on_the_base_or_of_negative_mass_is_refused(arm: Path) -> None:
    """Neither can be meant."""
    robot = load_robot(arm)
    with pytest.raises(InputError, match="base"):
        robot.tree.with_point_mass(robot.frame("base"), 1.0)
    for mass in (-1.0, float("nan")):
        with pytest.raises(InputError, match="mass"):
            robot.tree.with_point_mass(robot.frame("tool"), mass)


def test_wrong_names_and_shapes_are_told(zoo: Path) -> None:
    """Joints by name with a near miss, followers with their leader, positions by their number."""
    robot = load_robot(zoo)
    with pytest.raises(InputError, match="did you mean 'elbow'"):
        robot.joint_index("elbwo")
    with pytest.raises(InputError, match="name its leader 'elbow'"):
        robot.joint_index("far")
    with pytest.raises(InputError, match="from 0 to 3"):
        robot.joint_index(4)
    with pytest.raises(InputError, match="turn, elbow, slide, spin"):
        robot.expand(np.zeros(6))


def test_a_robot_cannot_be_changed(zoo: Path) -> None:
    """Attributes, arrays, tables and the Pinocchio model handed out are no way in."""
    robot = load_robot(zoo, lock={"slide": 0.1})
    with pytest.raises(dataclasses.FrozenInstanceError):
        robot.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        robot.lock["spin"] = 0.0  # type: ignore[index]
    for holder in (robot, robot.tree, robot.frame("f")):
        for field in dataclasses.fields(holder):
            value = getattr(holder, field.name)
            if isinstance(value, np.ndarray):
                assert not value.flags.writeable, field.name
    robot.pin_model.armature = np.ones(robot.tree.m)
    assert not robot.pin_model.armature.any()


def test_a_robot_pickles_whole_and_stays_locked(zoo: Path) -> None:
    """Every field survives, arrays bit for bit and still locked, and so does the Pinocchio model."""
    robot = load_robot(zoo, lock={"slide": 0.1})
    again = pickle.loads(pickle.dumps(robot))  # noqa: S301
    assert again.pin_model == robot.pin_model
    assert dict(again.followers) == dict(robot.followers)
    for holder, copy in ((robot, again), (robot.tree, again.tree)):
        for field in dataclasses.fields(holder):
            value, other = getattr(holder, field.name), getattr(copy, field.name)
            if isinstance(value, np.ndarray):
                assert np.array_equal(value, other)
                assert not other.flags.writeable
            elif field.name not in ("tree", "_model"):
                assert value == other, field.name
    assert again.frame_names == robot.frame_names


def test_each_joint_is_carried_by_the_next_one_towards_the_base(zoo: Path) -> None:
    """By one that moves by itself: joints that follow others are passed over, as in Pinocchio's list of parents."""
    robot = load_robot(zoo)
    model = pin.buildModelFromUrdf(str(zoo))
    for j, name in enumerate(robot.joint_names):
        index = model.parents[model.getJointId(name)]
        while index and model.names[index] not in robot.joint_names:
            index = model.parents[index]
        expected = robot.joint_names.index(model.names[index]) if index else None
        assert robot.tree.carrier(j) == expected
