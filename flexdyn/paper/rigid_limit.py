"""Chapter: with stiffer springs the flexible arm becomes the rigid one: the paper's own test of the model, Fig. 3."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.paper import style
from flexdyn.paper.cases import SMOOTH_AMPLITUDE, SMOOTH_END, PaperCases, smooth_samples
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solvers import DormandPrince

FACTORS = 10.0 ** np.arange(0.0, 6.01, 0.5)  # times the K of Table I
FITTED_FACTOR = 1e2  # the law of large K is fitted from this factor on
RIGID_LIMIT_DURATION = 5.0


def rigid_limit(cases: PaperCases) -> Chapter:
    """Distance between flexible and rigid arm over K: slope -1."""
    solver = DormandPrince(rtol=1e-10, atol=1e-12)
    model, command = cases.smooth_model(), smooth_samples()
    rigid = simulate(model.rigid(), command, RIGID_LIMIT_DURATION, solver, rate=200.0)
    K, rms, most = FACTORS * cases.arm().K, [], []
    for stiffness in K:
        softer = model.replace(joints={"*": {"stiffness": stiffness}})
        run = simulate(softer, command, RIGID_LIMIT_DURATION, solver, rate=200.0)
        distance = np.linalg.norm(run.q - rigid.q, axis=1)
        rms.append(float(np.sqrt((distance**2).mean())))
        most.append(float(distance.max()))
    stiff = FACTORS >= FITTED_FACTOR
    slope, offset = np.polyfit(np.log10(K[stiff]), np.log10(rms)[stiff], 1)
    text = prose(
        "rigid_limit.md",
        amplitude=SMOOTH_AMPLITUDE,
        end=SMOOTH_END,
        fitted=K[stiff],
        slope=slope,
        K=K[0],
        distance=np.degrees(rms[0]),
    )
    numbers = {"K": K.tolist(), "rms_distance_rad": rms, "largest_distance_rad": most, "slope": float(slope)}
    picture = figure("fig3_rigid_limit", lambda canvas: _draw_distance(canvas, K, rms, most, (slope, offset)))
    checks = (stated("rigid_limit", abs(slope + 1), slope=slope, values=int(stiff.sum())),)
    return Chapter("The rigid arm as the limit of stiff joints", text, checks, numbers, (picture,))


def _draw_distance(canvas: Any, K: Array, rms: list[float], most: list[float], line: tuple[float, float]) -> None:
    """The distance from the rigid arm over the stiffness, with the fitted law."""
    panel = canvas.subplots()
    start = K[FACTORS >= FITTED_FACTOR][0]
    fitted = np.array([start, K[-1]])
    panel.loglog(K, most, "s", color=style.VERMILION, markersize=4, markerfacecolor="white", label="largest")
    panel.loglog(K, rms, "o", color=style.BLUE, markersize=4, label="root mean square")
    power = 10 ** np.polyval(line, np.log10(fitted))
    panel.loglog(fitted, power, "-", color=style.BLACK, linewidth=0.9, label=f"fit, slope ${line[0]:.3f}$", zorder=1)
    panel.axvline(start, color=style.GREY, linewidth=0.8, linestyle=":")
    panel.annotate("Table I", (K[0], rms[0]), (2.2 * K[0], rms[0]), va="center", fontsize=8)
    panel.set_xlabel(r"joint stiffness $K$ (N m/rad)")
    panel.set_ylabel(r"$\|q_\mathrm{flexible} - q_\mathrm{rigid}\|$ (rad)")
    panel.legend(loc="lower left")
