"""Double pendulum: start from the published model without friction, find what is missing, predict other motions.

    python benchmarks/measured/double_pendulum/pendulum_study.py -o benchmarks/results/double_pendulum.json

Fitted to 143601 (excitation) and 154220 (swing); 143524 and 154548 take no part. Writes the results, and beside them a
folder of that name with the page, its pictures and the diagnosis' own report. Without the data folder it says so and
does nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pendulum_data import CHECK, FIT, HERE, JOINTS, current, published, read_records, windows
from pendulum_page import write_page
from pendulum_result import Study

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import Task

MOST = {"joint1": 0.03, "joint2": 0.05}
"""Bounds of the errors on 143524 [rad]."""


def task(start: fd.FlexibleJointModel, records: Mapping[str, fd.Recording]) -> Task:
    """Two records are diagnosed; the other two take no part."""
    fit, check = (tuple(records[each] for each in names) for names in (FIT, CHECK))
    return Task("double pendulum", start, fit, check)


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed."""
    return [task(fd.load_model(HERE / "frictionless.yaml"), read_records(folder))]


def study(folder: Path) -> Study:
    """Everything, from the four records of a folder."""
    records = read_records(folder)
    start = fd.load_model(HERE / "frictionless.yaml")
    found = task(start, records).diagnosis()
    models = {"without friction, as given": start, "published friction": published(start), "found": found.model}
    by_model = {
        name: {stamp: windows(model, each) for stamp, each in records.items()} for name, model in models.items()
    }
    currents = {stamp: {joint: current(each, joint) for joint in JOINTS} for stamp, each in records.items()}
    return Study(found, by_model, currents)


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    rms = made.windows["found"][CHECK[0]].rms
    return [
        Bound(f"error of {joint} on {CHECK[0]} [rad]", float(x), MOST[joint])
        for joint, x in zip(JOINTS, rms, strict=True)
    ]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside every bound: the model without friction, and with the friction that was published."""
    plain, published = (
        made.windows[name][CHECK[0]].rms for name in ("without friction, as given", "published friction")
    )
    return {
        f"error of {joint} on {CHECK[0]} [rad]": {"plain": float(plain[j]), "published": float(published[j])}
        for j, joint in enumerate(JOINTS)
    }


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "rms_rad": {
            name: {stamp: [float(x) for x in each.rms] for stamp, each in by.items()}
            for name, by in made.windows.items()
        },
        "current": {stamp: {joint: asdict(each) for joint, each in by.items()} for stamp, by in made.currents.items()},
        "diagnosis": made.diagnosis.to_dict(),
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    sys.exit(
        command(
            __file__,
            __doc__,
            "dfki_double_pendulum",
            tuple(f"20230629-{name}.csv" for name in (*FIT, *CHECK)),
            parts,
        )
    )
