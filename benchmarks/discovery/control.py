"""The controller of a case: gains of an ordinary servo, inertia and gravity fed forward a little wrong."""

from __future__ import annotations

import layout as at
import numpy as np
from arm_draw import TwoLinkArm, inertia_at
from excitation import wanted_of
from layout import Array
from motions import Style as Style
from two_link_run import PERIOD, Control

FEEDFORWARD = 0.9  # share of the model's torque that is fed forward


def draw_bandwidth(rng: np.random.Generator) -> Array:
    """Of the position loops (2,) [rad/s]: low enough for a spring, a late command and a reversal to be survived."""
    return 2.0 * np.pi * rng.uniform(2.0, 3.2, 2)


def make_control(
    rng: np.random.Generator,
    arm: TwoLinkArm,
    styles: tuple[Style, Style],
    duration: float,
    bandwidth: Array,
    seen: Array,
    motion: str = "mixed",
    share: float = FEEDFORWARD,
) -> Control:
    """Gains and a motion for an arm; seen: resolution of the encoders that are fed back (2,) [rad]."""
    wanted = wanted_of(motion, rng, styles, arm.middle, duration)
    whole = inertia_at(arm) + arm.rotor()
    return Control(wanted, share * feedforward(arm, wanted), whole * bandwidth**2, whole * 1.6 * bandwidth, seen)


def feedforward(arm: TwoLinkArm, wanted: Array) -> Array:
    """Torques that the rigid arm would need for this motion (samples, 2) [N m]."""
    links, (q1, q2) = arm.links(), wanted.T
    v = np.gradient(wanted, PERIOD, axis=0)
    a = np.gradient(v, PERIOD, axis=0)
    c, s = links[at.TURN] * np.cos(q2), links[at.TURN] * np.sin(q2)
    outer, rotor = links[at.OUTER], arm.rotor()
    first = (links[at.FIXED] + 2.0 * c + rotor[0]) * a[:, 0] + (outer + c) * a[:, 1]
    second = (outer + c) * a[:, 0] + (outer + rotor[1]) * a[:, 1]
    first -= s * v[:, 1] * (v[:, 1] + 2.0 * v[:, 0])
    second += s * v[:, 0] ** 2
    hanging = links[at.WEIGHT_2] * np.cos(q1 + q2)
    return np.stack([first + links[at.WEIGHT_1] * np.cos(q1) + hanging, second + hanging], axis=1)
