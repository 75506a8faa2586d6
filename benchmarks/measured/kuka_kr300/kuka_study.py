"""KUKA KR 300: what its torque lacks, and what the difference of its encoders is made of.

    python benchmarks/measured/kuka_kr300/kuka_study.py -o benchmarks/results/kuka_kr300.json

Record A is fitted, B and C are looked at, as the authors did. Writes the results, and beside them a folder of that name
with the page, its pictures and the diagnosis' own report. Without the data folder it says so and does nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from kuka_encoders import account, differences, ripple
from kuka_page import write_page
from kuka_result import Study
from kuka_torque import HERE, RECORDS, inverse, motor_side, read_records, references, torque_noise

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import Task

AXIS = 1
"""The second axis, which carries most of the weight."""
BOTH = (0, 1, 2)
"""Axes with two encoders."""
MOST = 0.20
"""Bound of the second axis' torque error on B and C [1]."""


def task(model: fd.FlexibleJointModel, records: Mapping[str, fd.Recording]) -> Task:
    """Record A is diagnosed, motor encoders alone; B and C take no part."""
    motors = {name: motor_side(each) for name, each in records.items()}
    return Task("KUKA KR 300", model, (motors["A"],), (motors["B"], motors["C"]))


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed."""
    return [task(fd.load_model(HERE / "rigid.yaml"), read_records(folder))]


def study(folder: Path) -> Study:
    """Everything, from the three records of a folder."""
    records = read_records(folder)
    model = fd.load_model(HERE / "rigid.yaml")
    given = task(model, records)
    found = given.diagnosis()
    after = {name: inverse(found.model, each) for name, each in records.items()}
    seen = {name: differences(found.model, each, BOTH) for name, each in records.items()}
    by_axis = [{name: each[j] for name, each in seen.items()} for j in BOTH]
    return Study(
        references=references(model, records, AXIS),
        diagnosis=found,
        before={name: inverse(model, each) for name, each in records.items()},
        after=after,
        bare={name: inverse(model.replace(effects=[]), records[name]) for name in ("B", "C")},
        told=fd.base_parameters(model, given.fit[0], noise=torque_noise(after["A"]), friction=True),
        differences=by_axis,
        accounts=[account(each) for each in by_axis],
        ripples=[ripple(each) for each in by_axis],
    )


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    found = [Bound(f"torque error of axis 2 on {name}", made.after[name].error(AXIS), MOST) for name in ("B", "C")]
    named = {each.suspect.effect for each in made.diagnosis.findings if each.suspect.joint == "axis2"}
    wrong = 0.0 if named & {"parallel_spring", "position_torque"} else 1.0
    return [*found, Bound("findings without a law of position on axis 2", wrong, 0.0)]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside the bounds: the links and rotors alone, and the published model with its friction."""
    return {
        f"torque error of axis 2 on {name}": {
            "plain": made.bare[name].error(AXIS),
            "published": made.before[name].error(AXIS),
        }
        for name in ("B", "C")
    }


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    joints = made.diagnosis.model.joint_names
    errors = {
        name: {joint: [of.error(j), of.error(j, moving=True)] for j, joint in enumerate(joints)}
        for name, of in made.after.items()
    }
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "axis2_torque_error_of_plain_least_squares": made.references,
        "torque_error_after_diagnosis_all_and_moving": errors,
        "diagnosis": made.diagnosis.to_dict(),
        "base_parameters": {
            "rank": made.told.rank,
            "condition": made.told.condition,
            "numbers": [asdict(each) for each in made.told.numbers],
        },
        "encoders": {
            joints[j]: asdict(made.accounts[j]) | {"ripple": asdict(made.ripples[j])} for j in range(len(made.accounts))
        },
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    sys.exit(
        command(
            __file__,
            __doc__,
            "kuka_kr300",
            tuple(f"recorded_{name}.mat" for name in RECORDS),
            parts,
        )
    )
