"""First values and prior widths of unknown numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.joint import NUMBERS, Joint
from flexdyn.model.stated_tolerances import unknown_masses
from flexdyn.simulation.link_side import LinkSide

START = 0.01
"""First value of a number that is given as 0, as a share of its absolute tolerance [1]."""
ROTOR_START, ROTOR_SPREAD = 1.0, 100.0
"""Value and spread of an unknown rotor inertia, reflected, as shares of the links' inertia about the joint [1].

Gears are usually chosen so that the two are similar; with the high gear of a small link, the rotor's inertia is up to a
hundred times larger."""
DAMPING_START, DAMPING_SPREAD = 0.05, 1.0
"""Value and spread of an unknown damping, as shares of the critical damping of the joint's spring [1]."""
LINK_START, LINK_SPREAD = 0.05, 1.0
"""Value and spread of an unknown inertia of a link, as shares of mass times length squared [1]; a slender rod has 1/12.
"""
MASS_SPREAD = 10.0
"""Spread of an unknown mass, as a share of the URDF's [1]; the value is that of the URDF."""
SHORTEST_LINK = 0.05
"""Smallest length of a link [m]."""
AVERAGED_POSITIONS = 64
"""Number of positions over which the inertia about a joint is averaged."""


def with_guesses(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model with a first value and a broad prior for every number that is unknown or given as 0 with a tolerance.

    The prior is normal about that value; its width is `ROTOR_SPREAD`, `DAMPING_SPREAD`, `LINK_SPREAD` or `MASS_SPREAD`,
    or the absolute tolerance. Unknown sizes of effects stay: only a recording has a scale for them.

    Args:
        model: as given.

    Raises:
        InputError: an unknown rotor in a joint whose links move no inertia: there is no scale for it.
    """
    if isinstance(model.tolerance, Mapping) and (masses := unknown_masses(model.tolerance, model.robot.frame_names)):
        wide = {f"links.{link}.mass": MASS_SPREAD for link in masses}
        model = model.replace(tolerance={**model.tolerance, **wide})
    if any(number.value == 0.0 for number in model.links.values()):
        model = model.replace(links={link: _link_guess(model, link) for link in model.links})
    open_ = [name for name, joint in model.joints.items() if any(_is_open(joint, key) for key in NUMBERS)]
    if not open_:
        return model
    turned = _turned(model)
    return model.replace(joints={name: _joint_guess(model, name, turned[model.index(name)]) for name in open_})


def _is_open(joint: Joint, number: str) -> bool:
    """Whether it is given only by a tolerance, or is unknown."""
    given = joint.given(number)
    return given.tolerance is not None and given.value == 0.0


def _joint_guess(model: FlexibleJointModel, name: str, turned: float) -> dict[str, Any]:
    """Values and tolerances of a joint's open numbers."""
    joint, found = model.joints[name], {}
    if turned <= 0.0 and joint.given("rotor_inertia").is_unknown:
        remedy = "give rotor_inertia an absolute tolerance: {value: 0.0, tolerance: 1.0e-4}"
        raise InputError("its links move no inertia", key=f"joints.{name}.rotor_inertia", remedy=remedy)
    for key in NUMBERS:
        if _is_open(joint, key):
            tolerance = float(joint.given(key).tolerance or 0.0)
            start, spread = START * tolerance, tolerance
            if math.isinf(tolerance) and key == "rotor_inertia":
                motor_side = turned / joint.gear_ratio**2
                start, spread = ROTOR_START * motor_side, ROTOR_SPREAD * motor_side
            elif math.isinf(tolerance):
                critical = 2.0 * math.sqrt(joint.stiffness * max(turned, 0.0)) if joint.elastic else 0.0
                start, spread = DAMPING_START * critical, DAMPING_SPREAD * critical
            found[key] = {"value": start, "tolerance": spread} if spread > 0.0 else 0.0
    return found


def _turned(model: FlexibleJointModel) -> list[float]:
    """Mean inertia of the links about each joint (n,) [kg m^2 or kg]."""
    robot = model.robot
    slack = {"rotor_inertia": 0.0, "stiffness": math.inf, "damping": 0.0}
    known = model.resolved().replace(joints={"*": slack}, effects=[])
    low = np.where(np.isfinite(robot.lower), robot.lower, -math.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, math.pi)
    poses = np.random.default_rng(0).uniform(low, high, (AVERAGED_POSITIONS, model.n))
    diagonals = np.diagonal(LinkSide(known).mass_matrix(poses), axis1=-2, axis2=-1)
    return [float(each) for each in diagonals.mean(axis=0)]


def _link_guess(model: FlexibleJointModel, link: str) -> Mapping[str, Any]:
    """Value and tolerance of a link's inertia."""
    given = model.links[link]
    tolerance = float(given.tolerance or 0.0)
    if given.tolerance is None or given.value != 0.0:
        return {"inertia": given.entry()}
    if math.isfinite(tolerance):
        return {"inertia": {"value": START * tolerance, "tolerance": tolerance}}
    mass, length = model.robot.link_size(link)
    scale = mass * max(length, SHORTEST_LINK) ** 2
    return {"inertia": {"value": LINK_START * scale, "tolerance": LINK_SPREAD * scale}}
