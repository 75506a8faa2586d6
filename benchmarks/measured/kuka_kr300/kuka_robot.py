"""The KUKA KR 300 of Weigand, Ulmen, Janot and Ruskowski (2021): URDF and model file from the published table.

    python benchmarks/measured/kuka_kr300/kuka_robot.py

writes arm.urdf, rigid.yaml and elastic.yaml beside this file. Numbers: github.com/JonasWeigand/Robot_Identification,
robot_model/model_KUKA_Quantec_Ultra_KR300.m (links, gears, rotors) and data/data_ref.mat, `para` (stiffness).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
Array = NDArray[np.float64]
PAYLOAD = 151.0
"""Mass at the flange [kg]: the authors identify class 3.048, 75 + 25*3.048."""
PAYLOAD_AT, FLANGE_AT, FLANGE = 0.100, -0.050, 17.78
"""Along the last link's z: centres of the payload and of the flange [m]; mass of the flange [kg]."""
TOLERANCE, LOOSE = 0.03, 1.0
"""Relative, 1 sigma: numbers of a data sheet; friction, which goes with temperature and which the authors' law divides
otherwise, and the rotors of axes 4 to 6, for which their two files give 0.00173 and 0.01 kg m^2."""


@dataclass(frozen=True)
class Axis:
    """One axis: standard Denavit-Hartenberg numbers, and the link in the frame at its end.

    Attributes:
        d, a: [m].
        alpha, offset: [deg].
        mass: [kg].
        com: [m].
        inertia: about the centre of mass, xx, yy, zz, xy, yz, xz [kg m^2].
        rotor: inertia on the motor's side [kg m^2].
        ratio: of the gear [1].
        viscous, coulomb, bias: friction as the authors identified it on the link side [N m s/rad, N m, N m]. Their
            ``f_coul tanh(dq)`` is viscous at these speeds (below 0.8 rad/s) and is added to f_vis; f_a is the level.
        stiffness: of the gear, where the authors give one [N m/rad].
    """

    d: float
    a: float
    alpha: float
    offset: float
    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]
    rotor: float
    ratio: float
    viscous: float
    coulomb: float
    bias: float
    stiffness: float = np.inf


def _last_com(payload: float) -> tuple[float, float, float]:
    return (0.0, 0.0, (payload * PAYLOAD_AT + FLANGE * FLANGE_AT) / (payload + FLANGE))


AXES = (
    Axis(-0.675, 0.350, 90.0, 0.0, 395.40, (-0.353, 0.174, -0.004),
         (16.733765, 29.799119, 32.814954, -1.703664, 0.129384, 4.404062), 0.00923, 1798 / 7,
         1939.52 + 31.65, 318.64, 4.26, 4.5778e6),
    Axis(-0.189, 1.150, 0.0, 0.0, 339.12, (-0.709, -0.001, 0.023),
         (7.507819, 88.886691, 88.673761, 0.430046, 0.173157, -4.396607), 0.0118, 1872 / 7,
         1729.85 + 117.47, 420.7, -16.6, 7.5189e6),
    Axis(0.189, 0.041, -90.0, 90.0, 105.21, (-0.018, -0.018, -0.076),
         (10.783798, 10.186135, 1.943179, 0.118474, -0.606384, -0.101950), 0.0118, 757 / 3,
         1562.42 + 85.65, 291.52, -17.67, 4.0999e6),
    Axis(-1.000, 0.0, 90.0, 0.0, 35.80, (0.0, 0.236, 0.001),
         (0.425035, 0.217993, 0.428465, -0.000004, -0.011353, -0.000027), 0.00173, 221.0,
         280.49 + 49.74, 43.88, -11.54),
    Axis(0.0, 0.0, -90.0, 0.0, 31.46, (0.0, -0.080, -0.009),
         (0.283826, 0.229562, 0.258266, -0.000004, -0.019521, -0.000120), 0.00173, 5032 / 21,
         468.13 + 111.06, 13.83, -0.32),
    Axis(-0.240, 0.0, 180.0, 0.0, FLANGE + PAYLOAD, _last_com(PAYLOAD), (0.0,) * 6, 0.00173, 206793 / 1340,
         384.41 + 5.29, 82.43, 10.58),
)  # fmt: skip
"""Axes 1 to 6."""


