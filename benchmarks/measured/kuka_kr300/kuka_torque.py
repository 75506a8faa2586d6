"""What the torque of the KUKA's axes is made of: inverse models, fitted to record A, looked at on B and C."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from along import MOVING, Inverse, along

Array = NDArray[np.float64]
HERE = Path(__file__).parent
RECORDS = ("A", "B", "C")
SAMPLE = 0.004
"""Of the records [s]."""


def read_records(folder: Path) -> dict[str, fd.Recording]:
    """All three, with both encoders."""
    return {
        name: fd.read_recording(folder / f"recorded_{name}.mat", map=HERE / "map.yaml", name=name) for name in RECORDS
    }


def motor_side(recording: fd.Recording) -> fd.Recording:
    """Motor encoders and torques alone: what a rigid model is held against."""
    kept = {name: each for name, each in recording.channels.items() if name.startswith(("theta.", "tau."))}
    return fd.Recording(recording.t, kept, name=recording.name)


def inverse(model: fd.FlexibleJointModel, recording: fd.Recording) -> Inverse:
    """The torque that a model needs for a record's motion, and what is missing to the one that was measured."""
    return along(model, motor_side(recording))


def torque_noise(of: Inverse) -> Array:
    """White noise, sample by sample of the record, that would leave as little sure as what is left (n,) [N m].

    What is left is coloured: its root mean square times the root of its correlation time in samples.
    """
    every = (of.t[1] - of.t[0]) / SAMPLE
    found = []
    for left in of.missing.T:
        x = left - left.mean()
        along = np.correlate(x, x, "full")[len(x) - 1 :] / (x @ x)
        first = int(np.argmax(along < 0.05))
        found.append(left.std() * np.sqrt((1.0 + 2.0 * along[1:first].sum()) * every))
    return np.array(found)


LAWS: Mapping[str, Callable[[Array], list[Array]]] = {
    "viscous, Coulomb, offset": lambda q: [],
    "and a spring": lambda q: [q],
    "and a balancer's cosine": lambda q: [np.cos(q)],
    "and both first harmonics": lambda q: [np.cos(q), np.sin(q)],
    "and harmonics 1 and 2": lambda q: [np.cos(q), np.sin(q), np.cos(2 * q), np.sin(2 * q)],
}
"""Laws of position tried beside friction by plain least squares."""


def references(
    model: fd.FlexibleJointModel, records: Mapping[str, fd.Recording], j: int
) -> dict[str, dict[str, float]]:
    """Plain least squares on the moving rows of record A: what is reachable, and the error of every record [1].

    Args:
        model: its friction is left out and fitted anew.
        records: A, B and C.
        j: the joint.
    """
    bare = model.replace(effects=[])
    seen = {name: inverse(bare, each) for name, each in records.items()}
    found: dict[str, dict[str, float]] = {}
    for law, columns in LAWS.items():

        def X(of: Inverse, columns: Callable[[Array], list[Array]] = columns) -> Array:
            u, q = of.omega[:, j], of.q[:, j]
            return np.stack([u, np.clip(u / 1e-3, -1.0, 1.0), np.ones_like(u), *columns(q)], axis=1)

        moves = np.abs(seen["A"].omega[:, j]) > MOVING
        fitted = np.linalg.lstsq(X(seen["A"])[moves], seen["A"].missing[moves, j], rcond=None)[0]
        found[law] = {}
        for name, of in seen.items():
            left = of.missing[:, j] - X(of) @ fitted
            found[law] |= {name: of.error(j, left), f"{name} moving": of.error(j, left, moving=True)}
    return found
