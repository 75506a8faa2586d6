"""Curves of transmissions, links and motors."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import DeflectionEffect, JointEffect
from flexdyn.plots.friction_curves import span, turn, varies
from flexdyn.plots.page import BLUE, GREY, RED, SHADES, SHORT_DASHES, beside, cross, legend, line

ASKED = (-1.2, -0.6, 0.0, 0.6, 1.2)
"""Commanded torques in the pictures of actuator effects [N m]."""
DEFLECTION = 0.01
"""Deflection of springs in the pictures [rad]."""


def spring(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """Torque over the deflection or its rate."""
    cross(axes)
    if varies(lambda x: effect.torque(x, 0.0), DEFLECTION):
        delta = np.linspace(-DEFLECTION, DEFLECTION, 801)
        line(axes, delta, effect.torque(delta, 0.0))
        return r"deflection $\delta = \theta - q$ [rad]", "torque in the transmission [N m]"
    rate = np.linspace(-1.0, 1.0, 801) * span(effect, 6.0)
    line(axes, rate, effect.torque(0.0, rate))
    return r"$\omega - v$ [rad/s]", "torque in the transmission [N m]"


def deflection(axes: Any, effect: DeflectionEffect) -> tuple[str, str]:
    """The deflection that the springs receive over the true one, or its change over the rotor's angle."""
    cross(axes)
    if varies(lambda theta: effect.deflection(0.0, theta), 0.5 * turn(effect)):
        theta = np.linspace(0.0, turn(effect), 1201)
        line(axes, theta, effect.deflection(0.0, theta))
        return r"rotor position $\theta$ [rad]", r"added to the deflection $\delta$ [rad]"
    lengths = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["unit"] == "rad"]
    reach = 3.0 * max(lengths, default=DEFLECTION)
    delta = np.linspace(-reach, reach, 1201)
    beside(axes, delta, "without", effect.deflection(delta), "with it")
    return r"$\delta = \theta - q$ [rad]", "deflection that the spring sees [rad]"


def link(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """Torque on the link over its position, at several speeds where it depends on speed."""
    stops = [abs(end) for end in (getattr(effect, key, math.inf) for key in ("lower", "upper")) if math.isfinite(end)]
    reach = 1.3 * max(stops) if stops else math.pi
    q = np.linspace(-reach, reach, 1201)
    cross(axes)
    if not varies(lambda v: effect.torque(q[-1], v), 1.0):
        line(axes, q, effect.torque(q, 0.0))
    else:
        for v, shade in zip((3.0, 0.0, -3.0), (RED, GREY, BLUE), strict=True):
            line(axes, q, effect.torque(q, v), color=shade, label=f"v = {v:g} rad/s")
        axes.legend(frameon=False)
    return "link position $q$ [rad]", "torque on the link [N m]"


def actuator(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """tau_applied over the rotor's speed or angle for several commanded torques, else over the commanded torque."""
    over_speed = any(varies(partial(effect.torque, 0.0, tau=tau), span(effect, 1.3)) for tau in ASKED)
    over_angle = any(varies(partial(effect.torque, u=0.0, tau=tau), 0.5 * turn(effect)) for tau in ASKED)
    up = r"$\tau_\mathrm{applied}$ [N m]"
    if over_speed:
        omega = np.linspace(-1.0, 1.0, 801) * span(effect, 1.3)
        _family(axes, effect, omega, (0.0, omega))
        return r"rotor velocity $\omega$ [rad/s]", up
    if over_angle:
        theta = np.linspace(0.0, turn(effect), 801)
        _family(axes, effect, theta, (theta, 0.0))
        return r"rotor position $\theta$ [rad]", up
    cross(axes)
    tau = np.linspace(ASKED[0], ASKED[-1], 801)
    beside(axes, tau, "without", effect.torque(0.0, 0.0, tau=tau), "with it")
    return r"commanded torque $\tau$ [N m]", up


def _family(axes: Any, effect: JointEffect, across: Array, state: tuple[Any, Any]) -> None:
    """One curve for each commanded torque, which is drawn dashed."""
    cross(axes)
    for tau, shade in zip(ASKED, SHADES, strict=True):
        axes.axhline(tau, color=shade, linewidth=0.8, linestyle=SHORT_DASHES)
        line(axes, across, effect.torque(*state, tau=tau), color=shade, label=f"{tau:g} N m")
    legend(axes, "asked (dashed)", upside_down=True)
