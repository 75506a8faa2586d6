"""The Kinova's page: what the sweeps tell, what they cannot, and what the trajectory says of it."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from result_tables import markdown_table
from told import findings_text

if TYPE_CHECKING:
    from kinova_result import Study
    from measure import Bound

COLOURS = ("#b3261e", "#1b5e9e")


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its picture, and the diagnoses' reports into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for joint, diagnosis in made.diagnoses.items():
        diagnosis.save(folder / f"diagnosis_{joint}")
    _draw(made, folder / "torque.png")
    checks = "\n".join(f"- {each}" for each in held)
    head = (
        "# Kinova Gen3: what sweeps in one direction tell\n"
        "\n"
        "Seven joints with strain-wave gears. In each of four files one joint (1, 4, 5 or 7) makes one sweep of 2 "
        "to 2.6 rad at a constant 0.37 to 0.42 rad/s, in one direction, the others at 0: the arm stands upright. "
        "Each sweep is diagnosed from the manufacturer's URDF: rigid joints, no friction, rotor inertias not "
        "known. A fifth file, `trajectory1`, moves all joints at once and three times as fast, again in one "
        "direction but for its end. No decision reads it; what the sweeps name is held against it (data: W. Chiha, "
        "dynamic-identification)."
    )
    parts = [head, checks, *_named(made), *_held(made), *_limits(made), *_clock(made)]
    (folder / "page.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _named(made: Study) -> Iterator[str]:
    yield "## What each sweep names"
    for joint, diagnosis in made.diagnoses.items():
        rotor = next(each for each in diagnosis.calibration if each.parameter == "rotor_inertia")
        reflected = float(diagnosis.model.resolved().rotor_inertia[0])
        error = rotor.std / rotor.factor * reflected
        yield (
            f"**Joint {joint}**, verdict {diagnosis.verdict}:\n\n{findings_text(diagnosis)}\n"
            f"- Rotor inertia, behind the gear: {reflected:.2g} +- {error:.1g} kg m^2."
        )
        plans = dict.fromkeys(each.experiment for each in diagnosis.findings if each.experiment)
        yield "What would tell: " + "; ".join(plans) + "." if plans else "Nothing is left open."
    yield (
        "Where a joint moves in one direction only, Coulomb friction and a constant offset of the torque are the "
        "same number. Friction is expected of every motor and an offset of few, and that prior alone would make "
        "friction a name. So each name is compared with every other law in its place at even prior odds: where "
        "the data like both as well, the answer is 'A or B', whatever is expected of drives. At a single speed "
        "the growth of friction with speed shows in the two ramps of 0.2 s alone. These tell viscous friction "
        "from drag with the square of the speed by more than 0.4 % of the torque, but not beyond doubt: the name "
        "rests on what is expected of drives."
    )


def _held(made: Study) -> Iterator[str]:
    yield "## What the trajectory says"
    rows = []
    for joint in made.diagnoses:
        reference = made.references[joint].error
        cells = (made.error("plain URDF", joint), made.error("found", joint), reference)
        rows.append([f"joint {joint}", *(f"{100.0 * each:.0f}" for each in cells)])
    header = ["torque error over trajectory1 [%]", "plain URDF", "found in the sweep", "least squares on trajectory1"]
    yield markdown_table(header, rows)
    yield (
        "Root mean square of what is left over that of the torque, every sample. The last column is what three "
        "numbers (rotor inertia, viscous and Coulomb friction) reach that are fitted to this very file: joints 1 "
        "and 4 vibrate in it at 5 to 8 Hz, which no such law holds."
    )
    yield "![torque over the trajectory](torque.png)"
    rows = []
    for each in made.trials:
        first, *_ = each.finding
        errors = (f"{100.0 * value:.1f}" for value in (each.error, each.without))
        rows.append([f"joint {each.joint}", first.replace("_", " "), *errors])
        for name, error in each.rivals.items():
            value = "-" if math.isnan(error) else f"{100.0 * error:.1f}"
            rows.append(["", f"or {name.replace('_', ' ')}", value, ""])
    yield markdown_table(["", "name, or rival in its place", "error with it [%]", "without it [%]"], rows, text=2)
    yield (
        f"{sum(each.survives for each in made.trials)} of {len(made.trials)} names survive: without them the "
        "trajectory is predicted worse. All laws are fitted to the sweep alone, by plain least squares, so that "
        "without a law the others take over what they can; a rival stands in the place of the name. The trajectory "
        "is three times as fast, so it also speaks about rivals of the sweep: drag with the square of the speed is "
        "too large there, most clearly at joint 5. At its end joints 4, 5 and 7 swing back by a few hundredths of a "
        "radian. Friction changes its sign there and an offset does not, so that friction predicts them better; joint "
        "1 does not swing back, and there both do alike."
    )


def _limits(made: Study) -> Iterator[str]:
    yield "## What these sweeps cannot tell"
    yield (
        "- Friction or offset: nothing turns back. One sweep back, at the same speed, tells at once: friction changes "
        "its sign, an offset does not.\n"
        "- How friction grows with speed: one speed, and two ramps. A second speed tells.\n"
        "- Why gravity at joint 4 is larger than the URDF says: with the arm upright a gripper of "
        f"{_payload(made)} at its end, a heavier link and another torque constant make the same sine. Whether a "
        "gripper was mounted is not stated. Weigh it, or sweep joint 4 with the wrist bent by 90 degrees: that moves "
        "the payload's lever and not the torque constant.\n"
        "- The torque's scale: the motor's current is multiplied by a constant of unknown origin. All levels above "
        "scale with it.\n"
        "- Elasticity: there is one encoder a joint, and the arm upright loads no spring.\n"
        "- Stribeck friction, presliding: every ramp has passed 0.03 rad/s within 20 ms."
    )


def _payload(made: Study) -> str:
    masses = [
        finding.suspect.parameters["mass"].value
        for finding in made.diagnoses[4].findings
        if finding.suspect.effect == "payload"
    ]
    return f"{masses[0]:.2f} kg" if masses else "unknown mass"


def _clock(made: Study) -> Iterator[str]:
    yield "## The clock of the files"
    rows = [[name, *(str(count) for count in counts)] for name, counts in made.cycles.items()]
    yield markdown_table(["file", "rows that repeat", "rows a cycle later", "rows after lost cycles"], rows)
    yield (
        "The files have no times. Positions that move on by nothing, or by twice what the velocity says, tell how "
        "many cycles of 1 ms lie between two rows; repeated rows are left out, lost ones interpolated. With times "
        "counted by rows, accelerations are so wrong that the rotor of joint 1 comes out a tenth of what it is."
    )


def _draw(made: Study, file: Path) -> None:
    """Measured torque and both models over the trajectory."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    for axis, joint in zip(axes, made.diagnoses, strict=True):
        k = joint - 1
        for (name, seen), colour in zip(made.inverses.items(), COLOURS, strict=True):
            if name == "plain URDF":
                axis.plot(seen.t, seen.torque[:, k], color="0.3", lw=1.2, label="measured")
            axis.plot(seen.t, (seen.torque - seen.missing)[:, k], color=colour, lw=1.2, label=name)
        axis.set(title=f"joint {joint}, trajectory1 (took no part)", ylabel="torque [N m]")
        low, high = np.percentile(made.inverses["found"].torque[:, k], (0.5, 99.5))
        axis.set_ylim(low - 0.3 * (high - low), high + 0.3 * (high - low))
    axes[0].legend(fontsize="small")
    for axis in axes[2:]:
        axis.set_xlabel("t [s]")
    figure.savefig(file, dpi=100)
