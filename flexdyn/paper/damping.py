"""Chapter: what growing viscous damping makes of the residual vibration and its decay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.paper import style
from flexdyn.paper.cases import CASES_DURATION, DAMPINGS, TORQUE_END, PaperCases, bang_bang
from flexdyn.paper.chapter import Chapter, figure, prose, stated
from flexdyn.paper.vibration import Mode, Residual, amplitude, paper_modes, pluck_rate, residual, slowest_rates
from flexdyn.simulation.run import Run

ELBOW = np.pi / 2  # rad: the pose of Table I, at which modes are computed
SWEEP = np.logspace(-2, 2, 161)  # N m s/rad
SHOWN_DAMPINGS = (0.01, 0.5, 2.0)  # N m s/rad
DAMPING_LOOKS: dict[float, dict[str, Any]] = {
    v: {"color": colour, "linestyle": "-" if dash is None else (0, dash)}
    for v, colour, dash in zip(
        DAMPINGS,
        (style.BLACK, style.BLUE, style.SKY, style.GREEN, style.ORANGE, style.VERMILION, style.PURPLE),
        (None, (6, 2), (3, 1, 1, 1), (4, 1, 1, 1, 1, 1), (1, 1.2), (8, 2, 2, 2), (3, 1.2)),
        strict=True,
    )
}


def damping(cases: PaperCases) -> Chapter:
    """Increased damping suppresses the vibration: by how much, how fast, and up to which damping."""
    runs = {v: bang_bang(cases.viscous_model(v)) for v in DAMPINGS}
    found = {v: residual(cases.arm(v=v), run) for v, run in runs.items()}
    plucked = {v: _plucked(cases, v) for v in DAMPINGS}
    rates = slowest_rates(cases.arm(), SWEEP, ELBOW)
    best = float(SWEEP[int(np.argmax(rates))])
    last = np.array([each.last for each in found.values()])
    worst = max(abs(measured / true - 1) for pairs in plucked.values() for measured, true in pairs)
    checks = (
        stated("damping_steps", (last[1:] / last[:-1]).max(), v=", ".join(f"{v:g}" for v in DAMPINGS)),
        stated("plucked_modes", worst, values=len(DAMPINGS)),
    )
    numbers = {
        f"{v:g}": found[v].to_dict()
        | {
            "modes": [
                {"frequency_hz": mode.frequency, "rate": mode.rate, "decrement": mode.decrement}
                for mode in paper_modes(cases.arm(v=v), ELBOW)
            ]
        }
        for v in DAMPINGS
    }
    figures = (
        figure("fig5_damping", lambda canvas: _draw_growing(canvas, cases, runs)),
        figure("fig5_decay_rates", lambda canvas: _draw_rates(canvas, cases, plucked, best)),
    )
    kept = {f"damping_v_{v:g}": runs[v] for v in SHOWN_DAMPINGS}
    text = _damping_text(cases, found, best, float(rates.max()))
    numbers_all = {"by_v": numbers, "best_v": best, "best_rate": float(rates.max())}
    return Chapter("Growing damping", text, checks, numbers_all, figures, kept)


def _plucked(cases: PaperCases, v: float) -> list[tuple[float, float]]:
    """Measured and linearised decay rate [1/s] of each mode."""
    arm, model = cases.arm(v=v), cases.smooth_model(v)
    return [(pluck_rate(arm, model, mode, ELBOW), mode.rate) for mode in paper_modes(arm, ELBOW)]


def _damping_text(cases: PaperCases, found: Mapping[float, Residual], best: float, best_rate: float) -> str:
    """The prose of the chapter."""

    def both(v: float) -> dict[str, Mode]:
        """The two modes with a coefficient of damping."""
        return dict(zip(("slow", "fast"), paper_modes(cases.arm(v=v), ELBOW), strict=True))

    free = both(0.0)
    return prose(
        "damping.md",
        free=free,
        damped=both(0.5),
        share=abs(free["slow"].shape[2] / free["slow"].shape[0]),
        rows=[{"v": v, "found": each, **both(v)} for v, each in found.items()],
        J=cases.arm().J,
        best=best,
        best_rate=best_rate,
    )


def _draw_growing(canvas: Any, cases: PaperCases, runs: Mapping[float, Run]) -> None:
    """Deflection and amplitude for each damping."""
    left, right = canvas.subplots(1, 2)
    for v, run in runs.items():
        if v in SHOWN_DAMPINGS:
            left.plot(run.t, np.degrees(run.deflection[:, 1]), **DAMPING_LOOKS[v], label=f"$v = {v:g}$")
        right.semilogy(run.t, np.degrees(amplitude(cases.arm(v=v), run)), **DAMPING_LOOKS[v], label=f"{v:g}")
    style.titled(left, "a", "elbow")
    style.titled(right, "b", "amplitude of the vibration")
    left.set_ylabel(r"deflection $\theta_2 - q_2$ (deg)")
    right.set_ylabel("amplitude $A$ (deg)")
    for panel in (left, right):
        style.torque_on(panel)
        panel.set(xlim=(0, CASES_DURATION - 1.0), xlabel="time (s)")
    right.set_xlim(TORQUE_END, CASES_DURATION - 1.0)
    right.set_ylim(4.5, 13)
    right.set_yticks([5, 6, 8, 10, 12], ["5", "6", "8", "10", "12"])
    right.minorticks_off()
    left.legend(loc="lower right", ncols=3)
    right.legend(loc="lower left", ncols=2, title="$v$ (N m s/rad)", title_fontsize=8)


def _draw_rates(
    canvas: Any, cases: PaperCases, plucked: Mapping[float, list[tuple[float, float]]], best: float
) -> None:
    """Decay rates over the damping, computed and measured."""
    panel = canvas.subplots()
    lines = _rate_lines(cases)
    looks = ((style.BLUE, "-", "o"), (style.VERMILION, style.DASHED, "s"))
    for (colour, dash, mark), line, name in zip(looks, lines, ("slow", "fast"), strict=True):
        panel.loglog(SWEEP, line, color=colour, linestyle=dash, label=f"{name} vibration")
        place = 0 if name == "slow" else -1
        measured = [pairs[place][0] for pairs in plucked.values()]
        panel.loglog(list(plucked), measured, mark, color=colour, markersize=4, markerfacecolor="white")
    panel.axvline(best, color=style.GREY, linewidth=0.8, linestyle=":")
    panel.text(best * 1.15, 4e-4, f"best: $v = {best:.1f}$", fontsize=8)
    panel.set(xlim=(0.8 * SWEEP[0], SWEEP[-1]), xlabel="damping $v$ (N m s/rad)", ylabel="decay rate (1/s)")
    panel.legend(loc="upper left")


def _rate_lines(cases: PaperCases) -> tuple[Array, Array]:
    """Rates of the slow and the fast vibration over the sweep, each followed from one damping to the next."""
    slow, fast = (mode.eigenvalue for mode in paper_modes(cases.arm(v=float(SWEEP[0])), ELBOW))
    rates = []
    for v in SWEEP:
        one, other = (mode.eigenvalue for mode in paper_modes(cases.arm(v=float(v)), ELBOW))
        if abs(other - slow) + abs(one - fast) < abs(one - slow) + abs(other - fast):
            one, other = other, one
        slow, fast = one, other
        rates.append((-slow.real, -fast.real))
    lines = np.array(rates).T
    return lines[0], lines[1]
