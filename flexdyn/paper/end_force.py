"""Chapter: the end-of-arm force, which the paper names and then sets to zero, as an input."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.control.commands import PD, FrameWrench, Samples
from flexdyn.paper import style
from flexdyn.paper.cases import PAPER_V, PaperCases, reference
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.equations import Arm, jacobian, tip
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate

FORCE = np.array([-0.2, 0.0])  # N, along -x: across the second link as it stands
RISE, RELEASE, END = 1.0, 16.0, 20.0  # s
SETTLING = 3.0  # N m s/rad: brings both joints to rest well before the release
END_FORCE_KP, END_FORCE_KD = 50.0, 4.5  # N m/rad, N m s/rad: hold the motors, critically damped for J = 0.1 kg m^2


def end_force(cases: PaperCases) -> Chapter:
    """A lateral push at the tool: at rest the springs deflect by K^-1 J^T F."""
    light, heavy = (_pushed(cases, v) for v in (PAPER_V, SETTLING))
    arm = cases.arm()
    at = int(np.argmin(np.abs(light.t - RELEASE))) - 1
    bent = static_deflection(arm, heavy.q[at])
    error = np.abs(heavy.deflection[at] - bent).max() / np.abs(bent).max()
    sway = light.t < RELEASE - 1e-9
    mean = light.deflection[sway & (light.t > RISE)].mean(0)
    moved = 1e3 * (tip(arm, heavy.q[at]) - tip(arm, heavy.q[0]))
    numbers = {
        "force_n": FORCE.tolist(),
        "deflection_deg": np.degrees(heavy.deflection[at]).tolist(),
        "static_deflection_deg": np.degrees(bent).tolist(),
        "tip_moved_mm": moved.tolist(),
    }
    text = prose(
        "end_force.md",
        force=-FORCE[0],
        release=RELEASE,
        settling=SETTLING,
        paper_v=PAPER_V,
        bent=bent,
        deflection=heavy.deflection[at],
        mean=mean,
        distance=np.linalg.norm(moved),
        along=abs(moved[0]),
        both=_degrees,
    )
    checks = (stated("end_force", error, force=-FORCE[0], v=SETTLING, release=RELEASE),)
    picture = figure("end_force", lambda canvas: _draw(canvas, light, heavy, bent))
    return Chapter("The end-of-arm force", text, checks, numbers, (picture,), {"end_force": light})


def static_deflection(arm: Arm, q: Array) -> Array:
    """Theta - q at rest under the force [rad]: -K^-1 J_r^T F, J_r of eq. 8-11."""
    return np.asarray(-jacobian(arm, q).T @ FORCE / arm.K)


def _pushed(cases: PaperCases, v: float) -> Run:
    model = cases.viscous_model(v)
    held = [model.initial["q"].get(joint, 0.0) for joint in model.joint_names]
    still = Samples([0.0, END], [held, held], "linear")
    s = np.linspace(0.0, 1.0, 51)
    rise = s**3 * (10 - 15 * s + 6 * s**2)
    t = np.concatenate([RISE * s, [RELEASE, RELEASE + 1e-3, END]])
    size = np.concatenate([rise, [1.0, 0.0, 0.0]])
    push = Samples(t, np.outer(size, [*FORCE, 0, 0, 0, 0]), "linear")
    wrench = FrameWrench(model.robot.tip, push)
    return simulate(model, PD(still, END_FORCE_KP, END_FORCE_KD), END, reference(), rate=100.0, external=wrench)


def _degrees(angles: Array) -> str:
    return " and ".join(f"{angle:.3f}" for angle in np.degrees(angles))


def _draw(canvas: Any, light: Run, heavy: Run, bent: Array) -> None:
    panels = canvas.subplots(1, 2, sharex=True)
    for j, panel in enumerate(panels):
        panel.axvspan(0.0, RELEASE, color="#EDEDED", linewidth=0, zorder=0)
        looks = ((light, style.BLUE, "-", PAPER_V), (heavy, style.VERMILION, style.DASHED, SETTLING))
        for run, colour, dash, v in looks:
            panel.plot(run.t, np.degrees(run.deflection[:, j]), color=colour, linestyle=dash, label=f"$v = {v:g}$")
        line = {"color": style.BLACK, "linestyle": style.DOTTED, "linewidth": 1.3}
        panel.plot([0.0, RELEASE], np.degrees([bent[j]] * 2), **line, label=r"$-K^{-1} J_r^T F$", zorder=3)
        panel.set(xlim=(0, END), xticks=range(0, 21, 4), xlabel="time (s)")
        style.titled(panel, "ab"[j], f"joint {j + 1}")
    panels[0].set_ylabel(r"deflection $\theta - q$ (deg)")
    canvas.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
