"""Small URDF files to load, and a model rebuilt from a Tree's arrays by the textbook."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.robot import Tree

LIMIT = '<limit lower="-2" upper="2.5" effort="30" velocity="4"/>'


def link(name: str, scale: float = 1.0, extra: str = "") -> str:
    """A link with a lopsided, physically possible inertia."""
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 {0.02 * scale} -0.03" rpy="0.3 0.2 {0.1 * scale}"/>'
        f'<mass value="{1.5 * scale}"/><inertia ixx="{0.02 * scale}" ixy="0.001" ixz="-0.002" iyy="{0.03 * scale}"'
        f' iyz="0.0015" izz="{0.025 * scale}"/></inertial>{extra}</link>'
    )


def joint(name: str, kind: str, parent: str, child: str, axis: str = "0 0 1", extra: str = LIMIT) -> str:
    """A joint placed off its parent's origin and axes."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.2 -0.1 0.3" rpy="0.4 -0.2 0.1"/><axis xyz="{axis}"/>{extra}</joint>'
    )


ZOO = "".join(
    [
        *(link(name, 1.0 + 0.3 * k) for k, name in enumerate(("base", "a", "b", "plate", "c", "d", "e", "f"))),
        joint("turn", "continuous", "base", "a", "0 0.6 0.8", '<dynamics damping="0.3" friction="0.2"/>'),
        joint("elbow", "revolute", "a", "b", "0 1 0", LIMIT + '<dynamics damping="0.1" friction="0.4"/>'),
        joint("weld", "fixed", "b", "plate", extra=""),
        joint("slide", "prismatic", "plate", "c", "1 2 -2"),
        joint("spin", "continuous", "c", "d", "0 0 1", ""),
        joint(
            "side", "revolute", "plate", "e", "0 0 -3",
            LIMIT + '<mimic joint="elbow" multiplier="-1.5" offset="0.2"/><dynamics damping="0.5" friction="0.6"/>',
        ),
        joint("far", "prismatic", "e", "f", "1 0 0", LIMIT + '<mimic joint="side" multiplier="0.1" offset="-0.05"/>'),
    ]
)  # fmt: skip
"""Every kind of joint that flexdyn knows, with a branch and a chain of mimics."""


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write the inside of a <robot> to a file."""

    def _write(inside: str, name: str = "arm") -> Path:
        path = tmp_path / f"{name}.urdf"
        path.write_text(f'<?xml version="1.0"?>\n<robot name="{name}">{inside}</robot>', encoding="utf-8")
        return path

    return _write


@pytest.fixture
def zoo(write: Callable[..., Path]) -> Path:
    """A robot with every kind of joint."""
    return write(ZOO, "zoo")


@pytest.fixture
def arm(write: Callable[..., Path]) -> Path:
    """A serial arm of two revolute joints."""
    inside = link("base") + link("upper") + link("fore", 0.7) + '<link name="tool"/>'
    inside += joint("shoulder", "revolute", "base", "upper") + joint("elbow", "revolute", "upper", "fore", "0 1 0")
    return write(inside + joint("mount", "fixed", "fore", "tool", extra=""))


@pytest.fixture
def rebuild() -> Callable[[Tree], pin.Model]:
    """A Pinocchio model built from nothing but the arrays of a Tree."""

    def _rebuild(tree: Tree) -> pin.Model:
        model = pin.Model()
        for j in range(tree.m):
            make = pin.JointModelPrismaticUnaligned if tree.prismatic[j] else pin.JointModelRevoluteUnaligned
            placement = pin.SE3(tree.rotation[j], tree.translation[j])
            index = model.addJoint(int(tree.parent[j]) + 1, make(np.array(tree.axis[j])), placement, f"j{j}")
            body = pin.Inertia(float(tree.mass[j]), np.array(tree.com[j]), np.array(tree.inertia[j]))
            model.appendBodyToJoint(index, body, pin.SE3.Identity())
        model.armature = np.array(tree.armature)
        return model

    return _rebuild


@pytest.fixture
def text() -> Callable[..., str]:
    """Pieces of URDF: "link" with a name, or "joint" with name, kind, parent, child, axis and what else it holds."""

    def _text(what: str, *values: str) -> str:
        return link(values[0]) if what == "link" else joint(*values)

    return _text
