"""The screw drives' page: a verdict a drive and direction, its evidence, a picture."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table

if TYPE_CHECKING:
    from measure import Bound
    from screw_result import Studied

RPM = 30.0 / math.pi


def write_page(made: Sequence[Studied], held: Sequence[Bound], folder: Path) -> None:
    """Write page.md and curves.png into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _draw(made, folder / "curves.png")
    parts = {"verdicts": _verdicts(made), "sentences": _sentences(made), "starts": _starts(made)}
    fill_page(__file__, made, held, folder, **parts)


def _verdicts(made: Sequence[Studied]) -> str:
    rows = []
    for of in made:
        for direction, curve in of.curves.items():
            for each in curve.trials:
                halves = f"{each.prediction[0]:.0f} and {each.prediction[1]:.0f}"
                why = "" if each.named else f": {each.why}"
                verdict = f"**{'yes' if each.named else 'no'}**{why}"
                name = each.effect.replace("_", " ")
                evidence = [f"{each.delta_bic:.0f}", halves, f"{each.check:.0f}", f"{curve.speeds}"]
                rows.append([of.drive.words, f"{direction:+d}", name, verdict, *evidence])
    header = [
        "drive",
        "direction",
        "beside Coulomb and viscous",
        "shown?",
        "drop of BIC",
        "other speeds",
        "start-stop",
        "speeds",
    ]
    return markdown_table(header, rows, text=len(header))


def _sentences(made: Sequence[Studied]) -> str:
    lines = []
    for of in made:
        milli, rpm = 1e3 / of.drive.ratio, of.drive.ratio * RPM
        for direction, curve in of.curves.items():
            said = [f"level {curve.level[0] * milli:.2f} +- {curve.level[1] * milli:.2f} mN m"]
            for each in curve.trials:
                if each.named and "excess" in each.numbers:
                    (low, high), (slow, fast) = each.intervals["excess"], each.intervals["velocity"]
                    excess, velocity = each.numbers["excess"][0], each.numbers["velocity"][0]
                    said.append(
                        f"Stribeck excess {excess * milli:.2f} mN m ({low * milli:.2f} to {high * milli:.2f}), "
                        "velocity "
                        f"{velocity * rpm:.1f} rpm ({slow * rpm:.1f} to {fast * rpm:.1f})"
                    )
                elif each.named:
                    said.append("more than in proportion to speed when fast")
            scatter = f"means scatter by {curve.scatter:.1f} of their own standard deviations"
            lines.append(f"- {of.drive.words}, {direction:+d}: {'; '.join(said)}; {scatter}.")
        lines.append(f"  The authors' parameters for this drive: {of.drive.said}.")
    return "\n".join(lines)


def _starts(made: Sequence[Studied]) -> str:
    rows = [
        [
            of.drive.words, each.file, f"{each.speed:.0f}", f"{each.torque:.2f} +- {each.std:.2f}",
            f"{each.predicted:.2f}", f"{each.plain:.2f}", f"{each.start:.1f}",
        ]
        for of in made
        for each in of.stretches
    ]  # fmt: skip
    header = ["drive", "start-stop file", "rpm", "torque [mN m]", "named laws say", "Coulomb, viscous say", "start"]
    return markdown_table(header, rows, text=len(header))


def _draw(made: Sequence[Studied], path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.6), layout="constrained")
    axes = figure.subplots(2, len(made))
    for column, of in enumerate(made):
        milli, ratio = 1e3 / of.drive.ratio, of.drive.ratio
        for row, direction in enumerate((1, -1)):
            ax, curve = axes[row, column], of.curves[direction]
            own = [point for point in of.points if point.speed * direction > 0.0]
            u = np.array([abs(point.speed) for point in own])
            tau = np.array([abs(point.torque) for point in own]) * milli
            ax.errorbar(
                u * ratio * RPM, tau, [2.0 * p.std * milli for p in own], fmt="o", ms=3.5, color="black", lw=0.8
            )
            line = np.geomspace(0.8 * u.min(), u.max(), 300)
            named = ", ".join(curve.named) or "nothing"
            law = [abs(curve.torque(direction * float(each))) * milli for each in line]
            ax.plot(line * ratio * RPM, law, color="tab:blue", label=f"named: {named}")
            for each in of.stretches:
                if each.speed * direction > 0.0:
                    ax.plot(abs(each.speed), abs(each.torque), "D", ms=5, mfc="none", color="tab:orange")
            ax.set_xscale("log")
            ax.set(title=f"{of.drive.words}, {direction:+d}", xlabel="motor [rpm]", ylabel="abs(torque) [mN m]")
            ax.legend(fontsize=7)
    figure.savefig(path, dpi=110)
