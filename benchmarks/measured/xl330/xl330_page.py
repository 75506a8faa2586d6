"""The XL330 page: verdict, tables and a picture."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from result_tables import markdown_table
from told import findings_text, gap_text

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
    checks = "\n".join(f"- {each}" for each in held)
    head = (
        "# XL330: a hobby servo from its goal alone\n\nA Dynamixel XL330 swings 0.49 kg at 0.1 m, eight logs of 6 s "
        "at four "
        "gains of its firmware (BAM, ICRA 2025). Simulated from the goal and the first position alone, the "
        "firmware's loop "
        "closed on the simulated position, nothing reset."
    )
    parts = [head, checks, *_errors(made), *_named(made), *_numbers(made)]
    (folder / "page.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _errors(made: Study) -> Iterator[str]:
    yield "## Errors of the position"
    rows = [
        [name, *(f"{1e3 * each:.1f}" for each in errors), f"{1e3 * errors.mean():.1f}"]
        for name, errors in made.errors.items()
    ]
    yield markdown_table(["mean absolute error [mrad]", *(log.name for log in made.logs), "mean"], rows)
    rows = [[name, f"{own:.1f}", f"{other:.1f}"] for name, (own, other) in PUBLISHED.items()]
    rows.append(["**this study**", f"{1e3 * made.mean('fitted'):.1f}", f"{1e3 * made.unseen():.1f}"])
    yield markdown_table(["model", "these 8 logs [mrad]", "gains 200 and 800 by a fit to 100 and 400 [mrad]"], rows)
    yield (
        "For BAM's models the last column includes the other eight logs, for ours only these eight. 'Less' leaves "
        "one effect out and keeps all other numbers. So it shows how much the model depends on the effect, not how "
        "good a fitted model without it would be. While the motor is switched off (lift_and_drop, 2 s), the arm is "
        "simulated without an actuator."
    )
    yield "![measured and simulated](motions.png)"


def _named(made: Study) -> Iterator[str]:
    yield "## What a diagnosis names"
    yield f"{gap_text(made.diagnosis)}\n\n{findings_text(made.diagnosis)}"
    for each in made.diagnosis.findings:
        if each.experiment:
            yield f"What would separate {each.suspect.effect.replace('_', ' ')} from its rivals: {each.experiment}."
    yield (
        "Four logs at 190 Hz with one encoder, on the output: what happens at the rotor is seen through the gear "
        "alone. The fitted model holds more than the diagnosis names. The loss of torque at high current and what "
        "the gear holds at rest decide when the arm sticks and lets go, which equations along the motion hardly "
        "see; they are fitted, not named, and carry no probability."
    )


def _numbers(made: Study) -> Iterator[str]:
    yield "## The fitted model"
    joint = made.fitted.joints["servo"]
    motor = joint.actuator.dc_motor if joint.actuator is not None else None
    rows = [["rotor inertia", f"{joint.rotor_inertia:.3g} kg m^2"], ["stiffness", f"{joint.stiffness:.3g} N m/rad"]]
    rows.append(["damping", f"{joint.damping:.2g} N m s/rad"])
    if motor is not None:
        rows.append(["torque constant", f"{motor.torque_constant:.3g} N m/A"])
        rows.append(["resistance", f"{motor.resistance:.3g} ohm"])
    for effect in made.fitted.effects:
        numbers = (f"{f.name} {getattr(effect, f.name):.3g} {f.metadata['unit']}" for f in effect.parameters())
        rows.append([effect.name.replace("_", " "), ", ".join(numbers)])
    yield markdown_table(["number", "value"], rows, text=2)
    yield "All behind the gear. `python benchmarks/measured/xl330/xl330_fit.py` fits it."


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
