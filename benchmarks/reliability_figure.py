"""The reliability curve of the hidden-effect benchmark: how often is what has a probability true?

    python benchmarks/reliability_figure.py

reads benchmarks/results/discovery.json and writes benchmarks/figures/reliability.png.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
SERIES = (
    ("of_candidates", "#1f77e0", "o", "all candidates of the reports"),
    ("reliability", "#b03a00", "s", "what was named"),
)


def wilson(true: float, count: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson's 95 % interval of a probability, of which a share of `count` trials was true [1]."""
    centre, room = true + z * z / (2 * count), z * math.sqrt(true * (1 - true) / count + z * z / (4 * count * count))
    whole = 1 + z * z / count
    return (centre - room) / whole, (centre + room) / whole


def draw(results: Any, path: Path) -> None:
    """Share that is true over the mean probability of every bin, with intervals."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.6, 5.2), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1.0, label="as often as said")
    for name, colour, marker, words in SERIES:
        bins: Sequence[dict[str, Any]] = results[name]["bins"]
        x, y = [each["probability"] for each in bins], [each["true"] for each in bins]
        ends = [wilson(each["true"], each["count"]) for each in bins]
        room = [
            [s - low for s, (low, _) in zip(y, ends, strict=True)],
            [high - s for s, (_, high) in zip(y, ends, strict=True)],
        ]
        axes.errorbar(x, y, room, color=colour, marker=marker, markersize=5, linestyle="", capsize=3, label=words)
    axes.set(
        xlabel="probability [1]",
        ylabel="share that is true, with 95 % interval [1]",
        xlim=(-0.02, 1.02),
        ylim=(-0.02, 1.02),
    )
    axes.grid(visible=True, alpha=0.3)
    axes.legend(loc="upper left")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    draw(
        json.loads((HERE / "results" / "discovery.json").read_text(encoding="utf-8")),
        HERE / "figures" / "reliability.png",
    )