def placements() -> tuple[list[Array], list[Array]]:
    """Homogeneous transforms (4, 4): of every joint's frame in its parent's, and of every link's end in its joint's.

    A joint turns about its z at the start of its link, DH offset included; the base is turned by 180 deg about x.
    """
    origins, ends = [], []
    before = _turn("x", 180.0)
    for axis in AXES:
        origins.append(before @ _turn("z", axis.offset))
        end = _turn("x", axis.alpha)
        end[:3, 3] = (axis.a, 0.0, axis.d)
        ends.append(end)
        before = end
    return origins, ends


def urdf() -> str:
    """The arm's text; every joint's zero is that of the published model."""
    origins, ends = placements()
    lines = ['<?xml version="1.0"?>', '<robot name="kuka_kr300">', '  <link name="base"/>']
    for k, (axis, origin, end) in enumerate(zip(AXES, origins, ends, strict=True), start=1):
        parent = "base" if k == 1 else f"link{k - 1}"
        xx, yy, zz, xy, yz, xz = axis.inertia
        com = end[:3, :3] @ np.array(axis.com) + end[:3, 3]
        tensor = f'ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="{xy!r}" iyz="{yz!r}" ixz="{xz!r}"'
        lines += [
            f'  <link name="link{k}">',
            f'    <inertial><origin xyz="{_three(com)}" rpy="{_three(_rpy(end))}"/>',
            f'      <mass value="{axis.mass!r}"/><inertia {tensor}/></inertial>',
            "  </link>",
            f'  <joint name="axis{k}" type="continuous">',
            f'    <parent link="{parent}"/><child link="link{k}"/>',
            f'    <origin xyz="{_three(origin[:3, 3])}" rpy="{_three(_rpy(origin))}"/><axis xyz="0 0 1"/>',
            "  </joint>",
        ]
    return "\n".join([*lines, "</robot>", ""])


def model_yaml(elastic: bool) -> str:
    """The model file: the published model with its friction, and the springs of axes 1 to 3 where `elastic`."""
    lines = [
        "# KUKA KR 300, made by kuka_robot.py from the published table; see there.",
        "flexdyn: 1",
        "robot: {urdf: arm.urdf, gravity: [0.0, 0.0, -9.81]}",
        "joints:",
    ]
    for k, axis in enumerate(AXES, start=1):
        spring = f", stiffness: {axis.stiffness:.5g}" if elastic and np.isfinite(axis.stiffness) else ""
        lines.append(f"  axis{k}: {{gear_ratio: {axis.ratio!r}, rotor_inertia: {axis.rotor!r}{spring}}}")
    lines.append("effects:")
    for k, axis in enumerate(AXES, start=1):
        at = f"joint: axis{k}, side: motor"
        lines += [
            f"  - {{effect: viscous_friction, {at}, coefficient: {axis.viscous:.6g}}}",
            f"  - {{effect: coulomb_friction, {at}, level: {axis.coulomb}}}",
            f"  - {{effect: torque_offset, {at}, offset: {-axis.bias}}}",
        ]
    lines.append(f'tolerance: {{"*": {TOLERANCE}')
    for k in range(len(AXES)):
        names = (f"effects[{3 * k}].coefficient", f"effects[{3 * k + 1}].level", f"effects[{3 * k + 2}].offset")
        loose = [*names, f"joints.axis{k + 1}.rotor_inertia"] if k > 2 else names
        lines[-1] += "".join(f', "{name}": {LOOSE}' for name in loose)
    lines[-1] += "}"
    return "\n".join([*lines, "initial: {q: {axis2: -1.5707963267948966, axis3: 1.5707963267948966}}", ""])


def _turn(about: str, degrees: float) -> Array:
    c, s = np.round((np.cos(np.radians(degrees)), np.sin(np.radians(degrees))), 15)
    turn = np.eye(4)
    i, j = {"x": (1, 2), "z": (0, 1)}[about]
    turn[i, i], turn[j, j], turn[i, j], turn[j, i] = c, c, -s, s
    return turn


def _rpy(transform: Array) -> Array:
    """Roll, pitch and yaw of a rotation whose pitch is not at 90 deg, as those of this table are."""
    R = transform
    return np.array([np.arctan2(R[2, 1], R[2, 2]), np.arcsin(-R[2, 0]), np.arctan2(R[1, 0], R[0, 0])])


def _three(values: Array) -> str:
    return " ".join(f"{value + 0.0:.12g}" for value in values)


def write(folder: Path = HERE) -> None:
    """Write URDF and model files."""
    (folder / "arm.urdf").write_text(urdf(), encoding="utf-8")
    for name, elastic in (("rigid.yaml", False), ("elastic.yaml", True)):
        (folder / name).write_text(model_yaml(elastic), encoding="utf-8")


if __name__ == "__main__":
    write()
