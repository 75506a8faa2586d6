"""Chapters: the friction law, eq. 1 and Fig. 1; flexible and rigid arm with and without friction, Fig. 5."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.effects import CoulombFriction, StribeckFriction, ViscousFriction
from flexdyn.paper import style
from flexdyn.paper.cases import (
    CASES_OBSERVED,
    PAPER_V,
    TORQUE_END,
    FrictionNumbers,
    PaperCases,
    bang_bang,
)
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.vibration import residual, ringing_after

WITHOUT = {"color": style.BLUE, "linestyle": "-", "label": "without friction"}
WITH = {"color": style.VERMILION, "linestyle": style.DASHED, "label": "with friction"}


def friction_law(cases: PaperCases) -> Chapter:
    """Eq. 1 is the sum of three effects of the model; Fig. 1 draws it."""
    numbers = cases.friction
    u = np.linspace(-1.0, 1.0, 2001)
    laws = [law for law in cases.model.effects if isinstance(law, ViscousFriction | CoulombFriction | StribeckFriction)]
    total = sum(law.torque(0.0, u) for law in laws if law.joint == cases.model.joint_names[0])
    return Chapter(
        "The friction law: eq. 1 and Fig. 1",
        prose("friction_law.md", **vars(numbers)),
        (stated("friction_law", np.abs(total - numbers.law(u)).max()),),
        {"b_v": numbers.viscous, "b_d": numbers.dynamic, "b_s": numbers.static, "epsilon": numbers.epsilon},
        (figure("fig1_friction_law", lambda canvas: _draw_law(canvas, numbers)),),
    )


def _draw_law(canvas: Any, numbers: FrictionNumbers) -> None:
    """The friction law, whole and near rest."""
    panels = canvas.subplots(1, 2, width_ratios=(1.25, 1.0))
    for panel, reach in zip(panels, (1.0, 0.2), strict=True):
        u = np.linspace(1e-6, reach, 600)
        viscous = 1e3 * numbers.viscous * u
        for values, look in (
            (1e3 * numbers.law(u), {"color": style.BLUE, "linewidth": 1.6, "label": "$b(u)$, eq. 1"}),
            (viscous, {"color": style.GREEN, "linestyle": style.DOTTED, "label": "$b^v u$, viscous"}),
            (viscous + 1e3 * numbers.dynamic, style.RIGID | {"label": r"$b^v u + b^d\,\mathrm{Sgn}\,u$"}),
        ):
            panel.plot(-u, -values, **(look | {"label": None}))
            panel.plot(u, values, **look)
        static = 1e3 * numbers.static
        panel.plot([0, 0], [-static, static], color=style.BLUE, linewidth=3.2, solid_capstyle="butt")
        panel.plot(0, 0, "o", color="white", markeredgecolor=style.BLACK, markersize=4.5, zorder=5, linestyle="none")
        panel.set_xlim(-reach, reach)
        panel.set_ylim(-38, 38)
        panel.set_xlabel(r"joint velocity $u$ (rad/s)")
    style.titled(panels[0], "a", "the whole law")
    style.titled(panels[1], "b", "near rest")
    panels[0].set_ylabel(r"friction torque $b$ ($10^{-3}$ N m)")
    panels[0].legend(loc="lower right")
    _annotate(panels[1], numbers)


def _annotate(panel: Any, numbers: FrictionNumbers) -> None:
    """Names of the numbers of the law, near rest."""
    static, dynamic = 1e3 * numbers.static, 1e3 * numbers.dynamic
    thin = {"arrowstyle": "-", "linewidth": 0.6, "color": style.BLACK}
    panel.annotate(r"$+b^s$", (0, static), (-0.06, static + 1.0), ha="right", va="center", arrowprops=thin)
    panel.annotate(r"$-b^s$", (0, -static), (0.06, -static - 1.0), ha="left", va="center", arrowprops=thin)
    panel.annotate(r"$+b^d$", (0, dynamic), (-0.06, dynamic), ha="right", va="center", arrowprops=thin)
    panel.text(0.012, -0.5 * dynamic, "$u = 0$: any torque\nin $[-b^s, b^s]$", va="center", fontsize=8)
    panel.annotate(
        "eq. 2 as printed:\nsgn(0) = 0", (0, 0), (-0.045, 5), ha="right", va="center", fontsize=8, arrowprops=thin
    )
    knee = dynamic + (static - dynamic) / np.e + 1e3 * numbers.viscous * numbers.epsilon
    panel.plot([numbers.epsilon] * 2, [0, knee], color=style.BLACK, linewidth=0.6, linestyle=":")
    panel.text(numbers.epsilon + 0.004, 3.0, r"$\epsilon$")


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
    picture = figure("fig5_friction", lambda canvas: _draw_effect(canvas, runs))
    kept = {"fig5_flexible_friction": runs["flexible_friction"], "fig5_rigid_friction": runs["rigid_friction"]}
    text = prose("friction_effect.md", left=left, moved=moved)
    return Chapter("The effect of friction: Fig. 5", text, checks, numbers, (picture,), kept)


def _draw_effect(canvas: Any, runs: Any) -> None:
    """Both joints with friction and without: flexible, rigid, deflection."""
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
