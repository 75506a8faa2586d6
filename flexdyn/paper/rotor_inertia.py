"""Chapter: the rotor inertia, which the paper does not give: which conclusions hold for any value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.paper import style
from flexdyn.paper.cases import PaperCases, bang_bang
from flexdyn.paper.chapter import Chapter, Figure, check
from flexdyn.paper.damping import ELBOW, SWEEP
from flexdyn.paper.vibration import Residual, modes, residual, ringing_after, slowest_rates

INERTIAS = (0.01, 0.1, 1.0)  # kg m^2, reflected
COMPARED_INERTIAS = (0.01, 0.1, 0.5)  # N m s/rad
LOOKS: tuple[Any, ...] = ((style.VERMILION, (0, (5, 2))), (style.BLUE, "-"), (style.GREEN, (0, (1, 1.2))))


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
    parts = [[row.residuals[v].left for v in COMPARED_INERTIAS] for row in rows]
    shares = [ratio for part in parts for ratio in np.divide(part[1:], part[:-1])]
    checks = (
        check(
            "For every rotor inertia only the flexible arm oscillates",
            max(row.ringing for row in rows),
            0.1,
            "rigid over flexible, largest of J = 0.01, 0.1, 1 kg m^2, no friction",
        ),
        check(
            "For every rotor inertia more damping leaves less of the vibration",
            max(shares),
            1.0,
            "largest ratio of what is left after 10 s at successive v = 0.01, 0.1, 0.5 N m s/rad",
        ),
    )
    numbers = {
        f"{row.J:g}": {
            "frequencies_hz": list(row.frequencies),
            "best_v": row.best_v,
            "residual": {f"{v:g}": vars(each) | {"left": each.left} for v, each in row.residuals.items()},
        }
        for row in rows
    }
    lines = [
        f"| {row.J:g} | {row.frequencies[0]:.2f}, {row.frequencies[-1]:.2f} | "
        f"{np.degrees(row.residuals[COMPARED_INERTIAS[0]].first):.2f} | "
        + " | ".join(f"{100 * row.residuals[v].left:.1f} %" for v in COMPARED_INERTIAS)
        + f" | {row.best_v:.1f} |"
        for row in rows
    ]
    text = "\n".join(
        [
            f"The paper has J in eq. 14, 15 and no value for it; {cases.arm().J:g} kg m^2 was chosen. The same study "
            "with a tenth and with ten times of it (torque of Fig. 4, torque-speed limit, viscous friction only):",
            "",
            "| J [kg m^2] | vibrations [Hz] | A after the torque, v = 0.01 [deg] | left after 10 s: v = 0.01 | v = 0.1 "
            "| v = 0.5 | best v [N m s/rad] |",
            "|---|---|---|---|---|---|---|",
            *lines,
            "",
            "What holds for all three: the flexible arm oscillates where the rigid one does not, v = 0.01 leaves "
            "more than nine tenths of it after 10 s, and more damping takes more. What depends on J: frequencies and "
            "size of the vibration, and how much damping helps. The heavier the rotors, the more the links take part "
            "in the vibration and the better friction on the links damps it. The paper's figures, which might tell "
            "its J, are lost.",
        ]
    )
    figure = Figure(
        "rotor_inertia",
        "Decay rate of the vibration that decays slowest, over the damping v, for three rotor inertias: linearised eq. "
        "12-15 at the pose of Table I.",
        lambda canvas: _draw(canvas, cases, rows),
        (3.5, 2.9),
    )
    return Chapter("The rotor inertia, which the paper leaves out", text, checks, numbers, (figure,))


def _row(cases: PaperCases, J: float) -> Row:
    free = cases.viscous_model(0.0, J)
    ratio = ringing_after(bang_bang(free.rigid())) / ringing_after(bang_bang(free))
    found = {v: residual(cases.arm(v=v, J=J), bang_bang(cases.viscous_model(v, J))) for v in COMPARED_INERTIAS}
    rates = slowest_rates(cases.arm(J=J), SWEEP, ELBOW)
    frequencies = tuple(mode.frequency for mode in modes(cases.arm(J=J), ELBOW))
    return Row(J, frequencies, ratio, found, float(SWEEP[int(np.argmax(rates))]))


def _draw(canvas: Any, cases: PaperCases, rows: list[Row]) -> None:
    panel = canvas.subplots()
    for row, (colour, dash) in zip(rows, LOOKS, strict=True):
        rates = slowest_rates(cases.arm(J=row.J), SWEEP, ELBOW)
        panel.loglog(SWEEP, rates, color=colour, linestyle=dash, label=f"$J = {row.J:g}$ kg m$^2$")
        panel.loglog(row.best_v, rates.max(), "o", color=colour, markersize=4)
    panel.set(xlim=(SWEEP[0], SWEEP[-1]), xlabel="damping $v$ (N m s/rad)", ylabel="slowest decay rate (1/s)")
    panel.legend(loc="lower right")
