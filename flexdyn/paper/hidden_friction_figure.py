"""Figure of the diagnosis: measured and simulated motion, and the gap after each added effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.paper import style
from flexdyn.records import Recording
from flexdyn.simulation.simulate import simulate

MEASURED = {"color": "#9A9A9A", "linestyle": "-", "linewidth": 3.2, "label": "measured", "solid_capstyle": "butt"}
GIVEN = {"color": style.VERMILION, "linestyle": (0, (4, 1.6)), "linewidth": 1.1, "label": "model as given"}
FOUND = {"color": style.BLUE, "linestyle": "-", "linewidth": 1.0, "label": "with what was found"}


@dataclass(frozen=True)
class Step:
    """The gap on the test data after one more effect is added to the model.

    Attributes:
        name: of the added effect.
        gap: in units of noise.
    """

    name: str
    gap: float


def draw_hidden_friction(
    canvas: Any, measured: Recording, given: FlexibleJointModel, found: FlexibleJointModel, steps: Sequence[Step]
) -> None:
    """Draw it into an empty figure.

    Args:
        canvas: the figure.
        measured: a recording that begins at rest.
        given: the model as it was.
        found: the corrected one.
        steps: the gap from the model as given to noise alone.
    """
    grid = canvas.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
    panels = [canvas.add_subplot(grid[row, 0]) for row in (0, 1)]
    panels[0].sharex(panels[1])
    panels[0].tick_params(labelbottom=False)
    runs = [simulate(model, measured, measured.t[-1], rate=250.0) for model in (given, found)]
    for j, (panel, joint) in enumerate(zip(panels, given.joint_names, strict=True)):
        panel.plot(measured.t, np.degrees(measured[f"q.{joint}"]), **MEASURED)
        for run, look in zip(runs, (GIVEN, FOUND), strict=True):
            panel.plot(run.t, np.degrees(run.q[:, j]), **look)
        style.titled(panel, "ab"[j], f"{joint}, open loop under the torque of Fig. 4")
        panel.set(ylabel=f"$q_{j + 1}$ (deg)", xlim=(0.0, measured.t[-1]))
        style.torque_on(panel)
    panels[0].legend(loc="best", ncols=1)
    panels[1].set_xlabel("time (s)")
    _staircase(canvas.add_subplot(grid[:, 1]), steps)


def _staircase(panel: Any, steps: Sequence[Step]) -> None:
    """One bar for each step on a logarithmic axis; the gap of noise alone is a line."""
    *bars, floor = steps
    rows = np.arange(len(bars))
    colours = [style.VERMILION, style.ORANGE, *[style.SKY] * (len(bars) - 3), style.BLUE][: len(bars)]
    panel.barh(rows, [step.gap for step in bars], color=colours, height=0.62, left=0.0)
    for row, step in enumerate(bars):
        panel.text(step.gap * 1.12, row, f"{step.gap:.3g}", va="center", fontsize=8)
    panel.axvline(floor.gap, color=style.BLACK, linestyle=(0, (3, 2)), linewidth=0.9)
    panel.set(xscale="log", xlim=(0.5, 6.0 * max(step.gap for step in bars)), yticks=rows)
    panel.set_yticklabels([step.name for step in bars])
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.grid(axis="y", visible=False)
    panel.set_xlabel("gap (dashed: noise alone)")
    style.titled(panel, "c", "the gap on data not used in the fit")
