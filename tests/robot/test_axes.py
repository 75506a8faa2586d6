"""Axes of coupled drives: names, positions, what does not fit, and files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import repickled

WRIST = {"left": {"pitch": 1.0, "roll": 1.0}, "right": {"pitch": 1.0, "roll": -1.0}}
BODY = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="10" velocity="5"/>{more}</joint>'
)


def arm(folder: Path, *, roll: str = "revolute", more: str = "") -> fd.Robot:
    """A base joint, pitch and roll, one after the other."""
    names, kinds = ("base", "pitch", "roll"), ("revolute", "revolute", roll)
    links = "".join(f'<link name="l{k}">{BODY if k else ""}</link>' for k in range(4))
    joints = "".join(
        JOINT.format(name=name, kind=kind, parent=f"l{k}", child=f"l{k + 1}", more=more if name == "roll" else "")
        for k, (name, kind) in enumerate(zip(names, kinds, strict=True))
    )
    path = folder / "wrist.urdf"
    path.write_text(f'<robot name="wrist">{links}{joints}</robot>', encoding="utf-8")
    return fd.load_robot(path)


def test_axes_stand_where_their_joints_stood(tmp_path: Path) -> None:
    """Names, kinds and, by p = A q, the joints' positions again; limits of joints bound no box in the axes."""
    wrist = arm(tmp_path).with_axes(WRIST)
    assert wrist.joint_names == ("base", "left", "right")
    assert wrist.kinds == ("revolute",) * 3
    assert wrist.expand([0.3, 0.5, 0.1]) == pytest.approx([0.3, 0.3, 0.2], abs=1e-15)
    assert (wrist.lower[0], wrist.upper[0], wrist.effort_limit[0]) == (-1.0, 1.0, 10.0)
    assert np.isinf([wrist.lower[1], wrist.upper[2], wrist.effort_limit[1], wrist.velocity_limit[2]]).all()
    again = repickled(wrist)
    assert again.axes == wrist.axes
    assert np.array_equal(again.expand([0.3, 0.5, 0.1]), wrist.expand([0.3, 0.5, 0.1]))


def test_a_screw_and_a_slide_make_turning_axes(tmp_path: Path) -> None:
    """A ball-screw spline: two motors turn and lift one shaft; the coefficient of the slide is in rad/m."""
    shaft = {"nut": {"pitch": 1.0, "roll": 400.0}, "spline": {"pitch": 1.0}}
    spline = arm(tmp_path, roll="prismatic").with_axes(shaft)
    assert spline.kinds == ("revolute",) * 3
    assert spline.expand([0.0, 2.0, 1.6]) == pytest.approx([0.0, 1.6, 1e-3], abs=1e-15)
    assert arm(tmp_path, roll="prismatic").with_axes({"lift": {"roll": -2.0}}).kinds[2] == "prismatic"


def test_a_model_file_holds_them(tmp_path: Path) -> None:
    """Written and read again; the joints are named by the axes."""
    drives = {"left": {"gear_ratio": -50.0, "rotor_inertia": 1e-4, "stiffness": 500.0}}
    wrist = arm(tmp_path).with_axes(WRIST)
    model = fd.FlexibleJointModel(wrist, drives, initial={"q": {"right": 0.2}}, gravity=[0.0, 0.0, 0.0])
    fd.save_model(model, tmp_path / "model.yaml")
    again = fd.load_model(tmp_path / "model.yaml").replace(name=model.name)
    assert again == model
    assert again.robot.axes == WRIST
    assert again != model.replace(robot=arm(tmp_path).with_axes({**WRIST, "left": {"pitch": 2.0, "roll": 1.0}}))


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        (5, "robot.axes: axes are a mapping by name, got 5; write {left:"),
        ({"left": 5}, "robot.axes.left: an axis is a mapping of its joints"),
        ({"left": {}}, "robot.axes.left: an axis is a mapping of its joints"),
        ({"left": {"pich": 1.0}}, "robot.axes.left.pich: the robot has no such joint; did you mean 'pitch'?"),
        ({"left": {"pitch": "1"}}, "robot.axes.left.pitch: a finite number is needed, got '1'"),
        ({"left": {"pitch": np.nan}}, "robot.axes.left.pitch: a finite number is needed"),
        ({"left": {"pitch": 1.0, "roll": 1.0}}, "robot.axes: the matrix of the axes is not square, got '1 axes of 2"),
        (
            {"a": {"pitch": 1.0, "roll": 1.0}, "b": {"pitch": 2.0, "roll": 2.0}},
            "robot.axes: the matrix of the axes has",
        ),
        ({"base": {"pitch": 1.0}}, "robot.axes: the name is taken or no name, got 'base'"),
        ({"a.b": {"pitch": 1.0}}, "robot.axes: the name is taken or no name, got 'a.b'"),
    ],
)
def test_axes_that_do_not_fit_are_refused(tmp_path: Path, axes: Any, words: str) -> None:
    """One line with the key and the remedy, in Python and in a file."""
    with pytest.raises(fd.InputError) as caught:
        arm(tmp_path).with_axes(axes)
    assert str(caught.value).startswith(words)


def test_a_file_with_wrong_axes_is_named(tmp_path: Path) -> None:
    """File and key stand first."""
    arm(tmp_path)
    (tmp_path / "model.yaml").write_text("flexdyn: 1\nrobot: {urdf: wrist.urdf, axes: {left: {pich: 1.0}}}\n")
    with pytest.raises(fd.InputError, match=r"model.yaml: robot.axes.left.pich: the robot has no such joint"):
        fd.load_model(tmp_path / "model.yaml")


def test_joints_that_axes_move_have_no_drive_of_their_own(tmp_path: Path) -> None:
    """The line says which axes move them."""
    wrist = arm(tmp_path).with_axes(WRIST)
    with pytest.raises(fd.InputError, match="acts on axes, got 'roll'; name an axis that moves it, left and right"):
        fd.FlexibleJointModel(wrist, effects=[fd.effects.CoulombFriction("roll", side="link", level=1.0)])
    with pytest.raises(fd.InputError, match="the robot has axes already"):
        wrist.with_axes({"base": {"base": 1.0}})
    with pytest.raises(fd.InputError, match=r"robot.rotor_coupling: no rotor coupling with axes"):
        fd.FlexibleJointModel(wrist, rotor_coupling="full")


def test_friction_of_the_urdf_in_coupled_joints_is_not_lost(tmp_path: Path) -> None:
    """It acts on several axes at once: refused, unless it is to be ignored."""
    rough = arm(tmp_path, more='<dynamics damping="0.1"/>')
    with pytest.raises(
        fd.InputError, match=r"<dynamics> of roll acts on several axes; set robot.urdf_dynamics: ignore"
    ):
        rough.with_axes(WRIST)
    assert not rough.with_axes(WRIST, ignore_dynamics=True).damping.any()
    text = f"flexdyn: 1\nrobot: {{urdf: wrist.urdf, urdf_dynamics: ignore, axes: {WRIST}}}\n"
    (tmp_path / "model.yaml").write_text(text.replace("'", ""))
    assert fd.load_model(tmp_path / "model.yaml").joint_names == ("base", "left", "right")
