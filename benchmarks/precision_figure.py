"""The figures of work_precision.py: error over time spent, and where a tenth of the best peer's time is missed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

STYLE = {
    "flexdyn DormandPrince": ("#0b3d91", "o", "-"),
    "flexdyn Rosenbrock": ("#1f77e0", "s", "-"),
    "flexdyn RungeKutta4": ("#3aa0d8", "^", "-"),
    "flexdyn TimeStepping": ("#7cc4e8", "D", "-"),
    "MuJoCo RK4": ("#b03a00", "^", "--"),
    "MuJoCo Euler": ("#e07b00", "v", "--"),
    "MuJoCo implicitfast": ("#f2b134", "D", "--"),
    "SciPy DOP853": ("#1b7a3d", "o", ":"),
    "SciPy LSODA": ("#4fae5b", "s", ":"),
    "SciPy Radau": ("#97c96b", "P", ":"),
}


def draw(result: dict[str, Any], path: Path) -> None:
    """One case: every method's settings, and beneath it our best time over the best peer's at each error level."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(
        2, 1, figsize=(8.0, 8.0), height_ratios=[4, 1.3], sharex=True, layout="constrained"
    )
    for name, (colour, marker, line) in STYLE.items():
        points = sorted(result["methods"].get(name, []), key=lambda p: p["setting"])
        if points:
            x, y = [p["error_rad"] for p in points], [p["seconds"] * 1e3 for p in points]
            above.loglog(x, y, line, color=colour, marker=marker, markersize=5, linewidth=1.4, label=name)
    above.set(ylabel="CPU time [ms]", title=result["title"])
    above.set_xlim(3e-1, 1e-9)
    above.grid(visible=True, which="major", alpha=0.3)
    above.legend(fontsize=8, ncols=3, loc="upper left")
    low, high = above.get_ylim()
    above.set_ylim(low, high * 12.0)
    _ratios(below, result["levels"])
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _ratios(axes: Any, levels: list[dict[str, Any]]) -> None:
    """Bars of our best time over the best peer's; a level that no peer reaches has none."""
    for row in levels:
        x, ratio = row["error_rad"], row["ratio"]
        edges = (x * 10**-0.3, x * 10**0.3)
        if ratio is None:
            words = "no peer" if row["ours"] else "nobody"
            axes.text(x, 0.13, words, ha="center", va="bottom", fontsize=8)
            continue
        colour = "#2a7f3f" if row["goal"] else "#c0392b"
        axes.bar(edges[0], ratio, width=edges[1] - edges[0], align="edge", color=colour)
        axes.text(x, ratio * 1.15, f"{ratio:.2g}", ha="center", va="bottom", fontsize=8)
    axes.axhline(0.1, color="black", linewidth=1.0, linestyle="--")
    axes.text(2.5e-1, 0.11, "goal: a tenth", fontsize=8, va="bottom")
    axes.set(yscale="log", ylim=(0.005, 5.0), xlabel="greatest error of q and theta [rad]", ylabel="ours / best peer")
    axes.grid(visible=True, axis="y", alpha=0.3)
