"""Model file and URDF of a two-link arm as plain text, and the errors that every number in them has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from arm_draw import GRAVITY, JOINTS, LINKS, TwoLinkArm

ERROR, MASS_ERROR = 0.03, 0.02
"""Greatest relative error of a number, uniform, and of a link's mass. Lengths and gear ratios are right: they are drawn
or counted, not measured."""
TOLERANCE = 0.03
"""What the model file says of its numbers: a standard deviation."""


def mistaken(
    arm: TwoLinkArm, rng: np.random.Generator, error: float, mass_error: float, *, at_edge: bool
) -> TwoLinkArm:
    """The arm as its maker wrote it down; at_edge: the masses are wrong by all of mass_error."""

    def wrong(pair: tuple[float, float], by: float) -> tuple[float, float]:
        off = rng.choice([-1.0, 1.0], 2) if at_edge and by == mass_error else rng.uniform(-1.0, 1.0, 2)
        return float(f"{pair[0] * (1 + by * off[0]):.7g}"), float(f"{pair[1] * (1 + by * off[1]):.7g}")

    names = ("com", "inertia", "rotor_inertia", "stiffness", "damping", "viscous", "coulomb")
    changed = {name: wrong(getattr(arm, name), error) for name in names}
    tool = arm.tool * (1.0 + mass_error * rng.uniform(-1.0, 1.0))
    return arm.replace(**changed, mass=wrong(arm.mass, mass_error), tool=float(f"{tool:.7g}"))


def known_effects(arm: TwoLinkArm) -> list[tuple[str, int, str, float]]:
    """Effect, joint, parameter and value of what the model file lists, in its order."""
    rows = [("viscous_friction", j, "coefficient", arm.viscous[j]) for j in (0, 1)]
    rows += [("coulomb_friction", j, "level", arm.coulomb[j]) for j in (0, 1)]
    return [row for row in rows if row[3] > 0.0]


def model_yaml(arm: TwoLinkArm, tolerance: float | Mapping[str, float]) -> str:
    """The model file; tolerance: of all numbers, or by their paths."""
    lines = ["flexdyn: 1", "robot:", "  urdf: arm.urdf", f"  gravity: [0.0, 0.0, -{GRAVITY}]", "joints:"]
    for j, joint in enumerate(JOINTS):
        stiffness = ".inf" if np.isinf(arm.stiffness[j]) else repr(arm.stiffness[j])
        lines += [
            f"  {joint}:",
            f"    gear_ratio: {arm.gear_ratio[j]!r}",
            f"    rotor_inertia: {arm.rotor_inertia[j]!r}",
            f"    stiffness: {stiffness}",
            f"    damping: {arm.damping[j]!r}",
        ]
    lines += ["initial:", f"  q: {{{JOINTS[0]}: {arm.middle[0]!r}, {JOINTS[1]}: {arm.middle[1]!r}}}"]
    lines.append(f"tolerance: {tolerance!r}")
    effects = [
        f"  - {{effect: {name}, joint: {JOINTS[j]}, side: motor, {parameter}: {value!r}}}"
        for name, j, parameter, value in known_effects(arm)
    ]
    lines += ["effects:", *effects] if effects else ["effects: []"]
    return "\n".join(lines) + "\n"


def urdf(arm: TwoLinkArm) -> str:
    """Two links along x; in the vertical plane positive angles lift them."""
    axis = "0 -1 0" if arm.vertical else "0 0 1"
    lines = ['<?xml version="1.0"?>', '<robot name="two_link">', '  <link name="base"/>']
    for j, (joint, link) in enumerate(zip(JOINTS, LINKS, strict=True)):
        parent, origin = ("base", 0.0) if j == 0 else (LINKS[0], arm.length[0])
        lines += [
            f'  <joint name="{joint}" type="continuous">',
            f'    <parent link="{parent}"/><child link="{link}"/>',
            f'    <origin xyz="{origin!r} 0 0"/><axis xyz="{axis}"/>',
            "  </joint>",
            *_link(link, arm.mass[j], arm.com[j], arm.inertia[j]),
        ]
    lines += [
        '  <joint name="tool_mount" type="fixed">',
        f'    <parent link="{LINKS[1]}"/><child link="tool"/>',
        f'    <origin xyz="{arm.length[1]!r} 0 0"/>',
        "  </joint>",
        *_link("tool", arm.tool, 0.0, 0.0),
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def _link(name: str, mass: float, com: float, inertia: float) -> list[str]:
    around = f'<inertia ixx="{0.1 * inertia!r}" ixy="0" ixz="0" iyy="{inertia!r}" iyz="0" izz="{inertia!r}"/>'
    return [
        f'  <link name="{name}">',
        f'    <inertial><origin xyz="{com!r} 0 0"/><mass value="{mass!r}"/>{around}</inertial>',
        "  </link>",
    ]
