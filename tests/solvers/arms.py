"""Arms that the solver tests move: rods on elastic joints, and identical rods side by side."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect
from flexdyn.simulation.solvers import DormandPrince, Solver, TimeStepping
from tests.arms import ROD

Array = NDArray[np.float64]
NAMES = ("shoulder", "elbow")
STICKING: tuple[Solver, ...] = (DormandPrince(), TimeStepping(step=1e-3), TimeStepping(step=1e-2))
"""The solvers that promise that what sticks does not move."""


def planar(
    stiffness: float,
    effects: Iterable[Effect] = (),
    *,
    joints: int = 1,
    damping: float = 0.0,
    rotor: float = 0.1,
    gravity: float = 0.0,
) -> fd.FlexibleJointModel:
    """The paper's two rods, all joints alike; with one joint the elbow is locked straight."""
    robot = fd.load_robot("scara_two_link", lock={} if joints == 2 else {"elbow": 0.0})
    drives = {name: {"rotor_inertia": rotor, "stiffness": stiffness, "damping": damping} for name in NAMES[:joints]}
    return fd.FlexibleJointModel(robot, drives, effects, gravity=[0.0, -gravity, 0.0])


def coulomb(side: Any, *levels: float) -> list[Effect]:
    """Coulomb friction on one side of the joints, in their order."""
    return [CoulombFriction(name, side=side, level=level) for name, level in zip(NAMES, levels, strict=False)]


def side_by_side(folder: Path, count: int) -> fd.Robot:
    """Identical rods, each on a joint of its own at the base: a branched robot whose joints do not feel each other."""
    path = folder / f"comb{count}.urdf"
    links = "".join(f'<link name="l{k}">{ROD}</link>' for k in range(count))
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="base"/><child link="l{k}"/>'
        f'<origin xyz="0 0 {k}"/><axis xyz="0 0 1"/></joint>'
        for k in range(count)
    )
    path.write_text(f'<robot name="comb"><link name="base"/>{links}{joints}</robot>', encoding="utf-8")
    return fd.load_robot(path)


def label(value: object) -> str:
    """Parameters of a test as a short name."""
    if isinstance(value, TimeStepping):
        return f"TimeStepping{value.step:g}"
    if isinstance(value, Solver):
        return type(value).__name__
    return "+".join(map(str, value)) if isinstance(value, tuple) else str(value)


def positions(run: fd.Run) -> Array:
    """[q, theta] at every sample."""
    return np.hstack([run.q, run.theta])
