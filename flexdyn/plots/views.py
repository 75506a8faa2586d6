"""Views of a motion: the signals in each panel, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.comparison.difference import Difference, difference
from flexdyn.plots.arrange import Block
from flexdyn.plots.palette import INK, shade
from flexdyn.plots.panel import TIME, Curve, Key, Panel, limits, short
from flexdyn.plots.scene import DEFLECTION, PlotScene, SignalTrace
from flexdyn.plots.thinning import curve_over_time
from flexdyn.records.units import HELD

RESIDUAL = "residual"


@dataclass(frozen=True)
class View:
    """A panel of every joint.

    Attributes:
        up: quantity of the vertical axis.
        traces: the signals in it.
        across: quantity of the horizontal axis; empty: time.
    """

    up: str
    traces: tuple[SignalTrace, ...]
    across: str = ""


VIEWS: dict[str, View] = {
    "positions": View(
        "position",
        (SignalTrace("q", "q: link"), SignalTrace("theta", "theta: rotor, reflected", "dashed")),
    ),
    "velocities": View(
        "velocity",
        (SignalTrace("v", "v: link"), SignalTrace("omega", "omega: rotor, reflected", "dashed")),
    ),
    "deflection": View("theta - q", (SignalTrace(DEFLECTION, "theta - q: deflection"),)),
    "torques": View(
        "torque",
        (
            SignalTrace("tau", "tau: commanded"),
            SignalTrace("tau_applied", "tau_applied: after the actuator's effects", "dotted"),
            SignalTrace("tau_s", "tau_s: in the transmission", "dashed"),
        ),
    ),
    "phase": View(
        "velocity",
        (
            SignalTrace("v", "v over q: link", across="q"),
            SignalTrace("omega", "omega over theta: rotor", "dashed", across="theta"),
        ),
        "position",
    ),
    "loops": View(
        "tau_s",
        (SignalTrace("tau_s", "tau_s over theta - q", across=DEFLECTION),),
        "theta - q",
    ),
    "temperature": View("temperature", (SignalTrace("temperature", "temperature"),)),
}
"""Views that have a panel for every joint, by the names that `plot` and ``--view`` take."""


def shows(scene: PlotScene, view: View) -> bool:
    """Whether any joint of any motion has a signal for it."""
    return any(panel_of(scene, view, joint) is not None for joint in scene.joints)


def panel_of(scene: PlotScene, view: View, joint: str) -> Panel | None:
    """One view of one joint; None if no motion has the signals."""
    found = [
        (place, trace)
        for place in range(len(scene.sources))
        for trace in view.traces
        if scene.has(place, trace.up, joint) and (not trace.across or scene.has(place, trace.across, joint))
    ]
    if not found:
        return None
    # Measured curves are lowest, so that the thin lines of simulations stay visible.
    found.sort(key=lambda entry: not scene.sources[entry[0]].measured)
    curves = tuple(scene.curve(place, trace, joint) for place, trace in found)
    first = found[0][1]
    across = f"{view.across} [{scene.unit(first.across, joint)}]" if view.across else TIME
    unit = scene.unit(first.up, joint)
    up = "force" if view.up == "torque" and unit == "N" else view.up
    return Panel(
        short(joint),
        across,
        f"{up} [{unit}]",
        curves,
        x_range=limits(*(curve.x for curve in curves)) if view.across else scene.span,
        y_range=limits(*(curve.y for curve in curves)),
        colour=scene.hue(joint),
        timed=not view.across,
    )


def residual_of(scene: PlotScene, view: View, joint: str) -> Panel | None:
    """The differences of the other motions from the first over time; None if there is nothing to subtract."""
    curves, said, unit = [], [], ""
    for trace in view.traces:
        name = f"{trace.up}.{joint}"
        rms = []
        for place in range(1, len(scene.sources)):
            found = _difference(scene, place, name) if scene.has(place, trace.up, joint) else None
            if found is not None:
                rms.append(found.rms)
                curves.append(_residual_curve(scene, place, trace, joint, found))
        if rms:
            unit = scene.unit(trace.up, joint)
            label = "theta - q" if trace.up == DEFLECTION else trace.up
            said.append(f"{label} {_in_few(rms)}")
    if not curves:
        return None
    reach = limits(*(curve.y for curve in curves), np.zeros(1))
    title, up = f"RMS {', '.join(said)} {unit}", f"{RESIDUAL} [{unit}]"
    return Panel.over_time(title, up, curves, scene.span, y_range=reach, colour=INK, level=True)


def keys_of(scene: PlotScene, views: Sequence[View], panels: Sequence[Panel | None]) -> tuple[Key, ...]:
    """The legend of these panels: a line for each kind of signal, then one for each motion."""
    drawn = {curve.name.partition(".")[0] for panel in panels if panel is not None for curve in panel.curves}
    traces = [trace for view in views for trace in view.traces if trace.up in drawn]
    return tuple(dict.fromkeys(Key(trace.label, INK, trace.dash) for trace in traces)) + scene.source_keys


def grid(panels: Sequence[Panel], columns: int, width: float, height: float) -> Block:
    """Panels of one view, joint after joint, in rows and columns."""
    cells: list[Panel | None] = [*panels, *[None] * (-len(panels) % columns)]
    last = len(panels) - columns
    cells = [panel and replace(panel, labelled=not panel.timed or place >= last) for place, panel in enumerate(cells)]
    rows = tuple(tuple(cells[first : first + columns]) for first in range(0, len(cells), columns))
    return Block(rows, (height,) * len(rows), width)


def _in_few(rms: Sequence[float]) -> str:
    """One number, or a range from the smallest to the largest."""
    least, greatest = f"{min(rms):.4g}", f"{max(rms):.4g}"
    return least if least == greatest else f"{least} to {greatest}"


def _difference(scene: PlotScene, place: int, channel: str) -> Difference | None:
    one, two, rows = scene.sources[0], scene.sources[place], scene.common[place]
    return difference(one, two, channel, rows) if rows is not None and channel in one.recording else None


def _residual_curve(scene: PlotScene, place: int, trace: SignalTrace, joint: str, found: Difference) -> Curve:
    source, colour = scene.sources[place], shade(scene.hue(joint), scene.sources, place)
    name = f"{trace.up}.{joint}, {source.name} less {scene.sources[0].name}"
    look = {"dash": trace.dash, "width": 1.1, "held": trace.up in HELD}
    return curve_over_time(found.t, found.error, name, source.name, colour, **look)
