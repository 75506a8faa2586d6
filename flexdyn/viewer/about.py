"""Data for the page's script besides the scene: texts, numbers of the table, ground and point of view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.viewer.dials import NEEDLE
from flexdyn.viewer.frames import Frames
from flexdyn.viewer.layout import Extent
from flexdyn.viewer.page import floats
from flexdyn.viewer.scene import ARM, BLUE, GHOST, SILVER, VIOLET

COLUMNS = {"q": "q", "deflection": "\u03b8 \u2212 q", "difference": "\u0394q"}
"""Heads of the page's table by series."""
GHOSTLY = {
    "color": int(VIOLET[1:], 16),
    "opacity": 0.42,
    "transparent": True,
    # Where both arms coincide, the solid one is drawn in front, to avoid flicker.
    "polygonOffset": True,
    "polygonOffsetFactor": 4,
    "polygonOffsetUnits": 800,
}
"""The second arm's material, as three.js describes it."""


def about_it(
    model: FlexibleJointModel, frames: Frames, size: float, box: Extent, tips: Sequence[Array]
) -> dict[str, Any]:
    """Time, table and view.

    Args:
        model: of the arm.
        frames: its motion.
        size: of the arm [m].
        box: that contains it at all times.
        tips: paths of the tip, of the second arm too if there is one.
    """
    times, series = frames.arm.t, _series(frames, tips)
    return {
        "size": size,
        "grid": _grid(size, box),
        "box": {"low": box.low.tolist(), "high": box.high.tolist()},
        "view": _view(box),
        "start": float(times[0]),
        "duration": float(times[-1] - times[0]),
        "rate": frames.rate,
        "ghost": None if frames.ghost is None else {"material": GHOSTLY},
        "joints": _rows(model),
        "columns": [name for name in COLUMNS if name in series],
        "heads": ["joint", *(_head(name, model) for name in COLUMNS if name in series)],
        "series": series,
    }


def legend(frames: Frames, frame: str, factors: Mapping[str, float], dials: Sequence[str]) -> dict[str, Any]:
    """The parts of the picture, each with the nodes of the scene that its check box hides.

    Args:
        frames: motions of the arms.
        frame: name of the tip.
        factors: magnification by unit.
        dials: nodes of the dials.
    """
    entries: list[tuple[str, str, list[str]]] = [(SILVER, f"arm: {frames.arm.label}", [ARM])]
    second, traces = "", ["trace"]
    if frames.ghost is not None:
        entries.append((VIOLET, f"translucent: {frames.ghost.label}", [GHOST]))
        second, traces = ", in violet that of the translucent arm", ["trace", "ghost_trace"]
    if factors:
        entries.append((NEEDLE, f"rotor against the mark of its link; {_magnified(factors)}", list(dials)))
    if len(frames.arm.t) > 1:
        entries.append((BLUE, f"path of {frame}{second}", traces))
    shown = [{"color": color, "text": text, "paths": paths} for color, text, paths in entries]
    return {"legend": shown, "magnified": _magnified(factors)}


def _magnified(factors: Mapping[str, float]) -> str:
    """The text about magnification; empty if nothing is magnified."""
    several = len(factors) > 1
    each = [f"{factor:g}\u00d7{f' [{unit}]' if several else ''}" for unit, factor in factors.items()]
    return f"\u03b8 \u2212 q magnified {' and '.join(each)}" if each else ""


def _series(frames: Frames, tips: Sequence[Array]) -> dict[str, str]:
    """Numbers of the table, frame by frame, and the distance of the tips [m]."""
    found = {"q": floats(frames.arm.q)}
    if np.isfinite(frames.arm.deflection).any():
        found["deflection"] = floats(frames.arm.deflection)
    if frames.ghost is not None:
        found["difference"] = floats(frames.ghost.q - frames.arm.q)
        found["gap"] = floats(np.linalg.norm(tips[1] - tips[0], axis=1))
    return found


def _rows(model: FlexibleJointModel) -> list[str]:
    """Names of the joints, with the unit if the joints have different units."""
    mixed = len(set(model.robot.kinds)) > 1
    prismatic = [kind == "prismatic" for kind in model.robot.kinds]
    return [
        f"{name} [m]" if mixed and slides else name for name, slides in zip(model.joint_names, prismatic, strict=True)
    ]


def _head(name: str, model: FlexibleJointModel) -> str:
    units = dict.fromkeys(model.robot.angle_unit(j) for j in range(model.n))
    thousandth = "" if name == "q" else "m"
    return f"{COLUMNS[name]} [{', '.join(thousandth + unit for unit in units)}]"


def _grid(size: float, box: Extent) -> dict[str, float]:
    """A grid with cells of 1, 2, 5, ..., at most a quarter of the arm; on the ground, or below the lowest part."""
    power = 10.0 ** np.floor(np.log10(size / 4.0))
    cell = max(step * power for step in (1, 2, 5) if step * power <= size / 4.0)
    return {"cell": float(cell), "height": min(0.0, float(box.low[2]))}


def _view(box: Extent) -> list[float]:
    """The point of view; for a motion in a plane it is in front of that plane."""
    wide = box.high - box.low
    thin = int(np.argmin(wide))
    if wide[thin] > 0.3 * np.median(wide):
        return [1.0, -1.3, 0.9]
    return [[1.6, -0.6, 0.5], [0.5, -1.6, 0.5], [0.2, -0.9, 1.3]][thin]
