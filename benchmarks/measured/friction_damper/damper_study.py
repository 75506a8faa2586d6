"""Friction damper: a prescribed motion and its force, at three tensions of the band.

    python benchmarks/measured/friction_damper/damper_study.py -o benchmarks/results/friction_damper.json

Each 1 Hz file is diagnosed by itself, over its full cycles from 2 to 5 s; the tool then compares the three corrected
models. Later cycles and the 0.5 Hz file are read for errors and verdicts alone. Without the data
folder it says so and does nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from damper_data import (
    FIT,
    LATER,
    SLOW,
    TENSIONS,
    bench_mass,
    computed_force,
    errors,
    plain_model,
    read_records,
    without_bench,
)
from damper_page import LUGRE, write_page
from damper_result import Study

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import Task

MOST = {"1Hz_20lb": 0.17, "1Hz_35lb": 0.12, "1Hz_80lb": 0.11}
"""Bounds of the force errors of cycles that took no part [1]."""


def task(record: fd.Recording, mass: float) -> Task:
    """Some cycles of a 1 Hz file are diagnosed, later ones take no part; its published name says backlash."""
    clean = without_bench(record, mass)
    seen, later = (clean.trim(*span) for span in (FIT, LATER))
    return Task(f"damper, {record.name}", plain_model(clean), (seen,), (later,), ("backlash",))


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed, by tension."""
    records = read_records(folder)
    fast = [f"1Hz_{each}lb" for each in TENSIONS]
    mass = bench_mass(records[name] for name in fast)
    return [task(records[name], mass) for name in fast]


def undamped(model: fd.FlexibleJointModel) -> fd.FlexibleJointModel:
    """The model before its diagnosis without the damping that nobody knows: its force can be computed."""
    return model.replace(joints={"damper": {"damping": 0.0}})


def study(folder: Path) -> Study:
    """Everything, from the folder of records."""
    records = read_records(folder)
    fast = [f"1Hz_{each}lb" for each in TENSIONS]
    mass = bench_mass(records[name] for name in fast)
    plain = {name: task(records[name], mass) for name in fast}
    diagnoses = {name: each.diagnosis() for name, each in plain.items()}
    models = {name: each.model for name, each in diagnoses.items()}
    return Study(
        diagnoses,
        mass,
        errors(models, records, mass),
        errors(models, records, 0.0),
        errors({name: undamped(each.model) for name, each in plain.items()}, records, mass),
        fd.compare_models(list(diagnoses.values()), labels=[f"{each} lb" for each in TENSIONS]),
        records,
        {name: computed_force(model, records[name], mass) for name, model in models.items()},
    )


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    later = [
        Bound(f"force error, later cycles, {tension} lb", made.errors[name]["later cycles"], MOST[name])
        for tension in TENSIONS
        for name in [f"1Hz_{tension}lb"]
    ]
    slow = "1Hz_" + SLOW.rpartition("_")[2]
    return [*later, Bound("force error, half the frequency, 20 lb", made.errors[slow]["0.5 Hz"], MOST[slow])]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside every bound: the model before its diagnosis, a brake behind a spring, and LuGre."""
    found = {
        f"force error, later cycles, {tension} lb": _pair(made, f"1Hz_{tension}lb", "later cycles", 1)
        for tension in TENSIONS
    }
    return found | {
        "force error, half the frequency, 20 lb": _pair(made, "1Hz_" + SLOW.rpartition("_")[2], "0.5 Hz", 2)
    }


def _pair(made: Study, file: str, cycles: str, column: int) -> dict[str, float]:
    lugre = LUGRE[file][column]
    return {"plain": made.plain_errors[file][cycles]} | ({} if lugre is None else {"published": lugre / 100.0})


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "named": made.named(),
        "bench_mass": made.mass,
        "errors": made.errors,
        "errors_without_bench_mass": made.errors_without,
        "compared": made.compared.to_dict(),
        "diagnoses": {name: each.to_dict() for name, each in made.diagnoses.items()},
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    needs = [f"brfd_{name}.csv" for name in (*MOST, SLOW)]
    sys.exit(command(__file__, __doc__ or "", "arts_damper", needs, parts))
