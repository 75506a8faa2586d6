"""How the six-joint arm is moved, and what it does then without the hidden effect."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import sizes
import wide
from control import FEEDFORWARD
from excitation import wanted_of
from lab import MARGIN, longer
from layout import Array
from model_text import TOLERANCE
from motions import Style, reference
from six_arm import MIDDLE, SixArm
from two_link_run import PERIOD, Control, Truth
from wide import Setup

REACH = (0.8, 0.5, 0.5, 0.8, 0.8, 1.2)  # rad
ORDINARY = Setup(TOLERANCE, "mixed", 1, FEEDFORWARD, wide=False)


def draw_control(
    rng: np.random.Generator, arm: SixArm, duration: float, seen: Array, whole: Array, setup: Setup = ORDINARY
) -> Control:
    """All six joints in motion at once, or as the case's kind of motion has it."""
    model = arm.pinocchio()
    data, rotor = model.createData(), arm.rotor()
    if setup.wide:
        styles = [wide.draw_style(rng, (0.6 * most, most)) for most in REACH]
        wanted = wanted_of(setup.motion, rng, styles, MIDDLE, longer(duration))
    else:
        columns = []
        for j in range(6):
            style = Style(
                REACH[j] * rng.uniform(0.8, 1.0), rng.uniform(0.8, 1.6), rng.uniform(4.0, 8.0), rng.uniform(0.03, 0.1)
            )
            columns.append(reference(rng, style, MIDDLE[j], duration))
        wanted = np.stack(columns, axis=1)
    v = np.gradient(wanted, 1e-3, axis=0)
    a = np.gradient(v, 1e-3, axis=0)
    forward = np.array([pin.rnea(model, data, *row) for row in zip(wanted, v, a, strict=True)]) + rotor * a
    w = 2.0 * np.pi * rng.uniform(2.0, 3.2, 6)
    return Control(wanted, setup.feedforward * forward, whole * w**2, whole * 1.6 * w, seen)


def first(control: Control, seconds: float = 12.0) -> Control:
    """The beginning of a motion, long enough to size effects by."""
    count = round(seconds * 1000)
    return dataclasses.replace(control, reference=control.reference[:count], feedforward=control.feedforward[:count])


def scale_of(
    rng: np.random.Generator, arm: SixArm, base: Truth, control: Control, j: int, whole: Array, setup: Setup
) -> sizes.Scale:
    """What sizes are shares of.

    By the beginning of the motion; in wide cases, where not all joints need move there, by what is wanted of the whole.
    """
    peak, speed = np.abs(base.tau).max(axis=0), np.abs(base.y[:, 18:24]).max(axis=0)
    wind = np.abs(base.y[:, 6:12] - base.y[:, 0:6]).max(axis=0)
    if setup.wide:
        peak = np.abs(control.feedforward[:-MARGIN]).max(axis=0) / setup.feedforward
        speed = np.abs(np.gradient(control.reference, PERIOD, axis=0)).max(axis=0)
        wind = peak / np.array(arm.stiffness)
    return sizes.Scale(
        rng=rng,
        factor=1.0,
        joint=j,
        arm=arm,
        other=j - 1,
        peak=peak,
        speed=speed,
        wind=wind,
        low=control.reference.min(axis=0),
        high=control.reference.max(axis=0),
        inertia=whole,
        tolerance=setup.tolerance,
        wide=setup.wide,
    )
