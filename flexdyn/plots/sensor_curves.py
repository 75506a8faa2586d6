"""Curves of delays and of sensor errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flexdyn.effects import ChannelLag, CommandDelay, SensorEffect
from flexdyn.plots.friction_curves import turn
from flexdyn.plots.page import BLUE, GREY, LAW_LINE_WIDTH, SHORT_DASHES, beside, cross, legend_above, line

VISIBLE = 0.02
"""Smaller errors, relative to the measured value, are drawn separately [1]."""


def delayed_command(axes: Any, effect: CommandDelay) -> tuple[str, str]:
    """The response to a step of the commanded torque."""
    end = 4.0 * effect.delay
    asked, given = [-0.5 * end, 0.0, end], [-0.5 * end, effect.delay, end]
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=1.0)
    step = [0.0, 1.0, 1.0]
    axes.step(asked, step, where="post", color=GREY, linewidth=1.4, linestyle=SHORT_DASHES, label=r"asked: $\tau$")
    axes.step(given, step, where="post", color=BLUE, linewidth=LAW_LINE_WIDTH, label=r"given: $\tau_\mathrm{applied}$")
    axes.legend(frameon=False, loc="center right")
    return "time $t$ [s]", "motor torque [N m]"


def measured(axes: Any, effect: SensorEffect) -> tuple[str, str]:
    """Measured over true value; only the error if it is too small to see; over time for a delay."""
    if isinstance(effect, ChannelLag):
        return _late(axes, effect)
    lengths = [abs(getattr(effect, field.name)) for field in effect.parameters() if field.metadata["unit"] != "1"]
    turns = any(field.name == "harmonic" for field in effect.parameters())
    reach = 0.5 * turn(effect) if turns or not any(lengths) else 5.0 * max(lengths)
    true = np.linspace(-reach, reach, 801)
    reported = effect.measured(true, np.arange(801.0))
    cross(axes)
    if np.abs(reported - true).max() < VISIBLE * reach:
        line(axes, true, reported - true)
        return "true position [rad]", "measured - true [rad]"
    beside(axes, true, "true", reported, "measured")
    return "true position [rad]", "measured position [rad]"


def _late(axes: Any, effect: ChannelLag) -> tuple[str, str]:
    """An oscillating position, and the reading of the sensor."""
    t = np.linspace(0.0, 20.0 * effect.delay, 1201)
    true = np.sin(2.0 * math.pi * t / (10.0 * effect.delay))
    axes.axhline(0.0, color="#111827", linewidth=0.7, zorder=1.0)
    axes.plot(t, true, color=GREY, linewidth=1.4, linestyle=SHORT_DASHES, label="true")
    line(axes, t, effect.measured(true, t), label="measured")
    legend_above(axes, 2)
    return "time $t$ [s]", "position [rad]"
