"""Curves of transmissions, links, motors and sensors."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import DeflectionEffect, JointEffect, SensorEffect
from flexdyn.plots import page
from flexdyn.plots.friction_curves import span, turn, varies

ASKED = (-1.2, -0.6, 0.0, 0.6, 1.2)
"""Commanded torques in the pictures of actuator effects [N m]."""
DEFLECTION = 0.01
"""Deflection of springs in the pictures [rad]."""
VISIBLE = 0.02
"""Smaller errors, relative to the measured value, are drawn separately [1]."""


def spring(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """Torque over the deflection or its rate."""
    page.cross(axes)
    if varies(lambda x: effect.torque(x, 0.0), DEFLECTION):
        delta = np.linspace(-DEFLECTION, DEFLECTION, 801)
        page.line(axes, delta, effect.torque(delta, 0.0))
        return r"deflection $\delta = \theta - q$ [rad]", "torque in the transmission [N m]"
    rate = np.linspace(-1.0, 1.0, 801) * span(effect, 6.0)
    page.line(axes, rate, effect.torque(0.0, rate))
    return r"$\omega - v$ [rad/s]", "torque in the transmission [N m]"


def deflection(axes: Any, effect: DeflectionEffect) -> tuple[str, str]:
    """The deflection that the springs receive over the true one, or its change over the rotor's angle."""
    page.cross(axes)
    if varies(lambda theta: effect.deflection(0.0, theta), 0.5 * turn(effect)):
        theta = np.linspace(0.0, turn(effect), 1201)
        page.line(axes, theta, effect.deflection(0.0, theta))
        return r"rotor position $\theta$ [rad]", r"added to the deflection $\delta$ [rad]"
    lengths = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["unit"] == "rad"]
    reach = 3.0 * max(lengths, default=DEFLECTION)
    delta = np.linspace(-reach, reach, 1201)
    page.against_identity(axes, delta, "without", effect.deflection(delta), "with it")
    return r"$\delta = \theta - q$ [rad]", "deflection that the spring sees [rad]"


def link(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """Torque on the link over its position, at several speeds where it depends on speed."""
    limits = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["infinite"]]
    stops = [abs(end) for end in limits if math.isfinite(end)]
    reach = 1.3 * max(stops) if stops else math.pi
    q = np.linspace(-reach, reach, 1201)
    page.cross(axes)
    if not varies(lambda v: effect.torque(q[-1], v), 1.0):
        page.line(axes, q, effect.torque(q, 0.0))
    else:
        for v, shade in zip((3.0, 0.0, -3.0), (page.RED, page.GREY, page.BLUE), strict=True):
            page.line(axes, q, effect.torque(q, v), color=shade, label=f"v = {v:g} rad/s")
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
    page.cross(axes)
    tau = np.linspace(ASKED[0], ASKED[-1], 801)
    page.against_identity(axes, tau, "without", effect.torque(0.0, 0.0, tau=tau), "with it")
    return r"commanded torque $\tau$ [N m]", up


def _family(axes: Any, effect: JointEffect, across: Array, state: tuple[Any, Any]) -> None:
    """One curve for each commanded torque, which is drawn dashed."""
    page.cross(axes)
    for tau, shade in zip(ASKED, page.SHADES, strict=True):
        axes.axhline(tau, color=shade, linewidth=0.8, linestyle=page.GUIDE_DASHES)
        page.line(axes, across, effect.torque(*state, tau=tau), color=shade, label=f"{tau:g} N m")
    page.legend(axes, "asked (dashed)", upside_down=True)


def delayed_command(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """The response to a step of the commanded torque."""
    end = 4.0 * effect.lateness
    asked, given = [-0.5 * end, 0.0, end], [-0.5 * end, effect.lateness, end]
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=1.0)
    axes.step(asked, [0.0, 1.0, 1.0], where="post", label=r"asked: $\tau$", **page.GUIDE)
    law = {"color": page.BLUE, "linewidth": page.LAW_LINE_WIDTH}
    axes.step(given, [0.0, 1.0, 1.0], where="post", label=r"given: $\tau_\mathrm{applied}$", **law)
    axes.legend(frameon=False, loc="center right")
    return "time $t$ [s]", "motor torque [N m]"


def sensor_curve(axes: Any, effect: SensorEffect) -> tuple[str, str]:
    """Measured over true value; only the error if it is too small to see; over time for a delay."""
    if effect.late_by:
        return _late(axes, effect)
    lengths = [abs(getattr(effect, field.name)) for field in effect.parameters() if field.metadata["unit"] != "1"]
    reach = 0.5 * turn(effect) if effect.cycles or not any(lengths) else 5.0 * max(lengths)
    true = np.linspace(-reach, reach, 801)
    reported = effect.measured(true, np.arange(801.0))
    page.cross(axes)
    if np.abs(reported - true).max() < VISIBLE * reach:
        page.line(axes, true, reported - true)
        return "true position [rad]", "measured - true [rad]"
    page.against_identity(axes, true, "true", reported, "measured")
    return "true position [rad]", "measured position [rad]"


def _late(axes: Any, effect: SensorEffect) -> tuple[str, str]:
    """An oscillating position, and the reading of the sensor."""
    t = np.linspace(0.0, 20.0 * effect.lateness, 1201)
    true = np.sin(2.0 * math.pi * t / (10.0 * effect.lateness))
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=1.0)
    axes.plot(t, true, label="true", **page.GUIDE)
    page.line(axes, t, effect.measured(true, t), label="measured")
    page.legend_above(axes, 2)
    return "time $t$ [s]", "position [rad]"
