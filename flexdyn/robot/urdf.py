"""The checked content of a URDF file: links and joints that form one tree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from flexdyn.errors import InputError, did_you_mean, listed, one_line, placed
from flexdyn.robot.joints import RobotJoint, read_joint
from flexdyn.robot.links import Link, read_colors, read_link
from flexdyn.robot.values import LONGEST_NAME, fail
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
        _check_graph(links, joints)
    name = one_line((root.get("name") or "").strip() or path.stem)[:LONGEST_NAME]
    return Urdf(name, links, joints)


def _check_graph(links: Sequence[Link], joints: Sequence[RobotJoint]) -> None:
    """Refuse links and joints that are not one tree; the error names those at fault."""
    _refuse_repeats("link", links)
    _refuse_repeats("joint", joints)
    declared = {link.name for link in links}
    parent_joint: dict[str, RobotJoint] = {}
    for joint in joints:
        name, parent, child = joint.name, joint.parent, joint.child
        for end, link in (("parent", parent), ("child", child)):
            if link not in declared:
                problem, remedy = f"link '{link}' is not declared", _declare(link, declared)
                raise fail(joint, f"joint '{name}'/{end}", problem, remedy=remedy)
        if parent == child:
            raise fail(joint, f"joint '{name}'", f"joins link '{child}' to itself", remedy="give it another parent")
        if child in parent_joint:
            other = parent_joint[child].name
            remedy = "flexdyn models trees; remove one of the two joints"
            raise fail(joint, f"link '{child}'", f"has two parents, by joints '{other}' and '{name}'", remedy=remedy)
        parent_joint[child] = joint
    _refuse_loops(links, parent_joint)
    roots = [link.name for link in links if link.name not in parent_joint]
    if len(roots) > 1:
        remedy = "join them to one tree by fixed joints, or remove the links that no joint connects"
        shown = listed((f"'{name}'" for name in roots), 5)
        raise InputError(f"{len(roots)} root links: {shown}", key="link", remedy=remedy)


def _refuse_repeats(what: str, named: Sequence[Link | RobotJoint]) -> None:
    first: dict[str, int | None] = {}
    for each in named:
        if each.name in first:
            problem = f"the name is used twice, first in line {first[each.name]}"
            raise fail(each, f"{what} '{each.name}'", problem, remedy="rename one")
        first[each.name] = each.sourceline


def _refuse_loops(links: Sequence[Link], parent_joint: dict[str, RobotJoint]) -> None:
    """Find loops: the path from a link to its parents must end at a root; a link met twice is in a loop."""
    sound: set[str] = set()
    for start in links:
        path: list[str] = []
        link = start.name
        while link not in sound and link in parent_joint:
            if link in path:
                loop = [*path[path.index(link) :], link]
                # Ring order is child to parent; the reader expects parent to child.
                round_trip = " -> ".join(reversed(loop[-6:]))
                remedy = "flexdyn models trees; cut the loop at one joint"
                raise fail(parent_joint[link], f"link '{link}'", f"the links form a loop: {round_trip}", remedy=remedy)
            path.append(link)
            link = parent_joint[link].parent
        sound.update(path)


def _declare(link: str, declared: set[str]) -> str:
    near = did_you_mean(link, declared)
    return near if near.startswith("did you mean") else f'add <link name="{link}"/>'
