"""Limits of the URDF (range, speed, effort): where a run exceeds them, and models that enforce them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexdyn.checks import Array, number
from flexdyn.effects import Effect, EndStop, TorqueSpeedLimit
from flexdyn.effects.traits import Limit
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot import Robot
from flexdyn.robot.axes import joint_row
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.plant import first_positions

SLACK = 1e-6
"""An excess below this share of a limit, or of a unit, is not reported [1]."""
NO_LINE = 1e9
"""The torque-speed line of a motor that only saturates reaches zero at this multiple of the speed limit (or 1 rad/s).
"""
TRAVEL = 0.01
"""Deflection of an end stop when the link arrives at its speed limit [rad or m]."""
STOP_DAMPING_RATIO = 0.5
"""Damping ratio of link and end stop."""


class LimitWarning(UserWarning):
    """A run exceeds a limit of the URDF.

    Example:
        >>> import warnings
        >>> with warnings.catch_warnings(record=True, action="always") as told:
        ...     run = fd.simulate(fd.load_model("scara_two_link"), [1.0, 0.0], duration=0.5)
        >>> [each.category is fd.LimitWarning for each in told]
        [True]
    """


@dataclass(frozen=True)
class Exceeded:
    """A limit that a run exceeded at its samples.

    Attributes:
        joint: its name.
        kind: ``position``, ``speed`` or ``torque``.
        limit: the limit [rad, rad/s, N m; prismatic: m, m/s, N].
        by: largest excess, above 0.
        since: first time of an excess [s].
        at: time of the largest excess [s].
        unit: of limit and by.

    Example:
        >>> import warnings
        >>> with warnings.catch_warnings(action="ignore"):
        ...     run = fd.simulate(fd.load_model("scara_two_link"), [1.0, 0.0], duration=0.5)
        >>> [(each.joint, each.kind, each.limit) for each in run.exceeded]
        [('shoulder', 'torque', 0.63)]
    """

    joint: str
    kind: str
    limit: float
    by: float
    since: float
    at: float
    unit: str

    def __str__(self) -> str:
        """Which joint, when and by how much, in a sentence."""
        when = f"from t = {self.since:.4g} s on" + (f", most at {self.at:.4g} s" if self.at > self.since else "")
        return f"{self.joint} exceeds its {self.kind} limit of {self.limit:.4g} {self.unit} by {self.by:.3g}, {when}"


def exceeded(robot: Robot, t: Array, q: Array, v: Array, tau: Array) -> tuple[Exceeded, ...]:
    """Limits that a motion exceeds at its samples.

    Args:
        robot: whose limits they are.
        t: times (samples,) [s].
        q: link positions (samples, n).
        v: link velocities (samples, n).
        tau: torques of the motors, reflected, after the effects of the actuators (samples, n).
    """
    found = []
    for joint, kind, limit, past, unit in _excesses(robot, q, v, tau):
        beyond = past > SLACK * max(1.0, abs(limit))
        if beyond.any():
            most = int(np.argmax(past))
            since = float(t[np.argmax(beyond)])
            found.append(Exceeded(joint, kind, limit, float(past[most]), since, float(t[most]), unit))
    return tuple(found)


def _excesses(robot: Robot, q: Array, v: Array, tau: Array) -> Iterator[tuple[str, str, float, Array, str]]:
    """Joint, kind, limit, excess at every sample, unit, for every limit in the URDF; joints that axes move are last."""
    for j, joint in enumerate(robot.joint_names):
        angle = robot.angle_unit(j)
        yield from _outside(joint, (float(robot.lower[j]), float(robot.upper[j])), q[:, j], angle)
        for kind, limits, values, unit in (
            ("speed", robot.velocity_limit, v, f"{angle}/s"),
            ("torque", robot.effort_limit, tau, robot.torque_unit(j)),
        ):
            if 0.0 < limits[j] < math.inf:  # files without numbers write 0
                yield joint, kind, float(limits[j]), np.abs(values[:, j]) - limits[j], unit
    for joint, ends in robot.coupled_limits.items():
        row = joint_row(robot, joint)
        if row is not None:  # no axis has its name
            yield from _outside(joint, ends, q @ row, robot.angle_unit(int(np.flatnonzero(row)[0])))


def _outside(
    joint: str, ends: tuple[float, float], position: Array, unit: str
) -> Iterator[tuple[str, str, float, Array, str]]:
    for limit, sign in zip(ends, (-1.0, 1.0), strict=True):
        if math.isfinite(limit):
            yield joint, "position", limit, sign * (position - limit), unit


def enforce_limits(
    model: FlexibleJointModel, *, stiffness: float | None = None, damping: float | None = None
) -> FlexibleJointModel:
    """The model with the limits of its URDF as effects: end stops at the ends of range, motors that saturate.

    The torque is limited to the effort limit (`TorqueSpeedLimit` without a slope). The speed is not limited; a run
    that is too fast gives a warning. An end stop or a limit of a motor that the model has already stays as it is.

    Args:
        model: the arm.
        stiffness: of the end stops [N m/rad]; default: a link that arrives at its speed limit (1 rad/s if there is
            none) deflects the stop by 0.01 rad.
        damping: of the end stops [N m s/rad]; default: half of critical.

    Raises:
        InputError: a stiffness or damping that is not above 0, or a URDF that states no limit.

    Example:
        >>> model = fd.enforce_limits(fd.load_model("ur5"))
        >>> [effect.name for effect in model.effects[-2:]]
        ['end_stop', 'torque_speed_limit']
    """
    for key, value in (("stiffness", stiffness), ("damping", damping)):
        if value is not None:
            number(key, value, "a number above 0 is needed", above=0.0)
    added: list[Effect] = []
    M = LinkSide(model).mass_matrix(first_positions(model))

    def stop(joint: str, limits: tuple[float, float], fastest: float, inertia: float) -> None:
        """Add an end stop, unless the joint has one."""
        if _keeps_to(model, "range", joint):
            return
        K = (fastest / TRAVEL) ** 2 * inertia if stiffness is None else stiffness
        D = 2.0 * STOP_DAMPING_RATIO * math.sqrt(K * inertia) if damping is None else damping
        added.append(EndStop(joint, side="link", lower=limits[0], upper=limits[1], stiffness=K, damping=D))

    for joint, limits in model.robot.coupled_limits.items():
        row = joint_row(model.robot, joint)
        if row is not None:  # no axis has its name
            stop(joint, limits, 1.0, 1.0 / float(row @ np.linalg.solve(M, row)))
    for j, joint in enumerate(model.joint_names):
        limits = (float(model.robot.lower[j]), float(model.robot.upper[j]))
        if any(map(math.isfinite, limits)):
            stop(joint, limits, _fastest(model.robot, j), float(M[j, j]))
        effort = float(model.robot.effort_limit[j])
        if 0.0 < effort < math.inf and not _keeps_to(model, "effort", joint):
            speed = NO_LINE * max(1.0, _fastest(model.robot, j))
            added.append(TorqueSpeedLimit(joint, side="motor", stall_torque=effort, no_load_speed=speed))
    if not added and not model.effects:
        remedy = f"write <limit lower upper velocity effort> into it, or add {EndStop.name} and {TorqueSpeedLimit.name}"
        raise InputError("the robot states no limit", key="limits", value=model.name, remedy=remedy)
    return model.replace(effects=[*model.effects, *added])


def _fastest(robot: Robot, j: int) -> float:
    limit = float(robot.velocity_limit[j])
    return limit if 0.0 < limit < math.inf else 1.0


def _keeps_to(model: FlexibleJointModel, limit: Limit, joint: str) -> bool:
    """Whether an effect of the model keeps a joint to a limit already."""
    return any(effect.keeps_to == limit and getattr(effect, "joint", None) == joint for effect in model.effects)
