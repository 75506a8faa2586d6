"""Chapter: the torque curve of Fig. 4 and the joint responses of Fig. 3."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.paper import style
from flexdyn.paper.cases import AMPLITUDE, PULSE, TORQUE_END, PaperCases
from flexdyn.paper.chapter import Chapter, Check, figure, prose, stated
from flexdyn.paper.vibration import amplitude, ringing_after
from flexdyn.simulation.run import Run


def responses(cases: PaperCases) -> Chapter:
    """Flexible and rigid arm under the torque of Fig. 4, without friction."""
    flexible, rigid = cases.driven["flexible"], cases.driven["rigid"]
    numbers = {
        "largest_deflection_deg": np.degrees(np.abs(flexible.deflection).max(0)).tolist(),
        "ringing_flexible_deg": float(np.degrees(ringing_after(flexible))),
        "ringing_rigid_deg": float(np.degrees(ringing_after(rigid))),
        "torque_cut_off_flexible": _cut_off(flexible),
        "torque_cut_off_rigid": _cut_off(rigid),
    }
    size = np.degrees(amplitude(cases.arm(), flexible)[flexible.t >= TORQUE_END])
    text = prose(
        "responses.md",
        stall=cases.limit.stall_torque,
        cut_off=max(numbers["torque_cut_off_flexible"]),
        bends=numbers["largest_deflection_deg"],
        size=size,
    )
    figures = (
        figure("fig4_torque", lambda canvas: _draw_torque(canvas, cases)),
        figure("fig3_joint_responses", lambda canvas: _draw_responses(canvas, flexible, rigid)),
    )
    runs = {"fig3_flexible": flexible, "fig3_rigid": rigid}
    return Chapter("Torque and joint responses: Fig. 4 and Fig. 3", text, _checks(cases), numbers, figures, runs)


def _checks(cases: PaperCases) -> tuple[Check, ...]:
    """What the responses must fulfil."""
    flexible, rigid = cases.driven["flexible"], cases.driven["rigid"]
    excess = max(_over_limit(cases, run) for run in cases.driven.values())
    energy = flexible.energy.mechanical[flexible.t >= TORQUE_END]
    return (
        stated("torque_speed_slope", abs(cases.limit.stall_torque / cases.limit.no_load_speed - 0.18)),
        stated("torque_speed_line", excess),
        stated("oscillation", ringing_after(rigid) / ringing_after(flexible)),
        stated("energy", np.ptp(energy) / energy.mean()),
    )


def _cut_off(run: Run) -> list[float]:
    return [float(most) for most in np.abs(run.tau - run.tau_applied).max(0)]


def _over_limit(cases: PaperCases, run: Run) -> float:
    """By how much the applied torque exceeds the torque-speed line [N m]."""
    stall, no_load = cases.limit.stall_torque, cases.limit.no_load_speed
    upper = np.maximum(0.0, stall * (1 - run.omega / no_load))
    lower = np.minimum(0.0, -stall * (1 + run.omega / no_load))
    return float(np.maximum(run.tau_applied - upper, lower - run.tau_applied).max())


def _draw_torque(canvas: Any, cases: PaperCases) -> None:
    """The torque that is asked for and applied, and over the speed."""
    flexible, rigid = cases.driven["flexible"], cases.driven["rigid"]
    panels = canvas.subplots(1, 3, width_ratios=(1, 1, 0.95))
    steps_t = [-0.15, 0, 0, PULSE, PULSE, TORQUE_END, TORQUE_END, 1.5]
    steps = np.array([0, 0, 1, 1, -1, -1, 0, 0]) * AMPLITUDE
    for j, panel in enumerate(panels[:2]):
        panel.plot(steps_t, steps, color=style.BLACK, linestyle=style.DOTTED, label="asked", zorder=3)
        for run, look in ((flexible, style.FLEXIBLE), (rigid, style.RIGID)):
            on = run.t <= 1.5
            panel.plot(run.t[on], run.tau_applied[on, j], **(look | {"label": f"applied, {look['label']}"}))
        panel.set(xlim=(-0.15, 1.5), ylim=(-0.75, 0.75), xlabel="time (s)")
        style.titled(panel, "ab"[j], f"joint {j + 1}")
    panels[0].set_ylabel(r"torque $\tau$ (N m)")
    canvas.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    _draw_line(panels[2], cases, flexible)


def _draw_line(panel: Any, cases: PaperCases, run: Run) -> None:
    """The applied torque over the speed of the rotor, within the torque-speed line."""
    stall, no_load = cases.limit.stall_torque, cases.limit.no_load_speed
    edge = {"color": style.GREY, "linewidth": 1.4}
    panel.plot([-1.5, no_load, 4], [stall * (1 + 1.5 / no_load), 0, 0], **edge, label="torque-speed line")
    panel.plot([-1.5, 4], [-stall * (1 - 1.5 / no_load), -stall * (1 + 4 / no_load)], **edge)
    on = run.t < TORQUE_END
    for j, (colour, dash) in enumerate(((style.BLUE, "-"), (style.PURPLE, (0, (3, 1, 1, 1))))):
        panel.plot(
            run.omega[on, j], run.tau_applied[on, j], color=colour, linestyle=dash, label=f"joint {j + 1}, flexible"
        )
    panel.set(xlim=(-1.5, 4.0), ylim=(-0.75, 0.75), xlabel=r"rotor speed $\omega$ (rad/s)")
    panel.legend(loc="center right", bbox_to_anchor=(1.0, 0.36), handlelength=1.9, fontsize=7.5)
    style.titled(panel, "c", "torque over speed")


def _draw_responses(canvas: Any, flexible: Run, rigid: Run) -> None:
    """Responses and deflections of both joints, flexible and rigid."""
    panels = canvas.subplots(2, 2, sharex=True)
    for j in range(2):
        for run, look in ((flexible, style.FLEXIBLE), (rigid, style.RIGID)):
            panels[0, j].plot(run.t, np.degrees(run.q[:, j]), **look)
            panels[1, j].plot(run.t, np.degrees(run.deflection[:, j]), **look)
        style.titled(panels[0, j], "ab"[j], f"joint {j + 1}, response")
        style.titled(panels[1, j], "cd"[j], f"joint {j + 1}, deflection")
        panels[1, j].set_xlabel("time (s)")
        for panel in panels[:, j]:
            style.torque_on(panel)
            panel.set_xlim(0, 6)
        _rescale(panels[0, j], np.degrees(np.concatenate([run.q[run.t <= 6, j] for run in (flexible, rigid)])))
    panels[0, 0].set_ylabel("joint angle $q$ (deg)")
    panels[1, 0].set_ylabel(r"deflection $\theta - q$ (deg)")
    panels[0, 0].legend(loc="upper left")


def _rescale(panel: Any, values: Any) -> None:
    """Fit the axis to the visible part of the curves."""
    margin = 0.06 * np.ptp(values)
    panel.set_ylim(values.min() - margin, values.max() + margin)
