"""A URDF file with corrected numbers of its links and joints; everything else stays as it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flexdyn.errors import InputError
from flexdyn.io.files import relative
from flexdyn.robot.joints import read_joint
from flexdyn.robot.links import MOMENTS, Inertial, read_colors, read_link
from flexdyn.robot.meshes import mesh_path
from flexdyn.robot.names import find_robot
from flexdyn.robot.robot import Robot
from flexdyn.robot.xmlfile import read_xml, xml_text

Factors = Mapping[str, Mapping[str, float]]


def corrected_urdf(robot: Robot, links: Factors, joints: Factors, folder: Path) -> str:
    """Text of the robot's URDF with some of its numbers multiplied.

    Args:
        robot: loaded from a URDF, or known by name.
        links: factors of ``mass``, ``com``, ``inertia`` by link.
        joints: factors of ``damping``, ``friction`` of <dynamics> by joint; they also apply to joints that mimic it.
        folder: in which the text will be saved: meshes are named relative to it.

    Raises:
        InputError: the robot has no URDF, or the file does not exist any more.
    """
    if robot.source is None:
        raise InputError("the robot has no URDF", key="robot", remedy="load it from one")
    path, _ = find_robot(robot.source)
    root = read_xml(path)
    colors = read_colors(root)
    for element in root.findall("link"):
        link = read_link(element, colors)
        if link.name in links and link.inertial is not None:
            _correct_link(element.find("inertial"), link.inertial, links[link.name])
    for element in root.findall("joint"):
        joint = read_joint(element)
        leader = robot.followers[joint.name][0] if joint.name in robot.followers else joint.name
        for attribute, factor in joints.get(leader, {}).items():
            given = element.find("dynamics")
            if given is not None and given.get(attribute) is not None:
                given.set(attribute, repr(factor * getattr(joint, attribute)))
    _move_meshes(root, path, robot.package_dirs, folder)
    return xml_text(root)


def _correct_link(element: Any, given: Inertial, factors: Mapping[str, float]) -> None:
    true = given.scaled(*(factors.get(name, 1.0) for name in ("mass", "com", "inertia")))
    element.find("mass").set("value", repr(true.mass))
    for name, moment in zip(MOMENTS, true.moments, strict=True):
        element.find("inertia").set(name, repr(moment))
    if element.find("origin") is not None:
        element.find("origin").set("xyz", " ".join(map(repr, true.xyz)))


def _move_meshes(root: Any, urdf: Path, package_dirs: Sequence[Path], folder: Path) -> None:
    """Convert addresses relative to the old file's folder to addresses relative to the new one."""
    for mesh in root.iter("mesh"):
        found = mesh_path(mesh.get("filename") or "", urdf, package_dirs)
        if found is not None:
            mesh.set("filename", relative(found, folder))
