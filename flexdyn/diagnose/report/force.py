"""Part of report.html: force over position and speed, where a test rig prescribes the motion."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.report.digits import percent, rounded
from flexdyn.diagnose.report.html import section, soft, table
from flexdyn.diagnose.report.measures import JointError, Role
from flexdyn.diagnose.report.pictures import AFTER, BEFORE, CONFIG, FONT, curve, in_columns
from flexdyn.plots.palette import INK, RULE

if TYPE_CHECKING:
    from flexdyn.diagnose.report.result import Diagnosis

Array = NDArray[np.float64]
MOST_POINTS = 4000
"""Points of a loop that are drawn."""
ROLES = {"test": "test data", "fit": "data of the fit"}


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


def forces(diagnosis: Diagnosis) -> str:
    """Errors of the forces, and room for the pictures."""
    told = {joint: entry for joint, entry in diagnosis.errors.items() if entry.force}
    if not told:
        return ""
    rows = [_row(joint, entry) for joint, entry in told.items()]
    heads = ("joint", "force error,<br>as given", "calibrated", "corrected", "recorded", "corrected / recorded")
    said = (
        "A test rig prescribes the motion of these joints, so no position is simulated. Each model's force is computed"
        " along the recorded motion, with the states of its laws and of what moves behind a spring, from the start of"
        " the recording; the error is that force less the recorded one. Root mean squares over all test data, at the"
        " full rate."
    )
    rooms = "".join(
        f"<figure><h4>{escape(f'{each.joint}, {ROLES[each.role]}: {each.file}')}</h4>"
        f'<div id="force-{k}" data-picture></div></figure>'
        for k, each in enumerate(diagnosis.loops)
    )
    key = (
        '<p><i class="key" style="--colour:#111827"></i>recorded &emsp;'
        '<i class="key" style="--colour:var(--before)"></i>model as given '
        '&emsp;<i class="key" style="--colour:var(--after)"></i>corrected model</p>'
    )
    return section(
        "Force of the prescribed motion", table(heads, rows, name="forces") + soft(said) + key + rooms, "force"
    )


def _row(joint: str, entry: JointError) -> list[str]:
    before, calibrated, after, size = entry.force
    share = percent(after / size) if size > 0.0 else "-"
    numbers = (f"{rounded(x)} {escape(entry.torque_unit)}" for x in (before, calibrated, after, size))
    return [escape(joint), *numbers, share]


def force_figure(loop: ForceLoop) -> dict[str, Any]:
    """Data and layout for Plotly in the page: force over position to the left, over speed to the right."""
    length, unit = loop.units
    word = "force" if unit == "N" else "torque"
    data = []
    for k, axes in enumerate(({}, {"xaxis": "x2", "yaxis": "y2"})):
        for row, name, colour in ((2, "recorded", INK), (3, "as given", BEFORE), (4, "corrected", AFTER)):
            data.append(curve(loop.columns[k], loop.columns[row], name, colour, lines=True) | axes)
    axis = {"gridcolor": RULE, "zeroline": False, "automargin": True, "tickfont": {"size": 11}}
    layout = {
        "height": 330,
        "margin": {"l": 62, "r": 10, "t": 8, "b": 44},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "font": {"family": FONT, "size": 12, "color": INK},
        "xaxis": {**axis, "domain": [0.0, 0.47], "title": {"text": f"position [{length}]", "standoff": 6}},
        "xaxis2": {
            **axis,
            "domain": [0.53, 1.0],
            "anchor": "y2",
            "title": {"text": f"speed [{length}/s]", "standoff": 6},
        },
        "yaxis": {**axis, "title": {"text": f"{word} [{unit}]"}},
        "yaxis2": {**axis, "anchor": "x2", "matches": "y", "showticklabels": False},
        "showlegend": False,
        "hovermode": "closest",
    }
    return {**in_columns(data), "layout": layout, "config": CONFIG}
