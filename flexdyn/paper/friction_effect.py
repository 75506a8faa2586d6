"""Chapter: flexible and rigid arm with and without friction, Fig. 5."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.paper import style
from flexdyn.paper.cases import CASES_DURATION, CASES_OBSERVED, PAPER_V, TORQUE_END, PaperCases, bang_bang
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.vibration import residual, ringing_after

WITHOUT = {"color": style.BLUE, "linestyle": "-", "label": "without friction"}
WITH = {"color": style.VERMILION, "linestyle": style.DASHED, "label": "with friction"}


def friction_effect(cases: PaperCases) -> Chapter:
    """Fig. 5: the effect of friction on both arms."""
    runs, arm = cases.driven, cases.arm()
    viscous = bang_bang(cases.viscous_model(PAPER_V))
    left = {
        "none": residual(arm, runs["flexible"]),
        "viscous": residual(arm, viscous),
        "viscous_and_dry": residual(arm, runs["flexible_friction"]),
    }
    moved = {kind: np.degrees(runs[f"{kind}_friction"].q[-1] - runs[kind].q[-1]) for kind in ("flexible", "rigid")}
    lost = {name: 1 - each.left for name, each in left.items()}
    checks = (
        stated("friction_losses", max(lost["none"] / lost["viscous"], lost["viscous"] / lost["viscous_and_dry"])),
        stated(
            "oscillation_with_friction",
            ringing_after(runs["rigid_friction"]) / ringing_after(runs["flexible_friction"]),
        ),
    )
    numbers = {
        "residual": {name: each.to_dict() for name, each in left.items()},
        "end_moved_by_friction_deg": {kind: angles.tolist() for kind, angles in moved.items()},
    }
    picture = figure("fig5_friction", lambda canvas: _draw(canvas, runs))
    kept = {"fig5_flexible_friction": runs["flexible_friction"], "fig5_rigid_friction": runs["rigid_friction"]}
    text = prose(
        "friction_effect.md",
        left=left,
        moved=moved,
        paper_v=PAPER_V,
        watched=CASES_OBSERVED,
        duration=CASES_DURATION,
        degrees=np.degrees,
        tuple=tuple,
    )
    return Chapter("The effect of friction: Fig. 5", text, checks, numbers, (picture,), kept)


def _draw(canvas: Any, runs: Any) -> None:
    panels = canvas.subplots(2, 3, sharex=True)
    for j in range(2):
        for look, suffix in ((WITHOUT, ""), (WITH, "_friction")):
            flexible, rigid = runs[f"flexible{suffix}"], runs[f"rigid{suffix}"]
            panels[j, 0].plot(flexible.t, np.degrees(flexible.q[:, j]), **look)
            panels[j, 1].plot(rigid.t, np.degrees(rigid.q[:, j]), **look)
            panels[j, 2].plot(flexible.t, np.degrees(flexible.deflection[:, j]), **(look | {"linewidth": 0.9}))
        names = (f"joint {j + 1}, flexible", f"joint {j + 1}, rigid", f"joint {j + 1}, deflection")
        for panel, name, at in zip(panels[j], names, "abc" if j == 0 else "def", strict=True):
            style.titled(panel, at, name)
            style.torque_on(panel)
            panel.set_xlim(0, TORQUE_END + CASES_OBSERVED)
        _share(panels[j, 0], panels[j, 1])
        panels[j, 0].set_ylabel(f"angle $q_{j + 1}$ (deg)")
        panels[j, 2].set_ylabel(rf"$\theta_{j + 1} - q_{j + 1}$ (deg)")
    for panel in panels[1]:
        panel.set_xlabel("time (s)")
    panels[0, 0].legend(loc="upper left")


def _share(one: Any, other: Any) -> None:
    """The same angles on both axes, so that the two arms can be compared."""
    ends = [*one.get_ylim(), *other.get_ylim()]
    for panel in (one, other):
        panel.set_ylim(min(ends), max(ends))
