"""The XL330 page: verdict, tables and a picture."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table
from xl330_fit import EVALUATIONS

from flexdyn.diagnose.report.digits import unit_text

if TYPE_CHECKING:
    from measure import Bound
    from xl330_result import Study

PUBLISHED = {"BAM M1, refitted": (61.6, 74.7), "BAM M4, refitted": (27.7, 61.1), "BAM M5, refitted": (26.0, 59.3),
             "BAM M6, refitted": (26.7, 60.8)}  # fmt: skip
"""BAM's models with BAM's simulator, fitted to the same eight logs; and to gains 100 and 400 of all sixteen logs of the
bench, on the gains 200 and 800 [mrad]."""


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its picture, and the diagnosis' report into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    made.diagnosis.save(folder / "diagnosis")
    _draw(made, folder / "motions.png")
    tables = {"errors": _errors(made), "published": _published(made), "numbers": _numbers(made)}
    fill_page(__file__, made, held, folder, evaluations=EVALUATIONS, **tables)


def _errors(made: Study) -> str:
    """Mean absolute error of every log by each model."""
    rows = [
        [name, *(f"{1e3 * each:.1f}" for each in errors), f"{1e3 * errors.mean():.1f}"]
        for name, errors in made.errors.items()
    ]
    return markdown_table(["mean absolute error [mrad]", *(log.name for log in made.logs), "mean"], rows)


def _published(made: Study) -> str:
    """The same beside the published models."""
    rows = [[name, f"{own:.1f}", f"{other:.1f}"] for name, (own, other) in PUBLISHED.items()]
    rows.append(["**this study**", f"{1e3 * made.mean('fitted'):.1f}", f"{1e3 * made.unseen():.1f}"])
    return markdown_table(["model", "these 8 logs [mrad]", "gains 200 and 800 by a fit to 100 and 400 [mrad]"], rows)


def _numbers(made: Study) -> str:
    """Numbers of the fitted model."""
    joint = made.fitted.joints["servo"]
    motor = joint.actuator.dc_motor if joint.actuator is not None else None
    rows = [["rotor inertia", f"{joint.rotor_inertia:.3g} kg m^2"], ["stiffness", f"{joint.stiffness:.3g} N m/rad"]]
    rows.append(["damping", f"{joint.damping:.2g} N m s/rad"])
    if motor is not None:
        rows.append(["torque constant", f"{motor.torque_constant:.3g} N m/A"])
        rows.append(["resistance", f"{motor.resistance:.3g} ohm"])
    for effect in made.fitted.effects:
        numbers = (
            f"{f.name} {getattr(effect, f.name):.3g} {unit_text(f.metadata['unit'])}" for f in effect.parameters()
        )
        rows.append([effect.name.replace("_", " "), ", ".join(each.rstrip() for each in numbers)])
    return markdown_table(["number", "value"], rows, text=2)


def _draw(made: Study, file: Path) -> None:
    """Measured and simulated position of every log."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 10.0), layout="constrained")
    axes = figure.subplots(4, 2).ravel()
    for axis, log, simulated in zip(axes, made.logs, made.simulated, strict=True):
        t = log.recording.t
        axis.plot(t, log.recording["goal.servo"], ":", color="0.6", label="goal", linewidth=0.8)
        axis.plot(t, log.recording["q.servo"], color="0.2", label="measured")
        axis.plot(t, simulated, color="#1b5e9e", label="simulated from the goal", linewidth=1.0)
        top = 1.15 * max(abs(log.recording["q.servo"]).max(), abs(simulated).max())
        axis.set(title=log.name, ylabel="q [rad]", ylim=(-top, top))
    axes[0].legend(fontsize="small")
    for axis in axes[-2:]:
        axis.set_xlabel("t [s]")
    figure.savefig(file, dpi=100)
