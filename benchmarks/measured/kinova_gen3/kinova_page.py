"""The Kinova's page: what the sweeps tell, what they cannot, and what the trajectory says of it."""

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
    from kinova_result import Study
    from measure import Bound

COLOURS = ("#b3261e", "#1b5e9e")


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md, its picture, and the diagnoses' reports into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for joint, diagnosis in made.diagnoses.items():
        diagnosis.save(folder / f"diagnosis_{joint}")
    _draw(made, folder / "torque.png")
    tables = {"errors": _errors(made), "trials": _trials(made), "clock": _clock(made)}
    fill_page(__file__, made, held, folder, rotors=_rotors(made), payload=_payload(made), **tables)


def _rotors(made: Study) -> dict[int, tuple[float, float]]:
    """Rotor inertia behind the gear that each sweep tells, and its error [kg m^2]."""
    found = {}
    for joint, diagnosis in made.diagnoses.items():
        rotor = next(each for each in diagnosis.calibration if each.parameter == "rotor_inertia")
        reflected = float(diagnosis.model.resolved().rotor_inertia[0])
        found[joint] = (reflected, rotor.std / rotor.factor * reflected)
    return found


def _errors(made: Study) -> str:
    """Torque errors over the trajectory, by joint and model."""
    rows = []
    for joint in made.diagnoses:
        cells = (made.error("plain URDF", joint), made.error("found", joint), made.references[joint].error)
        rows.append([f"joint {joint}", *(f"{100.0 * each:.0f}" for each in cells)])
    header = ["torque error over trajectory1 [%]", "plain URDF", "found in the sweep", "least squares on trajectory1"]
    return markdown_table(header, rows)


def _trials(made: Study) -> str:
    """Errors over the trajectory with and without each name, and with its rivals."""
    rows = []
    for each in made.trials:
        first, *_ = each.finding
        errors = (f"{100.0 * value:.1f}" for value in (each.error, each.without))
        rows.append([f"joint {each.joint}", first.replace("_", " "), *errors])
        for name, error in each.rivals.items():
            value = "-" if math.isnan(error) else f"{100.0 * error:.1f}"
            rows.append(["", f"or {name.replace('_', ' ')}", value, ""])
    return markdown_table(["", "name, or rival in its place", "error with it [%]", "without it [%]"], rows, text=2)


def _clock(made: Study) -> str:
    """Rows of each file by the cycles that lie before them."""
    rows = [[name, *(str(count) for count in counts)] for name, counts in made.cycles.items()]
    return markdown_table(["file", "rows that repeat", "rows a cycle later", "rows after lost cycles"], rows)


def _payload(made: Study) -> str:
    masses = [
        finding.suspect.parameters["mass"].value
        for finding in made.diagnoses[4].findings
        if finding.suspect.effect == "payload"
    ]
    return f"{masses[0]:.2f} kg" if masses else "unknown mass"


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
