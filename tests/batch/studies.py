"""Small studies on disk, and what a store is compared by."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import flexdyn as fd
from flexdyn.io.yaml import dump_yaml

ARM: dict[str, Any] = {
    "flexdyn": 1,
    "robot": {"urdf": "scara_two_link"},
    "joints": {
        "shoulder": {"gear_ratio": 100.0, "rotor_inertia": 1e-5, "stiffness": 40.0, "damping": 0.1},
        "elbow": {"gear_ratio": 100.0, "rotor_inertia": 1e-5, "stiffness": 30.0, "damping": 0.1},
    },
    "initial": {"q": {"elbow": 1.0}, "v": {"shoulder": 0.5}},
    "effects": [
        {"effect": "viscous_friction", "joint": "shoulder", "side": "motor", "coefficient": 0.02},
        {"effect": "coulomb_friction", "joint": "elbow", "side": "motor", "level": 0.05},
        {"effect": "payload", "mass": 0.5},
    ],
}
STUDY: dict[str, Any] = {
    "flexdyn_study": 1,
    "model": "arm.yaml",
    "command": "torque.csv",
    "duration": 0.2,
    "rate": 100,
    "solver": {"name": "TimeStepping", "step": 1e-3},
    "runs": 12,
    "seed": 7,
    "vary": {
        "joints.shoulder.stiffness": {"uniform": [20, 60]},
        "joints.elbow.rotor_inertia": {"lognormal": [1e-5, 0.1]},
        "effects[1].level": {"normal": [0.05, 0.01]},
    },
    "keep": ["q", "theta"],
    "metrics": ["tip_deflection_max"],
    "chunk": 4,
}


def write_study(folder: Path, **changes: Any) -> Path:
    """Write study.yaml, arm.yaml, torque.csv and path.csv.

    Args:
        folder: to write to; it is made.
        changes: keys of the study that are other than in `STUDY`; None leaves one out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.yaml").write_text(dump_yaml(ARM))
    t = np.linspace(0.0, 0.2, 41)
    torque = fd.Recording(t, {"tau.shoulder": 0.3 * np.sin(20 * t), "tau.elbow": 0.1 * np.cos(15 * t)})
    fd.write_recording(torque, folder / "torque.csv")
    path = fd.Recording(t, {"q.shoulder": 0.2 * t, "q.elbow": 1.0 + 0.5 * t * t})
    fd.write_recording(path, folder / "path.csv")
    content = {key: value for key, value in (STUDY | changes).items() if value is not None}
    (folder / "study.yaml").write_text(dump_yaml(content))
    return folder / "study.yaml"


def tree(store: Path) -> dict[str, bytes]:
    """Every file of a folder by its path in it, byte for byte."""
    return {str(file.relative_to(store)): file.read_bytes() for file in store.rglob("*") if file.is_file()}


def pieces(store: Path) -> list[Path]:
    """The files that hold chunks of runs, in order."""
    coordinates = {"run", "time", "joint"}
    return sorted(file for file in store.rglob("c.*") if file.parent.name not in coordinates)
