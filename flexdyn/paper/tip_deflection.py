"""Chapter: displacement of the end of the arm by the deflection of the joints."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.paper import style
from flexdyn.paper.cases import CASES_OBSERVED, TORQUE_END, PaperCases
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.equations import tip
from flexdyn.robot import frame_positions
from flexdyn.simulation.run import Run


def tip_deflection(cases: PaperCases) -> Chapter:
    """Distance between the tip at q and the tip at the rotor angles theta."""
    runs = {"without friction": cases.driven["flexible"], "with friction": cases.driven["flexible_friction"]}
    vectors = {name: _vector(run) for name, run in runs.items()}
    arm = cases.arm()
    apart = max(np.abs(tip(arm, run.q) - tip(arm, run.theta) - vectors[name]).max() for name, run in runs.items())
    sizes = {name: np.linalg.norm(vector, axis=1) for name, vector in vectors.items()}
    numbers = {name: _largest(run.t, 1e3 * sizes[name]) for name, run in runs.items()}
    text = prose("tip_deflection.md", reach=2 * arm.L, numbers=numbers)
    picture = figure("tip_deflection", lambda canvas: _draw(canvas, runs, sizes))
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


def _draw(canvas: Any, runs: dict[str, Run], sizes: dict[str, Array]) -> None:
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
