"""Three screw drives: which show Stribeck friction, which do not, in which direction.

    python benchmarks/measured/screw_drives/screw_study.py -o benchmarks/results/screw_drives.json

Runs at constant speed (0.096 kg) make a friction curve a direction; laws are named where half of the speeds predicts
the other half better with them, and the start-stop files, which take no part, do not speak against them
(`fd.steady_friction`). Writes the results, and beside them a folder of that name with the page and its picture.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from screw_page import write_page
from screw_result import Drive, Stretch, Studied

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import decimated

HERE = Path(__file__).parent
EDITED = {"driveNo3": ("1.csv", "2.csv", "n1.csv")}
"""Files in which somebody typed over measured values: left out."""


LEAD = 2.0 * math.pi / 0.002
DRIVES = (
    Drive("driveNo1", "lead screw", "map_lead_screw.yaml", "nut", LEAD, "increment 0.1, velocity 6.4 rad/s (61 rpm)"),
    Drive("driveNo2", "anti-backlash lead screw", "map_lead_screw.yaml", "nut", LEAD, "velocity 0: none"),
    Drive("driveNo3", "worm 60:1", "map_worm.yaml", "wheel", 60.0, "increment 0.06, velocity 0.688 rad/s (6.6 rpm)"),
)


def read_runs(folder: Path, drive: Drive) -> list[fd.Recording]:
    """Runs at constant speed, but for files in which measured values were typed over."""
    steady = sorted((folder / drive.name / "steady_state" / "0.096kg").glob("*.csv"))
    kept = [path for path in steady if path.name not in EDITED.get(drive.name, ())]
    return [fd.read_recording(path, map=HERE / drive.map, name=path.stem) for path in kept]


def studied(folder: Path, drive: Drive, factor: int = 1) -> Studied:
    """Everything of one drive, its steady runs with one sample of so many; start-stop files are too short for that."""
    runs = [decimated(each, factor) for each in read_runs(folder, drive)]
    points = fd.steady_points(runs, drive.joint)
    files = sorted((folder / drive.name / "start_stop").glob("*.csv"))
    moves = [_underway(drive, fd.read_recording(path, map=HERE / drive.map, name=path.stem)) for path in files]
    check = fd.steady_points([under for pair in moves for under, _ in pair], drive.joint)
    curves = fd.steady_friction(points, check)
    starts = {under.name: start for pair in moves for under, start in pair}
    plain = {direction: _plain([p for p in points if p.speed * direction > 0.0]) for direction in (1, -1)}
    return Studied(drive, points, check, curves, tuple(_stretch(drive, p, curves, plain, starts) for p in check))


def _underway(drive: Drive, run: fd.Recording) -> list[tuple[fd.Recording, float]]:
    """The motion in each direction without its first and last 0.5 s, and how far its first 0.2 s stand out of it."""
    speed, torque = run[f"omega.{drive.joint}"], run[f"tau.{drive.joint}"]
    found = []
    for direction in (1.0, -1.0):
        rows = np.flatnonzero(speed * direction > 0.25 * np.abs(speed).max())
        part = run.trim(run.t[rows[0]] + 0.5, run.t[rows[-1]] - 0.5)
        part = fd.Recording(
            part.t, part.channels, meta=part.meta, name=f"{run.name}.csv {'+' if direction > 0 else '-'}"
        )
        under = part[f"tau.{drive.joint}"]
        first = torque[rows[run.t[rows] < run.t[rows[0]] + 0.2]]
        found.append((part, float((direction * (first - under.mean())).max() / under.std())))
    return found


def _plain(points: list[fd.SteadyPoint]) -> tuple[float, float]:
    """Level and viscous coefficient alone, by least squares."""
    std = np.array([point.std for point in points])
    X = np.array([[1.0, abs(point.speed)] for point in points]) / std[:, None]
    level, slope = np.linalg.lstsq(X, np.array([abs(point.torque) for point in points]) / std, rcond=None)[0]
    return float(level), float(slope)


def _stretch(
    drive: Drive,
    point: fd.SteadyPoint,
    curves: Mapping[int, fd.SteadyFriction],
    plain: Mapping[int, tuple[float, float]],
    starts: Mapping[str, float],
) -> Stretch:
    direction = 1 if point.speed > 0.0 else -1
    milli = 1e3 / drive.ratio
    level, slope = plain[direction]
    return Stretch(
        file=point.name,
        speed=point.speed * drive.ratio * 30.0 / math.pi,
        torque=point.torque * milli,
        std=point.std * milli,
        predicted=curves[direction].torque(point.speed) * milli,
        plain=direction * (level + slope * abs(point.speed)) * milli,
        start=starts[point.name],
    )


def bounds(made: tuple[Studied, ...]) -> list[Bound]:
    """No law without the check of other speeds; the curves predict the start-stop files."""
    unchecked = sum(
        each.named and (min(each.prediction) < 0.0 or sum(each.prediction) <= 0.0)
        for of in made
        for curve in of.curves.values()
        for each in curve.trials
    )
    off = [abs(each.predicted / each.torque - 1.0) for of in made for each in of.stretches]
    return [
        Bound("laws named that other speeds do not confirm", float(unchecked), 0.0),
        Bound("median error of the torque predicted for start-stop files", float(np.median(off)), 0.1),
    ]


def beside(made: tuple[Studied, ...]) -> dict[str, dict[str, float]]:
    """What stands beside the second bound: the best curves of Coulomb and viscous friction alone."""
    off = [abs(each.plain / each.torque - 1.0) for of in made for each in of.stretches]
    return {"median error of the torque predicted for start-stop files": {"plain": float(np.median(off))}}


def results(made: tuple[Studied, ...], held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "drives": {
            of.drive.name: {
                "what": of.drive.words,
                "directions": {
                    f"{direction:+d}": {
                        "named": list(curve.named),
                        "level": curve.level,
                        "viscous": curve.viscous,
                        "scatter": curve.scatter,
                        "speeds": curve.speeds,
                        "trials": [asdict_of(each) for each in curve.trials],
                    }
                    for direction, curve in of.curves.items()
                },
                "start_stop": [asdict(each) for each in of.stretches],
            }
            for of in made
        },
    }


def asdict_of(trial: fd.LawTrial) -> dict[str, Any]:
    """A trial as JSON takes it."""
    return vars(trial) | {"numbers": dict(trial.numbers), "intervals": dict(trial.intervals)}


def study(folder: Path) -> tuple[Studied, ...]:
    """Every drive."""
    return tuple(studied(folder, drive) for drive in DRIVES)


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    sys.exit(
        command(
            __file__,
            __doc__,
            "screw_drives",
            ("driveNo1", "driveNo2", "driveNo3"),
            parts,
        )
    )
