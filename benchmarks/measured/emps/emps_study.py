"""EMPS: find what a plain rigid axis lacks, then put its controller around the model and compare forces.

    python benchmarks/measured/emps/emps_study.py -o benchmarks/results/emps.json

Fitted to the estimation record; the record with pulses takes no part, as with the authors. Writes the results, and
beside them a folder of that name with the page, its pictures and the diagnosis' own report. Without the data folder it
says so and does nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from emps_data import (
    HERE,
    NAMES,
    least_squares,
    published,
    read_records,
    replayed_controller,
)
from emps_page import write_page
from emps_result import Account, Study

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from command import Parts, command
from measure import Bound
from task import Task

EXPECTED = ("asymmetric_viscous_friction",)
"""What the axis is likely to have: its authors' second model has it (`published_either_way`)."""
PUBLISHED = ("published model", "published, friction of either direction")
"""Of the models that the errors are compared with."""
MOST = {"closed loop, DATA_EMPS": 0.039, "closed loop, PULSES": 0.05, "inverse model, DATA_EMPS": 0.032}
"""Bounds of the force errors [1]."""


def published_either_way(plain: fd.FlexibleJointModel) -> fd.FlexibleJointModel:
    """The report's second model: viscous and dry friction of either direction (its mass is the first's to 0.05 %)."""
    dry = fd.effects.AsymmetricFriction("carriage", side="motor", level_positive=20.1440, level_negative=20.6277)
    viscous = fd.effects.AsymmetricViscousFriction(
        "carriage", side="motor", coefficient_positive=166.7061, coefficient_negative=240.4236
    )
    return plain.replace(effects=[viscous, dry])


def task(plain: fd.FlexibleJointModel, records: Mapping[str, fd.Recording]) -> Task:
    """The estimation record is diagnosed; the one with pulses takes no part."""
    return Task("EMPS", plain, (records[NAMES[0]],), (records[NAMES[1]],), EXPECTED)


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed."""
    return [task(fd.load_model(HERE / "plain.yaml"), read_records(folder))]


def study(folder: Path) -> Study:
    """Everything, from the two records of a folder."""
    records = read_records(folder)
    plain = fd.load_model(HERE / "plain.yaml")
    found = task(plain, records).diagnosis()
    accounts = {
        "plain axis, as given": Account.of(plain, records),
        "published model": Account.of(published(plain), records),
        "published model, controller a sample late": Account.of(published(plain), records, delay=1),
        "published, friction of either direction": Account.of(published_either_way(plain), records),
        "found": Account.of(found.model, records),
    }
    late = {k: {name: replayed_controller(each, k) for name, each in records.items()} for k in (-1, 0, 1)}
    reference = least_squares(records[NAMES[0]], list(records.values()))
    return Study(found, accounts, late, dict(zip(records, reference, strict=True)))


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    errors = made.accounts["found"].errors()
    return [Bound(f"force error, {name}", errors[name], most) for name, most in MOST.items()]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside every bound: the plain axis, and the better one of the published models, of every record."""
    plain, *authors = (made.accounts[name].errors() for name in ("plain axis, as given", *PUBLISHED))
    return {
        f"force error, {name}": {"plain": plain[name], "published": min(each[name] for each in authors)}
        for name in MOST
    }


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "errors": {name: each.errors() for name, each in made.accounts.items()},
        "plain_least_squares_force_error": dict(made.reference),
        "controller_replayed_error_by_delay": {str(k): dict(each) for k, each in made.late.items()},
        "diagnosis": made.diagnosis.to_dict(),
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    sys.exit(
        command(
            __file__,
            __doc__,
            "emps",
            ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"),
            parts,
        )
    )
