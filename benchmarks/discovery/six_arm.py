"""A six-joint arm like the UR5: links of the public URDF, joints with the nominal numbers of robots/ur5/model.yaml.

A tool of 2 kg is bolted on, as in use: without one the last link would swing at hundreds of hertz.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from layout import Array

URDF = "share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
TOOL_AT, TOOL_COM, TOOL_INERTIA, TOOL_MASS = (0.0, 0.0823, 0.0), (0.02, 0.06, 0.0), 0.008, 2.0
MIDDLE = (0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0)
GEAR_RATIO = (100.0,) * 6
ROTOR_INERTIA = (1.7e-4, 1.7e-4, 1.7e-4, 2.7e-5, 2.7e-5, 2.7e-5)  # kg m^2, motor side
STIFFNESS = (2.5e4, 2.5e4, 2.5e4, 3.4e3, 3.4e3, 3.4e3)  # N m/rad
DAMPING = (16.0, 26.0, 15.0, 2.9, 2.9, 0.76)  # N m s/rad
VISCOUS = (4.75, 10.73, 3.82, 2.95, 1.14, 1.88)  # N m s/rad
COULOMB = (6.7, 6.7, 6.7, 1.25, 1.25, 1.25)  # N m


@dataclass(frozen=True, eq=False)
class SixArm:
    """The numbers of the arm, joint by joint, SI units; gear_ratio and rotor_inertia on the motor side."""

    joints: tuple[str, ...]
    names: tuple[str, ...]
    translation: Array
    rotation: Array
    axis: Array
    mass: tuple[float, ...]
    com: Array
    inertia: Array
    tool: float = TOOL_MASS
    gear_ratio: tuple[float, ...] = GEAR_RATIO
    rotor_inertia: tuple[float, ...] = ROTOR_INERTIA
    stiffness: tuple[float, ...] = STIFFNESS
    damping: tuple[float, ...] = DAMPING
    viscous: tuple[float, ...] = VISCOUS
    coulomb: tuple[float, ...] = COULOMB

    def rotor(self) -> Array:
        """Rotor inertias, reflected (6,) [kg m^2]."""
        return np.asarray(np.array(self.gear_ratio) ** 2 * np.array(self.rotor_inertia))

    def replace(self, **changes: Any) -> SixArm:
        """This arm with other numbers."""
        return dataclasses.replace(self, **changes)

    def pinocchio(self) -> Any:
        """The links for Pinocchio, rotors left out."""
        model = pin.Model()
        for j in range(6):
            placement = pin.SE3(self.rotation[j], self.translation[j])
            kind = pin.JointModelRevoluteUnaligned(self.axis[j])
            joint = model.addJoint(j, kind, placement, self.joints[j])
            model.appendBodyToJoint(joint, pin.Inertia(self.mass[j], self.com[j], self.inertia[j]), pin.SE3.Identity())
        tool = pin.Inertia(self.tool, np.array(TOOL_COM), TOOL_INERTIA * np.eye(3))
        model.appendBodyToJoint(6, tool, pin.SE3(np.eye(3), np.array(TOOL_AT)))
        return model


def nominal() -> SixArm:
    """The arm as its makers wrote it down."""
    prefix = next(parent for parent in Path(pin.__file__).parents if parent.name == "cmeel.prefix")
    model = pin.buildModelFromUrdf(str(prefix / URDF))
    axes = {"RX": [1.0, 0, 0], "RY": [0, 1.0, 0], "RZ": [0, 0, 1.0]}
    return SixArm(
        joints=tuple(model.names[1:]),
        names=tuple(name.replace("_joint", "_link") for name in model.names[1:]),
        translation=np.array([model.jointPlacements[j].translation for j in range(1, 7)]),
        rotation=np.array([model.jointPlacements[j].rotation for j in range(1, 7)]),
        axis=np.array([axes[model.joints[j].shortname()[-2:]] for j in range(1, 7)]),
        mass=tuple(float(model.inertias[j].mass) for j in range(1, 7)),
        com=np.array([model.inertias[j].lever for j in range(1, 7)]),
        inertia=np.array([model.inertias[j].inertia for j in range(1, 7)]),
    )


def varied(arm: SixArm, rng: np.random.Generator, error: float, mass_error: float) -> SixArm:
    """Every number but lengths and gear ratios off by up to so much, uniform."""

    def off(by: float) -> Array:
        return 1.0 + by * rng.uniform(-1.0, 1.0, 6)

    names = ("rotor_inertia", "stiffness", "damping", "viscous", "coulomb")
    changed = {name: figures(np.array(getattr(arm, name)) * off(error)) for name in names}
    return arm.replace(
        **changed,
        mass=figures(np.array(arm.mass) * off(mass_error)),
        tool=float(arm.tool * (1.0 + mass_error * rng.uniform(-1.0, 1.0))),
        com=arm.com * off(error)[:, None],
        inertia=arm.inertia * off(error)[:, None, None],
    )


def figures(values: Array) -> tuple[float, ...]:
    """Seven figures each."""
    return tuple(float(f"{value:.7g}") for value in values)


def model_yaml(arm: SixArm, tolerance: float | Mapping[str, float]) -> str:
    """The model file; tolerance: of all numbers, or by their paths."""
    lines = ["flexdyn: 1", "robot:", "  urdf: arm.urdf", "  gravity: [0.0, 0.0, -9.81]", "joints:"]
    for j, joint in enumerate(arm.joints):
        stiffness = ".inf" if np.isinf(arm.stiffness[j]) else repr(arm.stiffness[j])
        lines += [f"  {joint}:", f"    gear_ratio: {arm.gear_ratio[j]!r}"]
        lines += [f"    rotor_inertia: {arm.rotor_inertia[j]!r}", f"    stiffness: {stiffness}"]
        lines += [f"    damping: {arm.damping[j]!r}"]
    lines += ["initial:", "  q:", *(f"    {joint}: {q!r}" for joint, q in zip(arm.joints, MIDDLE, strict=True))]
    lines.append(f"tolerance: {tolerance!r}")
    lines.append("effects:" if any((*arm.viscous, *arm.coulomb)) else "effects: []")
    for name, parameter, values in (("viscous", "coefficient", arm.viscous), ("coulomb", "level", arm.coulomb)):
        lines += [
            f"  - {{effect: {name}_friction, joint: {joint}, side: motor, {parameter}: {value!r}}}"
            for joint, value in zip(arm.joints, values, strict=True)
            if value > 0.0
        ]
    return "\n".join(lines) + "\n"


def urdf(arm: SixArm) -> str:
    """Links and joints only: nothing to look at."""
    lines = ['<?xml version="1.0"?>', '<robot name="six_joint">', '  <link name="base"/>']
    for j, joint in enumerate(arm.joints):
        rpy = pin.rpy.matrixToRpy(arm.rotation[j])
        parent = "base" if j == 0 else arm.names[j - 1]
        lines += [f'  <joint name="{joint}" type="continuous">']
        lines += [f'    <parent link="{parent}"/><child link="{arm.names[j]}"/>']
        lines += [f'    <origin xyz="{_row(arm.translation[j])}" rpy="{_row(rpy)}"/><axis xyz="{_row(arm.axis[j])}"/>']
        lines += ["  </joint>", *_link(arm.names[j], arm.mass[j], arm.com[j], arm.inertia[j])]
    lines += ['  <joint name="tool_mount" type="fixed">', f'    <parent link="{arm.names[5]}"/><child link="tool"/>']
    lines += [f'    <origin xyz="{_row(np.array(TOOL_AT))}"/>', "  </joint>"]
    lines += [*_link("tool", arm.tool, np.array(TOOL_COM), TOOL_INERTIA * np.eye(3)), "</robot>"]
    return "\n".join(lines) + "\n"


def _row(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _link(name: str, mass: float, com: Array, inertia: Array) -> list[str]:
    pairs = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    tensor = " ".join(f'{key}="{float(inertia[a, b])!r}"' for key, a, b in pairs)
    return [
        f'  <link name="{name}"><inertial><origin xyz="{_row(com)}"/><mass value="{mass!r}"/>',
        f"    <inertia {tensor}/></inertial></link>",
    ]
