"""Chapter: the paper does not give the rotor inertia; which conclusions hold for any value?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.paper import style
from flexdyn.paper.cases import PaperCases, bang_bang
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.damping import ELBOW, SWEEP
from flexdyn.paper.vibration import Residual, paper_modes, residual, ringing_after, slowest_rates

INERTIAS = (0.01, 0.1, 1.0)  # kg m^2, reflected
COMPARED_DAMPINGS = (0.01, 0.1, 0.5)  # N m s/rad
INERTIA_LOOKS: tuple[Any, ...] = ((style.VERMILION, style.DASHED), (style.BLUE, "-"), (style.GREEN, style.DOTTED))


@dataclass(frozen=True)
class Row:
    """The results for one rotor inertia.

    Attributes:
        J: [kg m^2].
        frequencies: of the undamped vibrations at the pose of Table I [Hz].
        ringing: of the rigid arm over that of the flexible one, after the torque [1].
        residuals: by damping v.
        best_v: at which the slower vibration decays fastest [N m s/rad].
    """

    J: float
    frequencies: tuple[float, ...]
    ringing: float
    residuals: dict[float, Residual]
    best_v: float


def rotor_inertia(cases: PaperCases) -> Chapter:
    """Residual vibration for three rotor inertias a decade apart."""
    rows = [_row(cases, J) for J in INERTIAS]
    parts = [[row.residuals[v].left for v in COMPARED_DAMPINGS] for row in rows]
    shares = [ratio for part in parts for ratio in np.divide(part[1:], part[:-1])]
    checks = (stated("inertia_oscillation", max(row.ringing for row in rows)), stated("inertia_damping", max(shares)))
    numbers = {
        f"{row.J:g}": {
            "frequencies_hz": list(row.frequencies),
            "best_v": row.best_v,
            "residual": {f"{v:g}": each.to_dict() for v, each in row.residuals.items()},
        }
        for row in rows
    }
    text = prose("rotor_inertia.md", rows=rows, compared=COMPARED_DAMPINGS, J=cases.arm().J)
    picture = figure("rotor_inertia", lambda canvas: _draw_slowest_rates(canvas, cases, rows))
    return Chapter("The rotor inertia, which the paper leaves out", text, checks, numbers, (picture,))


def _row(cases: PaperCases, J: float) -> Row:
    free = cases.viscous_model(0.0, J)
    ratio = ringing_after(bang_bang(free.rigid())) / ringing_after(bang_bang(free))
    found = {v: residual(cases.arm(v=v, J=J), bang_bang(cases.viscous_model(v, J))) for v in COMPARED_DAMPINGS}
    rates = slowest_rates(cases.arm(J=J), SWEEP, ELBOW)
    frequencies = tuple(mode.frequency for mode in paper_modes(cases.arm(J=J), ELBOW))
    return Row(J, frequencies, ratio, found, float(SWEEP[int(np.argmax(rates))]))


def _draw_slowest_rates(canvas: Any, cases: PaperCases, rows: list[Row]) -> None:
    panel = canvas.subplots()
    for row, (colour, dash) in zip(rows, INERTIA_LOOKS, strict=True):
        rates = slowest_rates(cases.arm(J=row.J), SWEEP, ELBOW)
        panel.loglog(SWEEP, rates, color=colour, linestyle=dash, label=f"$J = {row.J:g}$ kg m$^2$")
        panel.loglog(row.best_v, rates.max(), "o", color=colour, markersize=4)
    panel.set(xlim=(SWEEP[0], SWEEP[-1]), xlabel="damping $v$ (N m s/rad)", ylabel="slowest decay rate (1/s)")
    panel.legend(loc="lower right")
