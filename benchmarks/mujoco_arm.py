"""The same arm in MuJoCo: rotors as hinges of their own, springs as fixed tendons between rotor and link."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
from arms import Arm, Array

# What a modeller who wants speed switches off: everything that this arm does not have.
UNUSED = ("contact", "equality", "limit", "actuation", "sensor", "midphase", "autoreset")
SETTINGS = {
    "smooth": f"flags off: {', '.join(UNUSED)}, constraint, frictionloss; no geoms; the rest at its default",
    "dry": f"flags off: {', '.join(UNUSED)}, island; solver PGS (fastest here of PGS, CG, Newton)",
}


class MujocoArm:
    """An `Arm` in MuJoCo.

    Link hinges come first, then the rotors' hinges, so that qpos = [q, theta] and qvel = [v, omega]. Stiffness and
    damping of a joint are those of a fixed tendon of length theta - q; viscous friction is joint damping, Coulomb
    friction joint frictionloss.

    Args:
        arm: revolute joints only.
        integrator: ``RK4``, ``Euler`` or ``implicitfast``.
        step: [s].
        tuned: switch off what the arm does not have, as in `SETTINGS`; else MuJoCo's defaults.
    """

    def __init__(self, arm: Arm, integrator: str, step: float, *, tuned: bool = True) -> None:
        self.arm = arm
        self.model = mujoco.MjModel.from_xml_string(_xml(arm, integrator, step, tuned))
        self.data = mujoco.MjData(self.model)
        self.reset()

    def reset(self) -> None:
        """Back to the first state, the motor torques applied."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = np.concatenate([self.arm.q0, self.arm.theta0])
        self.data.qfrc_applied[self.arm.n :] = self.arm.tau

    def steps(self, count: int) -> None:
        """Take steps; the loop is MuJoCo's own."""
        mujoco.mj_step(self.model, self.data, nstep=count)

    def positions(self, samples: int, between: int) -> Array:
        """[q, theta] from the first state on, every so many steps (samples + 1, 2 n) [rad]."""
        self.reset()
        rows = [np.array(self.data.qpos)]
        for _ in range(samples):
            self.steps(between)
            rows.append(np.array(self.data.qpos))
        return np.array(rows)

    def acceleration(self, q: Array, theta: Array, v: Array, omega: Array) -> Array:
        """[a, alpha] at a state (2 n,) [rad/s^2]."""
        self.reset()
        self.data.qpos[:] = np.concatenate([q, theta])
        self.data.qvel[:] = np.concatenate([v, omega])
        mujoco.mj_forward(self.model, self.data)
        return np.array(self.data.qacc)


def _xml(arm: Arm, integrator: str, step: float, tuned: bool) -> str:
    model, tree = arm.model, arm.model.robot.tree
    if tree.prismatic.any() or tree.m != arm.n or not model.elastic.all():
        raise ValueError("this benchmark takes revolute elastic joints only")
    root = ElementTree.Element("mujoco")
    _add(root, "compiler", angle="radian", autolimits="true")
    option = _add(root, "option", integrator=integrator, timestep=step, gravity=model.gravity)
    dry = {side: arm.coefficients("coulomb_friction", side) for side in ("link", "motor")}
    viscous = {side: arm.coefficients("viscous_friction", side) for side in ("link", "motor")}
    if tuned and any(level.any() for level in dry.values()):
        option.set("solver", "PGS")
        _add(option, "flag", **dict.fromkeys((*UNUSED, "island"), "disable"))
    elif tuned:
        _add(option, "flag", **dict.fromkeys((*UNUSED, "constraint", "frictionloss"), "disable"))
    world = _add(root, "worldbody")
    tendons = _add(root, "tendon")
    bodies: list[ElementTree.Element] = []
    for j in range(arm.n):
        parent = world if tree.parent[j] < 0 else bodies[tree.parent[j]]
        body = _add(parent, "body", pos=tree.translation[j], quat=_quaternion(tree.rotation[j]))
        bodies.append(body)
        inertia = tree.inertia[j][[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        _add(body, "inertial", pos=tree.com[j], mass=tree.mass[j], fullinertia=inertia)
        friction = {"damping": viscous["link"][j], "frictionloss": dry["link"][j]}
        _add(body, "joint", name=f"q{j}", axis=tree.axis[j], **friction)
    for j, rotor in enumerate(model.rotor_inertia):
        body = _add(world, "body")
        _add(body, "inertial", pos=np.zeros(3), mass=1.0, diaginertia=np.full(3, rotor))
        friction = {"damping": viscous["motor"][j], "frictionloss": dry["motor"][j]}
        _add(body, "joint", name=f"theta{j}", axis=np.array([0.0, 0.0, 1.0]), **friction)
        spring = {"stiffness": model.stiffness[j], "damping": model.damping[j], "springlength": 0.0}
        tendon = _add(tendons, "fixed", **spring)
        _add(tendon, "joint", joint=f"theta{j}", coef=1.0)
        _add(tendon, "joint", joint=f"q{j}", coef=-1.0)
    return ElementTree.tostring(root, encoding="unicode")


def _add(parent: ElementTree.Element, tag: str, **attributes: Any) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, {key: _text(value) for key, value in attributes.items()})


def _text(value: Any) -> str:
    return value if isinstance(value, str) else " ".join(repr(float(number)) for number in np.atleast_1d(value))


def _quaternion(rotation: Array) -> Array:
    x, y, z, w = pin.Quaternion(rotation).normalized().coeffs()
    return np.array([w, x, y, z])
