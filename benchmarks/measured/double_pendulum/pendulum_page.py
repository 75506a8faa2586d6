"""The double pendulum's page: verdict, tables and pictures."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pendulum_data import CHECK, FIT, JOINTS, PUBLISHED_FRICTION

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from result_tables import markdown_table
from told import findings_text, gap_text

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
    checks = "\n".join(f"- {each}" for each in held)
    head = (
        "# Double pendulum: the friction that was taken out of its model\n\nTwo quasi-direct drives, encoders on the "
        f"motors, 500 Hz. Fitted: {FIT[0]} (excitation, 10 s) and {FIT[1]} (full swing, 6 s); {CHECK[0]} (excitation) "
        f"and {CHECK[1]} (swing) are not used in the fit. The start is the published model 1.0 with its friction set "
        "to zero."
    )
    parts = [head, checks, *_found(made), *_errors(made)]
    (folder / "page.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _found(made: Study) -> Iterator[str]:
    yield "## What was found"
    yield f"{gap_text(made.diagnosis)}\n\n{findings_text(made.diagnosis)}"
    levels = ", ".join(f"{0.5 * math.pi * cf:.3f} N m on {joint}" for joint, (_, cf) in PUBLISHED_FRICTION.items())
    yield (
        f"The authors' model 1.0 has dry friction cf atan(100 v), which saturates at {levels}, and hardly any viscous "
        "friction (0.001 N m s/rad); their model 3.0 has a fifth of the dry level and 0.05 and 0.02 N m s/rad instead."
    )
    rows = [[each.of, each.parameter, f"{each.factor:.3f}", f"{each.std:.3f}"] for each in made.diagnosis.calibration]
    yield markdown_table(["number of the file", "", "factor", "std"], rows, text=2)
    yield (
        "The published sets differ from one another by more than that: m1 is 0.52, 0.76 or 0.87 kg in models 1.0, "
        "2.0 and 3.0. The motion determines only sums of masses, lengths and inertias, so single factors say "
        "little."
    )


def _errors(made: Study) -> Iterator[str]:
    yield "## Errors over windows of 0.5 s"
    stamps = (*FIT, *CHECK)
    header = [
        "RMS of joint 1, joint 2 [rad]",
        *(f"{each}, {'fitted' if each in FIT else 'not fitted'}" for each in stamps),
    ]
    rows = []
    for name, by in made.windows.items():
        cells = (", ".join(f"{x:.3f}" for x in by[stamp].rms) for stamp in stamps)
        rows.append([f"**{name}**" if name == "found" else name, *cells])
    yield markdown_table(header, rows)
    yield (
        "Every window starts from the measured position and velocity (a cubic over 40 ms) and is driven by the "
        "commanded torque in open loop. The swing passes the upright position, where a small error grows fast, so "
        "its errors are not only those of the model. There the found friction may be worse than the published one "
        "for two reasons. Half of the data of the fit are excitations, in which the arm hangs and masses and "
        "lengths have little influence. In the swings, the motors did not reach the commanded torque (below)."
    )
    yield "![windows](windows.png)"
    yield "## The commanded torque, and the current"
    rows = [
        [stamp, joint, f"{each.gain:.2f}", f"{1e3 * each.lag:.0f}", f"{each.left:.3f}"]
        for stamp, by in made.currents.items()
        for joint, each in by.items()
    ]
    yield markdown_table(["record", "joint", "gain", "lag [ms]", "left [N m]"], rows, text=2)
    yield (
        "Everything above is driven by the commanded torque. The current follows it with a delay and, in the "
        "swings, with 0.8 to 0.9 of its size: the motors do not reach short peaks of several N m. A law that "
        "reduces the torque of the motor (a limit, a gain, a delay) is therefore plausible for the swings; the "
        "excitation needs none."
    )


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
