"""Kinova Gen3: what sweeps of single joints in one direction tell of a plain URDF, and what they cannot.

    python benchmarks/measured/kinova_gen3/kinova_study.py -o benchmarks/results/kinova_gen3.json

Four sweeps are diagnosed, each from the URDF without friction. What they name is then held against a trajectory of all
seven joints, three times as fast, which no decision read. Without the data folder it says so and does nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from kinova_data import ALL, SWEPT, cycles, plain, read_sweep, read_trajectory, whole
from kinova_page import write_page
from kinova_result import Reference, Study
from kinova_trial import Sweep, trial

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from along import Inverse, along
from command import Parts, command
from measure import Bound
from task import Task

EXPECTED = ("payload",)
"""What the arm is likely to have: whether a gripper was mounted is not said."""
MOST = {1: 0.6, 4: 0.7, 5: 0.2, 7: 0.45}
"""Bounds of the torque errors over the trajectory [1]."""


def tasks(folder: Path) -> list[Task]:
    """What is diagnosed, by joint; the last fifth of each sweep takes no part."""
    return [Task(f"Kinova Gen3, joint {j}", plain(folder, j), (read_sweep(folder, j),), expect=EXPECTED) for j in SWEPT]


def study(folder: Path) -> Study:
    """Everything, from the folder of recordings."""
    diagnoses = {j: task.diagnosis() for j, task in zip(SWEPT, tasks(folder), strict=True)}
    trajectory, bare = read_trajectory(folder), whole(folder)
    found = corrected(bare, diagnoses)
    models = {"plain URDF": bare, "found": found}
    inverses = {name: along(model, trajectory) for name, model in models.items()}
    trials = [
        trial(Sweep(j, _bare(folder, j), read_sweep(folder, j)), others(found, j), trajectory, diagnosis, k)
        for j, diagnosis in diagnoses.items()
        for k in range(len(diagnosis.findings))
    ]
    references = {j: reference(inverses["plain URDF"], trajectory, bare, j) for j in SWEPT}
    counted = {f"joint_{j}_trapez": _cycles(folder, f"joint_{j}_trapez", (j,)) for j in SWEPT}
    counted["trajectory1"] = _cycles(folder, "trajectory1", ALL)
    return Study(diagnoses, models, inverses, trials, references, counted)


def corrected(bare: fd.FlexibleJointModel, diagnoses: Mapping[int, fd.Diagnosis]) -> fd.FlexibleJointModel:
    """The whole arm with the rotors and the effects of every sweep's corrected model."""
    rotors, effects = {}, []
    for j, diagnosis in diagnoses.items():
        joint = diagnosis.model.resolved().joints[f"joint_{j}"]
        rotors[f"joint_{j}"] = {"rotor_inertia": joint.rotor_inertia}
        effects += [each for each in diagnosis.model.effects if not isinstance(each, fd.effects.ParameterError)]
    return bare.replace(joints=rotors, effects=effects)


def others(found: fd.FlexibleJointModel, joint: int) -> fd.FlexibleJointModel:
    """The whole arm with what the sweeps of other joints found."""
    own = f"joint_{joint}"
    payload = joint == 4  # it was found there, and all joints carry it
    kept = [
        each
        for each in found.effects
        if getattr(each, "joint", None) != own and not (payload and isinstance(each, fd.effects.Payload))
    ]
    return found.replace(effects=kept)


def _bare(folder: Path, joint: int) -> fd.FlexibleJointModel:
    """The plain model of a joint without its rotor."""
    return plain(folder, joint).replace(joints={f"joint_{joint}": {"rotor_inertia": 0.0}})


def reference(bare: Inverse, trajectory: fd.Recording, model: fd.FlexibleJointModel, joint: int) -> Reference:
    """What is within reach: least squares of three numbers on what the URDF leaves of the trajectory."""
    k, inertia = joint - 1, 1e-3
    rotor = model.replace(joints={f"joint_{joint}": {"rotor_inertia": inertia}})
    per_inertia = (bare.missing[:, k] - along(rotor, trajectory).missing[:, k]) / inertia
    u = bare.omega[:, k]
    X = np.stack([per_inertia, u, np.clip(u / 1e-2, -1.0, 1.0)], axis=1)
    scale = np.abs(X).max(axis=0)
    fitted = np.linalg.lstsq(X / scale, bare.missing[:, k], rcond=None)[0] / scale
    a, b, c = (float(x) for x in fitted)
    return Reference((a, b, c), bare.error(k, bare.missing[:, k] - X @ fitted))


def _cycles(folder: Path, name: str, joints: tuple[int, ...]) -> tuple[int, int, int]:
    """Rows that repeat, that follow by one cycle, and that follow by more."""
    steps = cycles(fd.read_recording(folder / f"{name}.csv"), joints)
    return int((steps == 0).sum()), int((steps == 1).sum()), int((steps > 1).sum())


def bounds(made: Study) -> list[Bound]:
    """What must hold."""
    lost = sum(not each.survives for each in made.trials)
    errors = [Bound(f"torque error of joint {j} on trajectory1", made.error("found", j), MOST[j]) for j in SWEPT]
    return [Bound("names that trajectory1 speaks against", float(lost), 0.0), *errors]


def beside(made: Study) -> dict[str, dict[str, float]]:
    """What stands beside the bounds: the plain URDF, and least squares on that very record, as nothing is published."""
    return {
        f"torque error of joint {j} on trajectory1": {
            "plain": made.error("plain URDF", j),
            "published": made.references[j].error,
        }
        for j in SWEPT
    }


def results(made: Study, held: list[Bound]) -> dict[str, Any]:
    """As the result file holds it."""
    return {
        "bounds": [each.to_dict() for each in held],
        "beside": beside(made),
        "torque_errors_on_trajectory1": {
            name: {f"joint_{j}": each.error(j - 1) for j in ALL} for name, each in made.inverses.items()
        },
        "trials": [asdict(each) for each in made.trials],
        "plain_least_squares_on_trajectory1": {f"joint_{j}": asdict(each) for j, each in made.references.items()},
        "cycles": {name: list(each) for name, each in made.cycles.items()},
        "diagnoses": {f"joint_{j}": each.to_dict() for j, each in made.diagnoses.items()},
    }


if __name__ == "__main__":
    parts = Parts(study, bounds, results, write_page)
    needs = [*(f"joint_{j}_trapez.csv" for j in SWEPT), "trajectory1.csv", "gen3.urdf"]
    sys.exit(command(__file__, __doc__, "kinova_gen3", needs, parts))
