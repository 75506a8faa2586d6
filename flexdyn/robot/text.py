"""URDF text for Pinocchio's reader, written from checked values.

Pinocchio's reader prints to stderr and fails on features of many published files: commas, tabs, a missing <limit>, an
unknown shape. It never reads the user's text, only this one.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from flexdyn.robot.joints import RobotJoint
from flexdyn.robot.links import MOMENTS, SIZES, Link, Visual


def urdf_text(links: Sequence[Link], joints: Sequence[RobotJoint]) -> str:
    """A whole URDF.

    Limits, damping, friction and mimics are left out: they do not enter the kinematics and are set from the values.

    Args:
        links: links whose meshes are paths on disk.
        joints: joints that make them a tree.

    Returns:
        The text.
    """
    body = "".join(_link(link) for link in links) + "".join(_joint(joint) for joint in joints)
    return f'<robot name="robot">{body}</robot>'


def _link(link: Link) -> str:
    inner = ""
    if link.inertial is not None:
        body = link.inertial
        moments = " ".join(f'{name}="{_numbers([value])}"' for name, value in zip(MOMENTS, body.moments, strict=True))
        mass = f'<mass value="{_numbers([body.mass])}"/><inertia {moments}/>'
        inner = f"<inertial>{_origin(body.xyz, body.rpy)}{mass}</inertial>"
    inner += "".join(_visual(visual) for visual in link.visuals)
    return f"<link name={quoteattr(link.name)}>{inner}</link>"


def _joint(joint: RobotJoint) -> str:
    limit = '<limit lower="0" upper="0" effort="0" velocity="0"/>' if joint.kind != "fixed" else ""
    return (
        f'<joint name={quoteattr(joint.name)} type="{joint.kind}">'
        f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>"
        f'{_origin(joint.xyz, joint.rpy)}<axis xyz="{_numbers(joint.axis)}"/>{limit}</joint>'
    )


def _visual(visual: Visual) -> str:
    """A shape in the URDF's syntax."""
    shape, values = visual.shape, list(visual.size)
    if visual.mesh:
        shape += f" filename={quoteattr(visual.mesh)}"
    for name, count in SIZES[visual.shape]:
        shape += f' {name}="{_numbers(values[:count])}"'
        del values[:count]
    rgba = _numbers(visual.color)
    color = f'<material name="{rgba}"><color rgba="{rgba}"/></material>'
    return f"<visual>{_origin(visual.xyz, visual.rpy)}<geometry><{shape}/></geometry>{color}</visual>"


def _origin(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    return f'<origin xyz="{_numbers(xyz)}" rpy="{_numbers(rpy)}"/>'


def _numbers(values: Sequence[float]) -> str:
    # Pinocchio's reader refuses numbers that underflow.
    return " ".join(repr(value) if abs(value) > 1e-300 else "0" for value in values)
