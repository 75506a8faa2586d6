"""The page of the friction damper: tables and pictures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from damper_data import FIT, LATER, Array, distance
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from pages import fill_page
from result_tables import markdown_table

if TYPE_CHECKING:
    from damper_result import Study
    from measure import Bound

    import flexdyn as fd

LUGRE = {"1Hz_20lb": (27, 27, 23), "1Hz_35lb": (16, 22, None), "1Hz_80lb": (12, 16, None)}
"""LuGre with Stribeck on the rigid axis: force errors of fitted and later cycles and of the 0.5 Hz file [%]."""
KEYS = ("fit", "later cycles", "0.5 Hz")


def write_page(made: Study, held: Sequence[Bound], folder: Path) -> None:
    """Write page.md and its pictures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    _draw(made, folder / "force.png")
    _draw_left(made, folder / "left.png")
    tables = {"errors": _errors(made), "drift": _drift_table(made), "left": _left(made)}
    numbers = {each.name.partition(" of ")[0]: each for each in made.compared.numbers}
    ratios = {name: each.ratio for name, each in numbers.items()}
    fill_page(__file__, made, held, folder, odds=_odds(made), ratios=ratios, gap=numbers["half gap"], **tables)


def _odds(made: Study) -> list[float]:
    """Probability of backlash at every tension, among the structures that were compared."""
    return [
        max(each.probability for each in found.considered if each.suspect.effect == "backlash")
        for found in made.diagnoses.values()
    ]


def _errors(made: Study) -> str:
    """Errors of the force at every tension, by model."""
    rows = []
    for file, diagnosis in made.diagnoses.items():
        force = diagnosis.errors["damper"].force
        given = "-" if force is None else f"{100.0 * force.share_before:.1f}"
        rows.append([f"{file}, as given", "-", given, "-"])
        for words, found in (("corrected", made.errors), ("without the bench's mass", made.errors_without)):
            ours = [found[file].get(key) for key in KEYS]
            rows.append([f"{file}, {words}", *("-" if x is None else f"{100.0 * x:.1f}" for x in ours)])
        rows.append([f"{file}, LuGre", *("-" if x is None else f"{x}" for x in LUGRE[file])])
    return markdown_table(["relative force error [%]", "cycles from 2 to 5 s", *KEYS[1:]], rows)


def _left(made: Study) -> str:
    """The force that is left of the later cycles, by where it is left."""
    rows = [[file, *_shares(made.records[file], made.forces[file])] for file in made.forces]
    places = ["mean", "within 12 mm of a reversal", "beyond", "moving up", "moving down"]
    return markdown_table(["force that is left, later cycles [kN]", *places], rows)


def _drift_table(made: Study) -> str:
    """Means of each cycle while the brake slides, by direction: what is left, and the pulling end of the band [kN]."""
    cycles = range(1, 7)
    rows = []
    for file, force in made.forces.items():
        record = made.records[file]
        left = record["tau.damper"] - force
        for word, sign in (("up", 1.0), ("down", -1.0)):
            slides = _sliding(record, sign)
            ends = sorted((float(each[slides].mean()), name) for name in ("end_1", "end_2") for each in [record[name]])
            for what, column in (("left", left), ("the pulling end of the band", record[ends[-1][1]])):
                places = [slides & (record.t >= k) & (record.t < k + 1) for k in cycles]
                means = [1e-3 * float(np.nanmean(column[rows_])) for rows_ in places]
                rows.append([f"{file}, moving {word}: {what}", *(f"{x:.2f}" for x in means)])
    return markdown_table(["mean while it slides [kN]", *(f"{k} to {k + 1} s" for k in cycles)], rows)


def _sliding(record: fd.Recording, sign: float) -> NDArray[np.bool_]:
    """Samples at which the brake slides one way, more than 12 mm behind a reversal."""
    since, _ = distance(record)
    u = np.gradient(record["theta.damper"], record.t)
    return np.asarray((sign * u > 0.0) & (since > 0.012))


def _shares(record: fd.Recording, force: Array) -> list[str]:
    """Mean and root mean squares of what is left of the later cycles, by where it is left [kN]."""
    t, x = record.t, record["theta.damper"]
    left = 1e-3 * (record["tau.damper"] - force)
    rows = (t >= LATER[0]) & (t < LATER[1]) & np.isfinite(left)
    u = np.gradient(x, t)
    turns = np.concatenate([[True], u[1:] * u[:-1] < 0.0])
    since = np.abs(x - x[np.maximum.accumulate(np.where(turns, np.arange(len(x)), 0))])
    parts = (since < 0.012, since >= 0.012, u > 0.0, u < 0.0)
    sizes = [float(np.sqrt((left[rows & part] ** 2).mean())) for part in parts]
    return [f"{x:.2f}" for x in (float(left[rows].mean()), *sizes)]


def _draw(made: Study, file: Path) -> None:
    """Measured and computed force of every tension, over the position and over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 9.0), layout="constrained")
    axes = figure.subplots(len(made.forces), 2)
    for (left, right), (name, force) in zip(axes, made.forces.items(), strict=True):
        record = made.records[name]
        for axis, x, span in ((left, 1e3 * record["theta.damper"], FIT), (right, record.t, LATER)):
            rows = (record.t >= span[0]) & (record.t < span[1])
            axis.plot(x[rows], 1e-3 * record["tau.damper"][rows], color="0.2", linewidth=0.8, label="measured")
            axis.plot(x[rows], 1e-3 * force[rows], color="#1b5e9e", linewidth=0.8, label="computed")
            axis.set_ylabel("force [kN]")
        left.set_title(f"{name}, 2 to 5 s, of the fit")
        right.set_title(f"{name}, later cycles, not fitted")
    axes[0, 0].legend(fontsize="small")
    axes[-1, 0].set_xlabel("position [mm]")
    axes[-1, 1].set_xlabel("t [s]")
    figure.savefig(file, dpi=100)


def _draw_left(made: Study, file: Path) -> None:
    """What is left of every tension over the position, of the fit and later, and over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    axes = figure.subplots(len(made.forces), 2, sharey="row")
    for (left, right), (name, force) in zip(axes, made.forces.items(), strict=True):
        record = made.records[name]
        rest = 1e-3 * (record["tau.damper"] - force)
        for span, colour, label in ((FIT, "0.6", "2 to 5 s"), (LATER, "#1b5e9e", "5 to 8 s")):
            rows = (record.t >= span[0]) & (record.t < span[1])
            left.plot(1e3 * record["theta.damper"][rows], rest[rows], color=colour, linewidth=0.8, label=label)
            right.plot(record.t[rows], rest[rows], color=colour, linewidth=0.8)
        left.set_ylabel("measured - computed [kN]")
        left.set_title(name)
        for axis in (left, right):
            axis.axhline(0.0, color="0.2", linewidth=0.6)
    axes[0, 0].legend(fontsize="small")
    axes[-1, 0].set_xlabel("position [mm]")
    axes[-1, 1].set_xlabel("t [s]")
    figure.savefig(file, dpi=100)
