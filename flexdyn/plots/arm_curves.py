"""Curves of what changes the arm itself: a mass on its links, a wrong number of the model."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.effects.model_error import is_number_error
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.plots import page
from flexdyn.robot import load_robot
from flexdyn.simulation.link_side import LinkSide

ARM = """<robot name="arm">
<link name="base"/>
<link name="{name}"><inertial><mass value="2"/><origin xyz="0 0 -0.25"/>
<inertia ixx="0.04" iyy="0.04" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{name}" type="revolute"><parent link="base"/><child link="{name}"/><axis xyz="0 1 0"/>
<limit lower="-3.2" upper="3.2" effort="100" velocity="10"/></joint>
<link name="tip"/>
<joint name="tip_joint" type="fixed"><parent link="{name}"/><child link="tip"/><origin xyz="0 0 -0.5"/></joint>
</robot>"""
"""An arm with one rigid joint, for pictures: a rod of 2 kg and 0.5 m, which hangs at 0."""
ROTOR_INERTIA = 0.2
"""Reflected rotor inertia of its joint [kg m^2]: of the size of the rod's own inertia about the joint, 0.165."""
ACCELERATION = 15.0
"""Acceleration of the second pair of curves [rad/s^2]: it takes about as much torque as the rod's weight."""


def needed_torque(axes: Any, effect: Effect) -> tuple[str, str]:
    """Torque that one joint needs over its position, at rest and with an acceleration, without the effect and with it.

    Raises:
        InputError: the effect is the error of a number that this arm does not have.
    """
    name, without = "joint", "without it"
    if is_number_error(effect):
        name, without = effect.of, f"the given {effect.parameter}"
    plain, changed = (_link_side(name, effects) for effects in ((), (effect,)))
    q = np.linspace(-np.pi, np.pi, 401)
    page.cross(axes)
    for a, shade, told in ((0.0, page.BLUE, "at rest"), (ACCELERATION, page.RED, f"{ACCELERATION:g} rad/s²")):
        axes.plot(q, _torque(plain, q, a), color=shade, linewidth=1.2, linestyle=page.GUIDE_DASHES)
        page.line(axes, q, _torque(changed, q, a), color=shade, label=told)
    axes.plot([], [], color=page.GREY, linewidth=1.2, linestyle=page.GUIDE_DASHES, label=f"dashed: {without}")
    page.legend_above(axes, 3)
    return "position $q$ of the joint, 0 where it hangs [rad]", "torque that the joint needs [N m]"


def _link_side(name: str, effects: tuple[Effect, ...]) -> LinkSide:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.urdf"
        file.write_text(ARM.format(name=name), encoding="utf-8")
        robot = load_robot(file)
    return LinkSide(FlexibleJointModel(robot, {name: {"rotor_inertia": ROTOR_INERTIA}}, effects))


def _torque(links: LinkSide, q: Array, acceleration: float) -> Array:
    """M(q) a + h(q, 0) of the one joint."""
    return links.inverse_dynamics(q[:, None], np.zeros((len(q), 1)), np.full((len(q), 1), acceleration))[:, 0]
