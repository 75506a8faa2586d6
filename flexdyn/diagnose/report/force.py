"""Part of report.html: force over position and speed, where a test rig prescribes the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.report.measures import Role
from flexdyn.diagnose.report.pictures import AFTER, AXIS, BEFORE, CONFIG, curve, in_columns, page_layout, titled
from flexdyn.plots.palette import INK

Array = NDArray[np.float64]
MOST_POINTS = 4000
"""Points of a loop that are drawn."""


@dataclass(frozen=True, eq=False)
class ForceLoop:
    """Recorded and simulated force of a joint over one span, where a test rig prescribes its motion.

    Attributes:
        joint: its name.
        file: name of the recording.
        role: what the span was used for.
        units: of position and force.
        columns: position, speed, recorded force, that of the model as given, that of the corrected one (5, points).
    """

    joint: str
    file: str
    role: Role
    units: tuple[str, str]
    columns: Array

    @classmethod
    def thinned(cls, joint: str, file: str, role: Role, units: tuple[str, str], columns: Array) -> ForceLoop:
        """Of long columns as many points as the eye needs, evenly."""
        every = max(1, -(-columns.shape[1] // MOST_POINTS))
        kept = np.array(columns[:, ::every])
        kept.setflags(write=False)
        return cls(joint, file, role, units, kept)


def force_figure(loop: ForceLoop) -> dict[str, Any]:
    """Data and layout for Plotly in the page: force over position to the left, over speed to the right."""
    length, unit = loop.units
    word = "force" if unit == "N" else "torque"
    data = []
    for k, axes in enumerate(({}, {"xaxis": "x2", "yaxis": "y2"})):
        for row, name, colour in ((2, "recorded", INK), (3, "as given", BEFORE), (4, "corrected", AFTER)):
            data.append(curve(loop.columns[k], loop.columns[row], name, colour, lines=True) | axes)
    layout = page_layout(330, {"l": 62, "r": 10, "t": 8, "b": 44}) | {
        "xaxis": {**AXIS, "domain": [0.0, 0.47], "title": titled(f"position [{length}]")},
        "xaxis2": {**AXIS, "domain": [0.53, 1.0], "anchor": "y2", "title": titled(f"speed [{length}/s]")},
        "yaxis": {**AXIS, "title": titled(f"{word} [{unit}]")},
        "yaxis2": {**AXIS, "anchor": "x2", "matches": "y", "showticklabels": False},
        "showlegend": False,
    }
    return {**in_columns(data), "layout": layout, "config": CONFIG}
