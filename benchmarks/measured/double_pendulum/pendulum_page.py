"""The double pendulum's page: verdict, tables and pictures."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pendulum_data import CHECK, FIT, JOINTS, PUBLISHED_FRICTION

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table

if TYPE_CHECKING:
    from measure import Bound
    from pendulum_data import Windows
    from pendulum_result import Study

COLOURS = {"without friction, as given": "#b3261e", "published friction": "#8a6d00", "found": "#1b5e9e"}


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its picture, and the diagnosis' report into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    made.diagnosis.save(folder / "diagnosis")
    _draw(made, folder / "windows.png")
    levels = ", ".join(f"{0.5 * math.pi * cf:.3f} N m on {joint}" for joint, (_, cf) in PUBLISHED_FRICTION.items())
    tables = {"errors": _errors(made), "currents": _currents(made)}
    fill_page(__file__, made, held, folder, FIT=FIT, CHECK=CHECK, levels=levels, **tables)


def _errors(made: Study) -> str:
    """Errors over windows of 0.5 s, by model."""
    stamps = (*FIT, *CHECK)
    parts = (f"{each}, {'fitted' if each in FIT else 'not fitted'}" for each in stamps)
    rows = []
    for name, by in made.windows.items():
        cells = (", ".join(f"{x:.3f}" for x in by[stamp].rms) for stamp in stamps)
        rows.append([f"**{name}**" if name == "found" else name, *cells])
    return markdown_table(["RMS of joint 1, joint 2 [rad]", *parts], rows)


def _currents(made: Study) -> str:
    """How the current follows the commanded torque."""
    rows = [
        [stamp, joint, f"{each.gain:.2f}", f"{1e3 * each.lag:.0f}", f"{each.left:.3f}"]
        for stamp, by in made.currents.items()
        for joint, each in by.items()
    ]
    return markdown_table(["record", "joint", "gain", "lag [ms]", "left [N m]"], rows, text=2)


def _draw(made: Study, path: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, len(CHECK), figsize=(12, 7), sharex="col")
    for column, stamp in enumerate(CHECK):
        for j, joint in enumerate(JOINTS):
            axis, last = axes[j, column], made.windows["found"][stamp]
            lines = [(name, each[stamp].simulated, colour) for name, each, colour in _coloured(made)]
            for name, values, colour in [*lines, ("measured", last.measured, "black")]:
                style = ":" if name == "measured" else "-"
                for k, (t, x) in enumerate(zip(last.t, values[:, :, j], strict=True)):
                    axis.plot(t, x, color=colour, lw=1.0, ls=style, label=name if k == 0 else None)
            low, high = last.measured[:, :, j].min(), last.measured[:, :, j].max()
            margin = 0.3 * (high - low)
            numbers = ", ".join(f"{by[stamp].rms[j]:.3f}" for _, by, _ in _coloured(made))
            axis.set(ylabel=f"{joint} [rad]", ylim=(low - margin, high + margin), title=f"{stamp}: RMS {numbers} rad")
        axes[-1, column].set_xlabel("t [s]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=4)
    figure.tight_layout(rect=(0.0, 0.05, 1.0, 1.0))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _coloured(made: Study) -> list[tuple[str, Mapping[str, Windows], str]]:
    """Models by name, their windows by record, and their colours."""
    return [(name, made.windows[name], colour) for name, colour in COLOURS.items()]
