"""Curves of friction: smooth, set-valued, with memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import CouplingEffect, Effect, JointEffect, MemoryEffect
from flexdyn.plots.page import BLUE, GREY, PALE, RED, SHADES, cross, legend, legend_above, line

VELOCITY = "velocity $u$ of the link or rotor [rad/s]"
FRICTION = "friction torque [N m]"
WAVES = 8.0
"""Largest number of cycles of a periodic law that are drawn: more of them could not be distinguished."""


def span(effect: Effect, factor: float) -> float:
    """End of a velocity axis: a multiple of the law's own speed, or 1 rad/s."""
    speeds = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["unit"] == "rad/s"]
    return factor * max(speeds) if speeds else 1.0


def turn(effect: Effect) -> float:
    """End of an angle axis: one turn, or as many cycles of the law as can be distinguished [rad]."""
    cycles = float(getattr(effect, effect.cycles)) if effect.cycles else 1.0
    return 2.0 * math.pi * min(1.0, WAVES / max(abs(cycles), 1e-9))


def varies(law: Callable[[Array], Any], reach: float) -> bool:
    """Whether a law depends on an argument."""
    return bool(np.ptp(np.asarray(law(np.linspace(-reach, reach, 41)), dtype=float)) > 0.0)


def smooth(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """Torque over velocity; if it changes with time, at several times."""
    reach = span(effect, 6.0)
    u = np.linspace(-reach, reach, 801)
    durations = [getattr(effect, field.name) for field in effect.parameters() if field.metadata["unit"] == "s"]
    cross(axes)
    if durations:
        for share, shade in zip((0.0, 0.5, 1.0, 2.0, 4.0), SHADES[::-1], strict=True):
            t = share * durations[0]
            line(axes, u, effect.torque(0.0, u, t=t), color=shade, label=f"t = {t:g} s")
        legend(axes, "since the start")
    else:
        line(axes, u, effect.torque(0.0, u))
    if isinstance(effect, CouplingEffect):
        return r"rotor velocity $\omega$ of the other joint [rad/s]", "torque against this rotor [N m]"
    return VELOCITY, FRICTION


def dry(axes: Any, effect: JointEffect) -> tuple[str, str]:
    """A set-valued law: at rest every torque between two ends, in motion one end; over the variable of the level."""
    if varies(lambda x: effect.torque(x, 1.0), 0.5 * turn(effect)):
        x = np.linspace(0.0, turn(effect), 801)
        _band(axes, x, effect.torque(x, 1.0), effect.torque(x, -1.0))
        return "position $x$ of the link or rotor [rad]", FRICTION
    if varies(lambda tau: effect.torque(0.0, 1.0, tau=tau), 1.0):
        tau = np.linspace(-10.0, 10.0, 801)
        _band(axes, tau, effect.torque(0.0, 1.0, tau=tau), effect.torque(0.0, -1.0, tau=tau))
        return r"transmission torque $\tau_s$ [N m]", FRICTION
    reach = span(effect, 6.0)
    right = np.concatenate([[reach * 1e-9], np.linspace(0.0, reach, 801)[1:]])
    upper, lower = effect.torque(0.0, right), effect.torque(0.0, -right)
    cross(axes)
    line(axes, right, upper)
    line(axes, -right, lower)
    axes.plot([0.0, 0.0], [lower[0], upper[0]], color=RED, linewidth=2.6, solid_capstyle="butt", zorder=3)
    axes.annotate(
        "at rest: any torque\nbetween the two ends",
        (0.0, 0.45 * lower[0]),
        (0.16 * reach, 0.6 * lower[0]),
        color=RED,
        va="center",
        arrowprops={"arrowstyle": "-", "color": RED, "linewidth": 0.8, "shrinkB": 2.0},
    )
    return VELOCITY, FRICTION


def _band(axes: Any, x: Array, upper: Array, lower: Array) -> None:
    axes.fill_between(x, lower, upper, color=PALE, linewidth=0.0, label="at rest: any of these")
    line(axes, x, upper, label="$u > 0$")
    line(axes, x, lower, color=RED, label="$u < 0$")
    axes.axhline(0.0, color="#111827", linewidth=0.7)
    legend_above(axes, 3)


def loop(axes: Any, effect: MemoryEffect) -> tuple[str, str]:
    """Torque over a path that goes out, back and out again, with one additional reversal."""
    path = effect.example_path()
    torque = effect.along(path)
    rise = len(path) // 5  # the path has five legs; the first one starts from rest
    cross(axes)
    line(axes, path[: rise + 1], torque[: rise + 1], color=GREY, linestyle=(0, (2, 1.2)))
    line(axes, path[rise:], torque[rise:])
    for share in (0.1, 0.3, 0.5, 0.7):
        k = int(share * len(path))
        ends = [(path[i], torque[i]) for i in (k + len(path) // 60, k)]
        arrow = {"arrowstyle": "-|>", "color": GREY if share < 0.2 else BLUE, "mutation_scale": 16.0}
        axes.annotate("", ends[0], ends[1], arrowprops=arrow)
    axes.margins(x=0.04, y=0.12)
    axes.annotate("from rest", (path[rise // 6], torque[rise // 6]), (10, -4), textcoords="offset points", color=GREY)
    axes.locator_params(axis="x", nbins=7)
    if effect.sides == ("transmission",):
        return r"deflection $\delta$ [rad]", "torque in the transmission [N m]"
    return "position $x$ of the link or rotor [rad]", FRICTION
