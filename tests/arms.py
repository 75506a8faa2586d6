"""Small arms that several test files move."""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import base
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
T = TypeVar("T")
E = TypeVar("E", bound=fd.effects.Effect)
EXACT = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13)
ROD = (
    '<inertial><origin xyz="0.525 0 0"/><mass value="0.42525"/><inertia ixx="1e-6" ixy="0" ixz="0"'
    ' iyy="0.03906984375" iyz="0" izz="0.03906984375"/></inertial>'
)
SLIDER = """<robot name="slider"><link name="base"/>
<link name="mass"><inertial><mass value="2.5"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="mass"/><axis xyz="0 0 1"/>
<limit lower="-100" upper="100" effort="1000" velocity="100"/></joint></robot>"""


def unlisted(kind: type[E]) -> type[E]:
    """An effect class, out of the catalogue again: other tests count what is in there."""
    del base._registry[kind.name]
    return kind


def repickled(value: T) -> T:
    """The value after a trip to another process."""
    again: T = pickle.loads(pickle.dumps(value))  # noqa: S301
    return again


def two_link(
    arm: TwoLink, effects: Iterable[fd.effects.Effect | Mapping[str, Any]] = (), **settings: Any
) -> fd.FlexibleJointModel:
    """Flexdyn's model of the oracle's arm; its friction, actuator and tip mass beyond 0.1 kg come as effects."""
    joints = {
        name: {"rotor_inertia": arm.rotor[j], "stiffness": arm.stiffness[j], "damping": arm.damping[j]}
        for j, name in enumerate(("shoulder", "elbow"))
    }
    robot = fd.load_robot("scara_two_link")
    return fd.FlexibleJointModel(robot, joints, effects, gravity=[0.0, -arm.gravity, 0.0], **settings)


def coupled(folder: Path, multiplier: float, offset: float) -> fd.Robot:
    """The same two rods, without load, the elbow driven by the shoulder: q2 = multiplier q1 + offset."""
    path = folder / "coupled.urdf"
    path.write_text(
        '<robot name="coupled"><link name="base"/>'
        f'<link name="a">{ROD}</link><link name="b">{ROD}</link>'
        '<joint name="lead" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>'
        '<joint name="follow" type="continuous"><parent link="a"/><child link="b"/><origin xyz="1.05 0 0"/>'
        f'<axis xyz="0 0 1"/><mimic joint="lead" multiplier="{multiplier}" offset="{offset}"/></joint></robot>',
        encoding="utf-8",
    )
    return fd.load_robot(path)


def slider(folder: Path) -> fd.Robot:
    """A mass of 2.5 kg on a vertical prismatic joint."""
    path = folder / "slider.urdf"
    path.write_text(SLIDER, encoding="utf-8")
    return fd.load_robot(path)


def state(run: fd.Run) -> Array:
    """The run's states [q, theta, v, omega], rotor columns of elastic joints alone, as the oracles order them."""
    elastic = run.model.elastic
    return np.hstack([run.q, run.theta[:, elastic], run.v, run.omega[:, elastic]])


BENT: dict[str, Any] = {"q0": [0.0, math.pi / 2], "v0": [0.4, -0.3]}
"""A first state in which nothing is zero by symmetry."""
