"""Draw the picture of a diagnosis in docs: what `flexdyn paper --diagnose` shows, the gap as it shrinks."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import matplotlib.figure
import matplotlib.style

from flexdyn.paper import style
from flexdyn.paper.cases import PaperCases
from flexdyn.paper.hidden_friction import hidden_friction

OUT = Path(__file__).parents[1] / "benchmarks" / "figures" / "diagnosis.png"


def main() -> int:
    """Diagnose, draw, write; exit code 1, and no picture, where not everything that was hidden was found."""
    with tempfile.TemporaryDirectory() as folder:
        chapter = hidden_friction(PaperCases(), Path(folder), lambda stage, share: None)
    for check in chapter.checks:
        print(f"{check.name}: {check.value:.3g}, at most {check.bound:g}")
    if not all(check.passed for check in chapter.checks):
        return 1
    (figure,) = chapter.figures
    with matplotlib.style.context(["default", style.STYLE]):
        canvas = matplotlib.figure.Figure(figsize=figure.size, layout="constrained")
        figure.draw(canvas)
        canvas.savefig(OUT, dpi=150)
    return 0


if __name__ == "__main__":
    sys.exit(main())
