"""The checked content of a URDF file: links and joints that form one tree."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from flexdyn.errors import InputError, one_line, placed
from flexdyn.robot.graph import check_graph
from flexdyn.robot.joints import RobotJoint, read_joint
from flexdyn.robot.links import Link, read_link
from flexdyn.robot.shapes import read_colors
from flexdyn.robot.values import LONGEST_NAME
from flexdyn.robot.xmlfile import read_xml

MAX_JOINTS = 200
"""Largest number of moving joints, far more than in any arm. Second derivatives of the motion take n^3 numbers."""
MAX_LINKS = 1000
"""Largest number of links, far more than in any arm; readers of URDF are recursive, and thousands exhaust the stack."""


@dataclass(frozen=True)
class Urdf:
    """A whole URDF file whose links and joints form one tree."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[RobotJoint, ...]


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF file.

    Args:
        path: the file.

    Returns:
        Its links and joints, in file order; every number finite, every name known, one tree.

    Raises:
        InputError: one line with file, key, value and remedy; its data have ``line`` if it is known.
    """
    with placed(file=path):
        root = read_xml(path)
        colors = read_colors(root)
        link_elements, joint_elements = root.findall("link"), root.findall("joint")
        if not link_elements:
            raise InputError("the robot has no link", remedy="a URDF needs at least one <link name=...>")
        if len(link_elements) > MAX_LINKS:
            raise InputError(f"{len(link_elements)} links, more than {MAX_LINKS}", remedy="give one arm, not a scene")
        links = tuple(read_link(element, colors) for element in link_elements)
        joints = tuple(read_joint(element) for element in joint_elements)
        moving = sum(joint.kind != "fixed" for joint in joints)
        if moving > MAX_JOINTS:
            raise InputError(f"{moving} joints move, more than {MAX_JOINTS}", remedy="give one arm, or make some fixed")
        check_graph(
            [(link.name, link.line) for link in links],
            [(joint.name, joint.parent, joint.child, joint.line) for joint in joints],
        )
    name = one_line((root.get("name") or "").strip() or path.stem)[:LONGEST_NAME]
    return Urdf(name, links, joints)
