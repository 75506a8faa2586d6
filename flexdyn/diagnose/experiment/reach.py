"""Bounds of an arm's motion from its recordings, which a proposed experiment does not exceed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.effects import Payload
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.link_side import LinkSide

GREATEST_PERCENTILE = 99.0
"""This percentile of speeds and accelerations counts as the largest one: noise causes larger ones."""
USED_RANGE_SHARE = 0.9
"""Share of range, speed and acceleration for a proposed motion, because its tracking is not perfect [1]."""
CONTROLLER_BANDWIDTH = 15.0
"""Largest bandwidth of the joint controller in the simulation of an experiment [rad/s]."""
SPRING_FREQUENCY_SHARE = 0.3
"""Largest ratio of this bandwidth to a joint's own frequency on its spring [1]."""
PAYLOAD_SHARE = 0.3
"""Largest share of the remaining torque, and of an inertia, for a proposed payload [1]."""
VELOCITY_GAIN_RATIO = 1.6
"""Its velocity gain over inertia times bandwidth [1]."""


@dataclass(frozen=True, eq=False)
class Reach:
    """Bounds of every joint, in the order of q, and gains of a controller.

    Attributes:
        dt: between samples of the recordings [s].
        ends: of the ranges seen (2, n) [rad or m].
        fastest: largest speeds (n,) [rad/s or m/s].
        torque: largest commanded torques (n,) [N m or N].
        low, high: ends of proposed motions (n,), somewhat inside the recorded ranges.
        speed: of proposed motions (n,).
        acceleration: of proposed motions (n,).
        poses: in the middle of the ranges, then those with the largest and smallest gravity torques (poses, n).
        kp, kd: gains of a joint controller (n,).
    """

    dt: float
    ends: Array
    fastest: Array
    torque: Array
    low: Array
    high: Array
    speed: Array
    acceleration: Array
    poses: Array
    kp: Array
    kd: Array

    @classmethod
    def of(cls, equations: Equations, calibrated: FlexibleJointModel) -> Reach:
        """Of recordings; limits of the robot's description narrow it.

        Args:
            equations: of the recordings.
            calibrated: the model with the numbers that were estimated, for the controller's gains: a rotor inertia may
                not have been known.
        """
        motions, true, robot = equations.motions, equations.true, equations.true.robot
        q = np.concatenate([each.q for each in motions])
        low, high = np.maximum(q.min(axis=0), robot.lower), np.minimum(q.max(axis=0), robot.upper)
        middle, half = 0.5 * (low + high), 0.5 * USED_RANGE_SHARE * np.maximum(high - low, 0.0)
        v, a = (np.abs(np.concatenate([getattr(each, name) for each in motions])) for name in ("v", "a"))
        speed, acceleration = (np.percentile(each, GREATEST_PERCENTILE, axis=0) for each in (v, a))
        torque = np.max([np.abs(each.data.tau).max(axis=0) for each in motions], axis=0)
        numbers = calibrated.resolved()
        inertia = np.diag(LinkSide(numbers).mass_matrix(middle)) + np.where(true.elastic, numbers.rotor_inertia, 0.0)
        own = np.sqrt(np.where(true.elastic, numbers.stiffness, np.inf) / inertia)
        bandwidth = np.minimum(CONTROLLER_BANDWIDTH, SPRING_FREQUENCY_SHARE * own)
        return cls(
            motions[0].dt,
            np.stack([low, high]),
            np.minimum(v.max(axis=0), robot.velocity_limit),
            np.minimum(torque, robot.effort_limit),
            middle - half,
            middle + half,
            USED_RANGE_SHARE * np.minimum(speed, robot.velocity_limit),
            USED_RANGE_SHARE * acceleration,
            np.clip(_poses(equations.links, q, middle), middle - half, middle + half),
            inertia * bandwidth**2,
            VELOCITY_GAIN_RATIO * inertia * bandwidth,
        )

    def holds(self, q: Array, v: Array, tau: Array) -> bool:
        """Whether a motion (samples, n) stays within the bounds."""
        inside = (q >= self.ends[0]).all() and (q <= self.ends[1]).all()
        return bool(inside and (np.abs(v) <= self.fastest).all() and (np.abs(tau) <= self.torque).all())


def _poses(links: LinkSide, q: Array, middle: Array) -> Array:
    """The middle pose, and the recorded poses with the largest and smallest gravity torques of all joints together."""
    seen = q[:: max(1, len(q) // 500)]
    weight = np.linalg.norm(links.bias(seen, np.zeros_like(seen)), axis=1)
    return np.stack([middle, seen[int(np.argmax(weight))], seen[int(np.argmin(weight))]])


def with_load(model: FlexibleJointModel, mass: float) -> FlexibleJointModel:
    """The model of an arm with a known payload [kg] at its tip."""
    return model.replace(effects=[*model.effects, Payload(mass=mass, frame=model.robot.tip)])


def load_mass(equations: Equations, reach: Reach) -> float:
    """A known payload for the tip [kg]: 1, 2 or 5 times a power of ten; 0 if the recorded torques do not allow one.

    At each pose it takes only a part of the torque that gravity leaves, and adds only a part of each inertia.
    """
    true = equations.true
    with_it = LinkSide(with_load(true, 1.0))
    rest = np.zeros_like(reach.poses)
    weight = equations.links.bias(reach.poses, rest)
    more = np.abs(with_it.bias(reach.poses, rest) - weight)
    M = np.diagonal(equations.links.mass_matrix(reach.poses), axis1=1, axis2=2)
    heavier = np.diagonal(with_it.mass_matrix(reach.poses), axis1=1, axis2=2) - M
    room = np.maximum(reach.torque - np.abs(weight), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = (np.where(of > 0.0, left / of, np.inf) for left, of in ((room, more), (M, heavier)))
        most = PAYLOAD_SHARE * min(float(each.min()) for each in ratios)
    if not 1e-3 < most < np.inf:
        return 0.0
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * max(k for k in (1.0, 2.0, 5.0) if k * power <= most * (1.0 + 1e-9)))
