"""XL330: name what a plain servo lacks, then simulate it from its goal alone.

    python benchmarks/measured/xl330/xl330_study.py -o benchmarks/results/xl330.json

The names come from a diagnosis of four logs, volts from the firmware's law along the measured positions. The numbers
come from `xl330_fit.py`, which fits the motion from the goal alone: ``fitted.yaml`` to all eight logs,
``fitted_100_400.yaml`` to those of the gains 100 and 400, which is tested on the gains 200 and 800. Without the data
folder it says so and does nothing.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from xl330_data import HERE, Log, errors, from_goals, of_duties, read_logs
from xl330_fit import EVALUATIONS
from xl330_page import PUBLISHED, write_page
from xl330_result import TOLD, WITHOUT, Study

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import Task

DIAGNOSED = ("kp100_sin_sin", "kp200_sin_time_square", "kp400_sin_sin", "kp800_sin_time_square")
"""Logs with 2 s of motion and more under a driven motor."""
UNKNOWN = {"rotor inertia": ("rotor_inertia",), "rotor inertia and damping": ("rotor_inertia", "damping")}
"""Numbers of the gear that further diagnoses take for unknown; a stiffness cannot be."""
ALL, UNSEEN = 0.016, 0.045
"""Bounds of the mean absolute error of all logs, and of the gains 200 and 800 by a fit to 100 and 400 [rad]."""


def task(logs: Sequence[Log]) -> Task:
    """Four logs; the last fifth of the motion in each takes no part."""
    duties = of_duties([log for log in logs if log.name in DIAGNOSED])
    return Task("XL330", fd.load_model(HERE / "plain.yaml"), tuple(duties))


def not_guessed(plain: Task, numbers: Sequence[str]) -> Task:
    """The same with numbers of the servo unknown, which no data sheet tells."""
    model = plain.model.replace(joints={"servo": dict.fromkeys(numbers, "unknown")})
    return dataclasses.replace(plain, model=model)


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed."""
    return [task(read_logs(folder))]


def study(folder: Path) -> Study:
    """Everything, from the folder of logs."""
    logs = read_logs(folder)
    plain = task(logs)
    fitted = fd.load_model(HERE / "fitted.yaml")
    models = {
        "plain": fd.load_model(HERE / "plain.yaml"),
        "fitted": fitted,
        "fitted to gains 100 and 400": fd.load_model(HERE / "fitted_100_400.yaml"),
    }
    for name in WITHOUT:
        kept = [each for each in fitted.effects if each.name != name]
        models[f"fitted, less {name}"] = fitted.replace(effects=kept)
    begin = time.process_time()
    made = {name: errors(model, logs) for name, model in models.items()}
    each = (time.process_time() - begin) / len(models)
    unknown = {words: not_guessed(plain, numbers).diagnosis() for words, numbers in UNKNOWN.items()}
    return Study(plain.diagnosis(), unknown, logs, fitted, made, from_goals(fitted, logs), each)


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    return [
        Bound("mean absolute error from the goal alone, 8 logs [rad]", made.mean("fitted"), ALL),
        Bound("the same, fitted to gains 100 and 400, on 200 and 800 [rad]", made.unseen(), UNSEEN),
    ]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside every bound: the plain servo, and the best of the authors' models."""
    apart = np.array([log.gain not in TOLD for log in made.logs])
    plain = (made.mean("plain"), float(made.errors["plain"][apart].mean()))
    names = [each.name for each in bounds(made)]
    best = (min(each[k] for each in PUBLISHED.values()) / 1e3 for k in (0, 1))
    return {name: {"plain": x, "published": y} for name, x, y in zip(names, plain, best, strict=True)}


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    names = [log.name for log in made.logs]
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "errors": {key: dict(zip(names, each.tolist(), strict=True)) for key, each in made.errors.items()},
        "unseen_gains": made.unseen(),
        "search": {"evaluations": EVALUATIONS, "processor_seconds_per_evaluation": made.evaluation_seconds},
        "diagnosis": made.diagnosis.to_dict(),
        "diagnoses_of_unknown": {words: each.to_dict() for words, each in made.unknown.items()},
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    sys.exit(command(__file__, __doc__, "bam_xl330", ("xl330_kp100_sin_sin.csv",), parts))
