"""Friction damper: a prescribed motion and its force, at three tensions of the band.

    python benchmarks/measured/friction_damper/damper_study.py -o benchmarks/results/friction_damper.json

Names come from a diagnosis of three cycles of each 1 Hz file. The numbers in ``fitted.json`` come from
`damper_fit.py`, which reads the same cycles. Later cycles and the 0.5 Hz file are read here, for the errors alone.
Without the data folder it says so and does nothing.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from damper_compared import compared
from damper_data import FIT, HERE, LATER, SLOW, TENSIONS, Bench, error, errors, needed_force, read_records
from damper_fit import model_of, point_of
from damper_page import LUGRE, write_page
from damper_result import Study

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Outcome, command
from measure import Bound
from task import Task

MOST = {"1Hz_20lb": 0.17, "1Hz_35lb": 0.12, "1Hz_80lb": 0.11}
"""Bounds of the force errors of cycles that took no part [1]; that of 35 lb is missed."""
PARTS = ("backlash", "asymmetric_friction", "presliding_friction", "drum's mass")
"""What is left out one by one, the other numbers as they are."""


def fitted_numbers() -> dict[str, dict[str, float]]:
    """Of the models, by file."""
    found: dict[str, dict[str, float]] = json.loads((HERE / "fitted.json").read_text(encoding="utf-8"))
    return found


def task(plain: fd.FlexibleJointModel, record: fd.Recording) -> Task:
    """Three cycles of a 1 Hz file are diagnosed; later ones take no part."""
    return Task(f"damper, {record.name}", plain, (record.trim(*FIT),), (record.trim(*LATER),))


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed, by tension."""
    plain, records = fd.load_model(HERE / "plain.yaml"), read_records(folder)
    return [task(plain, records[name]) for name in fitted_numbers()]


def study(folder: Path) -> Study:
    """Everything, from the folder of records."""
    records, fits = read_records(folder), fitted_numbers()
    plain = fd.load_model(HERE / "plain.yaml")
    diagnoses = {name: task(plain, records[name]).diagnosis() for name in fits}
    models = {name: model_of(point_of(each)) for name, each in fits.items()}
    forces = {name: needed_force(*each, records[name].t, records[name]["q.damper"]) for name, each in models.items()}
    less = {part: {name: _less(part, *each, records[name]) for name, each in models.items()} for part in PARTS}
    bare = {name: (model.replace(effects=[]), Bench(0.0, 0.0, 0.0)) for name, (model, _) in models.items()}
    still = {name: (model, Bench(0.0, bench.offset, bench.lead)) for name, (model, bench) in models.items()}
    return Study(
        diagnoses,
        errors(models, records),
        errors(still, records),
        errors(bare, records),
        less,
        compared(fits, records),
        records,
        forces,
    )


def _less(part: str, model: fd.FlexibleJointModel, bench: Bench, record: fd.Recording) -> float:
    """Error of the fitted cycles without a part of the model [1]."""
    left_out = {"drum's mass": "payload"}.get(part, part)
    kept = model.replace(effects=[each for each in model.effects if each.name != left_out])
    seen = record.trim(0.0, FIT[1])
    return error(seen["tau.damper"], needed_force(kept, bench, seen.t, seen["q.damper"]), seen.t, FIT)


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
    """What stands beside every bound: the axis without friction, whose force is the inertia's alone, and LuGre."""
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
        "errors": made.errors,
        "errors_without_force_above_15_hz": made.slow_errors,
        "less": {part: dict(each) for part, each in made.less.items()},
        "numbers": {
            each.name: {"values": dict(each.values), "stds": dict(each.stds), "moved": each.moved}
            for each in made.compared
        },
        "diagnoses": {name: each.to_dict() for name, each in made.diagnoses.items()},
    }


def outcome(folder: Path) -> Outcome:
    """The study with its bounds and its page."""
    made = study(folder)
    held = bounds(made)
    return Outcome(held, results(made, held), lambda place: write_page(made, held, place))


if __name__ == "__main__":
    needs = [f"brfd_{name}.csv" for name in (*MOST, SLOW)]
    sys.exit(command(__file__, __doc__ or "", "arts_damper", needs, outcome))
