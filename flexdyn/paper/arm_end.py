"""Chapters about the end of the arm: how far the joints' deflection moves it, and a force on it."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.control.commands import PD, FrameWrench
from flexdyn.control.samples import Samples
from flexdyn.paper import style
from flexdyn.paper.cases import CASES_OBSERVED, PAPER_V, TORQUE_END, PaperCases, reference
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.equations import jacobian, tip
from flexdyn.robot import frame_positions
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate

FORCE = np.array([-0.2, 0.0])  # N, along -x: across the second link as it stands
RISE, RELEASE, END = 1.0, 16.0, 20.0  # s
SETTLING = 3.0  # N m s/rad: brings both joints to rest well before the release
END_FORCE_KP, END_FORCE_KD = 50.0, 4.5  # N m/rad, N m s/rad: hold the motors, critically damped for J = 0.1 kg m^2


def tip_deflection(cases: PaperCases) -> Chapter:
    """Distance between the tip at q and the tip at the rotor angles theta."""
    runs = {"without friction": cases.driven["flexible"], "with friction": cases.driven["flexible_friction"]}
    vectors = {name: _vector(run) for name, run in runs.items()}
    arm = cases.arm()
    apart = max(np.abs(tip(arm, run.q) - tip(arm, run.theta) - vectors[name]).max() for name, run in runs.items())
    sizes = {name: np.linalg.norm(vector, axis=1) for name, vector in vectors.items()}
    numbers = {name: _largest(run.t, 1e3 * sizes[name]) for name, run in runs.items()}
    text = prose("tip_deflection.md", reach=2 * arm.L, numbers=numbers)
    picture = figure("tip_deflection", lambda canvas: _draw_displacement(canvas, runs, sizes))
    checks = (stated("tip_deflection", apart),)
    return Chapter("End-effector deflection", text, checks, numbers, (picture,))


def _largest(t: Array, size: Array) -> dict[str, float]:
    """The largest distance [mm] while the torque acts, in the second after it, and at the end of the run."""
    parts = {
        "driven_mm": t < TORQUE_END,
        "after_mm": (t >= TORQUE_END) & (t < TORQUE_END + 1.0),
        "end_mm": t >= TORQUE_END + CASES_OBSERVED,
    }
    return {name: float(size[part].max()) for name, part in parts.items()}


def _vector(run: Run) -> Array:
    """From the tip at the rotors' angles to the tip (samples, 2) [m]."""
    robot = run.model.robot
    return np.asarray(frame_positions(robot, run.q)[:, :2] - frame_positions(robot, run.theta)[:, :2])


def _draw_displacement(canvas: Any, runs: dict[str, Run], sizes: dict[str, Array]) -> None:
    """The path of the tip beside that of a rigid arm, and the distance of the two over time."""
    left, right = canvas.subplots(1, 2, width_ratios=(1.0, 1.5))
    run = runs["without friction"]
    robot, seen = run.model.robot, run.t <= 2 * TORQUE_END
    actual, rigid = (frame_positions(robot, angles[seen])[:, :2] for angles in (run.q, run.theta))
    left.plot(*rigid.T, color=style.VERMILION, linestyle=style.DASHED, label=r"rigid pose at $\theta$")
    left.plot(*actual.T, color=style.BLUE, label="tip")
    for a, b in zip(actual[::20], rigid[::20], strict=True):
        left.plot([a[0], b[0]], [a[1], b[1]], color=style.GREY, linewidth=0.5, zorder=1)
    left.plot(*actual[0], "o", color=style.BLACK, markersize=4)
    left.annotate("start", actual[0], (2, -11), textcoords="offset points", ha="right", fontsize=8)
    left.set(xlabel="$x$ (m)", ylabel="$y$ (m)", aspect="equal")
    left.set_adjustable("datalim")
    left.legend(loc="lower left")
    looks = {"without friction": (style.BLUE, "-"), "with friction": (style.VERMILION, style.DASHED)}
    for name, (colour, dash) in looks.items():
        right.plot(runs[name].t, 1e3 * sizes[name], color=colour, linestyle=dash, linewidth=0.9, label=name)
    style.torque_on(right)
    right.set(xlim=(0, TORQUE_END + CASES_OBSERVED), xlabel="time (s)", ylabel="tip deflection (mm)")
    right.set_ylim(0, 1.22e3 * max(size.max() for size in sizes.values()))
    right.legend(loc="upper right", ncols=2)
    style.titled(left, "a", "path of the tip")
    style.titled(right, "b", "distance from the rigid pose")


def end_force(cases: PaperCases) -> Chapter:
    """A force pushes the tool sideways: at rest the springs deflect by K^-1 J^T F."""
    light, heavy = (_pushed(cases, v) for v in (PAPER_V, SETTLING))
    arm = cases.arm()
    at = int(np.argmin(np.abs(light.t - RELEASE))) - 1
    bent = -jacobian(arm, heavy.q[at]).T @ FORCE / arm.K  # theta - q at rest [rad], J_r of eq. 8-11
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
        bent=bent,
        deflection=heavy.deflection[at],
        mean=mean,
        distance=np.linalg.norm(moved),
        along=abs(moved[0]),
        both=lambda angles: " and ".join(f"{angle:.3f}" for angle in np.degrees(angles)),
    )
    checks = (stated("end_force", error, force=-FORCE[0], v=SETTLING, release=RELEASE),)
    picture = figure("end_force", lambda canvas: _draw_push(canvas, light, heavy, bent))
    return Chapter("The end-of-arm force", text, checks, numbers, (picture,), {"end_force": light})


def _pushed(cases: PaperCases, v: float) -> Run:
    """The arm, held by its motors, under the force at its end."""
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


def _draw_push(canvas: Any, light: Run, heavy: Run, bent: Array) -> None:
    """Deflections under the force, with light and with heavy damping."""
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
