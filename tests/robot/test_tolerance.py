"""Oddities of published URDF files that do no harm are taken in."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flexdyn.robot import load_robot

BODY = (
    '<link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
    '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)
TEXTS = {
    "byte order mark": b"\xef\xbb\xbf<?xml version='1.0'?><robot name='x'>%s</robot>",
    "blank lines before the declaration": b"\n\n<?xml version='1.0'?><robot name='x'>%s</robot>",
    "latin-1": b"<?xml version='1.0' encoding='ISO-8859-1'?><robot name='x'><!-- \xe9 -->%s</robot>",
    "default namespace": b"<robot name='x' xmlns='http://example.org/urdf'>%s</robot>",
    "unused xacro namespace": b"<robot name='x' xmlns:xacro='http://www.ros.org/wiki/xacro'>%s</robot>",
    "undeclared prefix": b"<robot name='x'><sensor:camera/>%s</robot>",
    "doctype in a comment": b"<!-- <!DOCTYPE a> --><robot name='x'>%s</robot>",
    "simulator tags": b"<robot name='x'><gazebo><joint/></gazebo><transmission><joint/></transmission>%s</robot>",
    "instruction": b"<?pi?><robot name='x'>%s</robot>",
}


@pytest.mark.parametrize("case", TEXTS)
def test_harmless_text_is_read(case: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The same arm comes out, quietly."""
    path = tmp_path / "arm.urdf"
    path.write_bytes(TEXTS[case].replace(b"%s", BODY.encode()))
    robot = load_robot(path)
    assert (robot.name, robot.joint_names) == ("x", ("j",))
    assert capfd.readouterr() == ("", "")


def test_a_robot_without_a_name_is_called_after_its_file(tmp_path: Path) -> None:
    """Pinocchio's reader would refuse it."""
    path = tmp_path / "my_arm.urdf"
    path.write_text(f"<robot>{BODY}</robot>")
    assert load_robot(path).name == "my_arm"
    assert load_robot(path, name="other").name == "other"


def test_tabs_and_line_ends_between_numbers(write: Callable[..., Path]) -> None:
    """Numbers may be separated by any blanks, and an axis need not have unit length."""
    robot = load_robot(write(BODY.replace('"0 0 1"', '" 0\t-3\n  4 "')))
    assert np.allclose(robot.tree.axis[0], [0, -0.6, 0.8])


def test_link_and_joint_may_share_a_name(write: Callable[..., Path]) -> None:
    """A frame of that name is the link's."""
    robot = load_robot(write(BODY.replace('"b"', '"j"') + '<link name="c"/>' + fixed("j", "c", "0 0 2")))
    assert np.array_equal(robot.frame("j").translation, np.zeros(3))
    assert np.array_equal(robot.frame("c").translation, [0, 0, 2])
    assert robot.frame("c").joint == 0


def fixed(parent: str, child: str, xyz: str) -> str:
    """A fixed joint."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="fix_{child}" type="fixed">{ends}<origin xyz="{xyz}"/></joint>'


def test_a_tiny_rounded_inertia_on_a_larger_body_passes(write: Callable[..., Path]) -> None:
    """Links welded together count as one body: a published antenna of 1e-8 kg m^2 below zero does no harm."""
    inertia = '<inertial><mass value="{0}"/><inertia ixx="{1}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/></inertial>'
    heavy = BODY.replace('<link name="b"/>', f'<link name="b">{inertia.format(1, 1)}</link>')
    tip = f'<link name="c">{inertia.format(1e-7, -3e-8)}</link>' + fixed("b", "c", "0 0 1")
    assert load_robot(write(heavy + tip)).tree.mass[0] == pytest.approx(1 + 1e-7)


def test_mimics_of_joints_that_do_not_move(write: Callable[..., Path]) -> None:
    """A follower of a fixed joint, or with multiplier 0, stays at its offset; a fixed joint that mimics is fixed."""
    text = BODY + '<link name="c"/><link name="d"/><link name="e"/>' + fixed("b", "c", "0 0 0")
    follow = '<joint name="{}" type="{}"><parent link="c"/><child link="{}"/><axis xyz="1 0 0"/>{}</joint>'
    text += follow.format("f", "prismatic", "d", '<mimic joint="fix_c" offset="0.25"/>')
    text += follow.format("g", "prismatic", "e", '<mimic joint="j" multiplier="0" offset="0.5"/>')
    robot = load_robot(write(text.replace('<origin xyz="0 0 0"/>', '<mimic joint="j"/>')))
    assert robot.joint_names == ("j",)
    assert not robot.followers
    assert np.allclose(robot.frame("d").translation, [0.25, 0, 0])
    assert np.allclose(robot.frame("e").translation, [0.5, 0, 0])


def test_numbers_that_underflow(write: Callable[..., Path], capfd: pytest.CaptureFixture[str]) -> None:
    """1e-320 is zero, not a parser's failure."""
    robot = load_robot(write(BODY + '<link name="c"/>' + fixed("b", "c", "1e-320 0 1e-310")))
    assert np.array_equal(robot.frame("c").translation, np.zeros(3))
    assert capfd.readouterr() == ("", "")
