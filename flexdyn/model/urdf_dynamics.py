"""A URDF's <dynamics damping friction> as effects on the link side."""

from __future__ import annotations

from flexdyn.effects import CoulombFriction, Effect, ViscousFriction
from flexdyn.robot import Robot


def urdf_effects(robot: Robot) -> tuple[Effect, ...]:
    """<dynamics damping friction> as effects: Pinocchio parses them and does not use them."""
    effects: list[Effect] = []
    for joint, damping, friction in zip(robot.joint_names, robot.damping, robot.friction, strict=True):
        if damping > 0:
            effects.append(ViscousFriction(joint, side="link", coefficient=float(damping)))
        if friction > 0:
            effects.append(CoulombFriction(joint, side="link", level=float(friction)))
    return tuple(effects)
