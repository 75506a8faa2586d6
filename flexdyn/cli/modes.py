"""The output of flexdyn info --modes: eigenfrequencies, damping, shapes, anti-resonances; frequencies over a path."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexdyn.analysis.eigenmodes import modes
from flexdyn.analysis.modes_result import Modes
from flexdyn.analysis.path import PathFrequencies, frequencies_over_path
from flexdyn.arrays import evenly
from flexdyn.cli.output import cell, table
from flexdyn.errors import placed
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import read_recording

SHOWN_SHAPE_SHARE = 0.1
"""Share of a shape's largest entry from which an entry is shown."""
PATH_POSES = 400
"""Number of poses of a path that are used."""


def modes_document(model: FlexibleJointModel, q: Mapping[str, float]) -> dict[str, Any]:
    """The modes of a model about a pose, as the JSON document holds them.

    Args:
        model: the arm.
        q: positions by joint over the model's initial ones [rad or m].

    Returns:
        ``free``: modes with free rotors, and the anti-resonances; ``held``: modes with held rotors, null if every joint
        is rigid.
    """
    free = modes(model, q)
    held = modes(model, q, rotors="held") if model.elastic.any() else None
    return {
        "q": dict(zip(model.joint_names, free.q.tolist(), strict=True)),
        "free": _rows(free),
        "held": None if held is None else _rows(held),
        "anti_resonances": {
            joint: [zero for zero in zeros.tolist() if zero > 0]
            for joint, zeros in zip(model.joint_names, free.anti_resonances, strict=True)
        },
    }


def _rows(found: Modes) -> list[dict[str, Any]]:
    """Every mode with the largest entry of its shape."""
    rows = []
    for row in found.rows():
        entries = _entries(row)
        rows.append(row | {"dominant": {"joint": entries[0][0], "part": entries[0][1]}})
    return rows


def _entries(row: Mapping[str, Any]) -> list[tuple[str, str, float]]:
    """Joint, part and size of every entry of a shape, the largest first; a link before its rotor."""
    entries = [(joint, part, value) for part in ("link", "rotor") for joint, value in row[part].items()]
    return sorted(entries, key=lambda entry: -abs(entry[2]))


def tables(document: Mapping[str, Any], elastic: Mapping[str, bool]) -> list[Any]:
    """The modes as text.

    Args:
        document: of `modes_document`.
        elastic: by joint; the rotor of a rigid joint is not shown.
    """
    at = ", ".join(f"{joint} {cell(value)}" for joint, value in document["q"].items())
    made: list[Any] = [_table(f"Modes at {at}, rotors let go", document["free"], elastic)]
    if document["held"] is not None:
        made.append(_table("Modes with the rotors held", document["held"], elastic))
    rows = [
        (joint, ", ".join(f"{cell(zero)} Hz" for zero in zeros) or "none")
        for joint, zeros in document["anti_resonances"].items()
    ]
    made.append(table("Anti-resonances, from a motor's torque to its own speed", ("motor", "frequencies"), rows))
    return made


def _table(title: str, modes_: list[dict[str, Any]], elastic: Mapping[str, bool]) -> Any:
    columns = ("mode", "frequency", "damping", "kind", "moves most", f"shape, entries from {SHOWN_SHAPE_SHARE:g}")
    rows = []
    for row in modes_:
        ratio = "-" if row["damping_ratio"] is None else f"{100 * row['damping_ratio']:.3g} %"
        most = row["dominant"]["joint"]
        part = f"{most} {row['dominant']['part']}" if elastic[most] else most
        rows.append((row["mode"], f"{cell(row['frequency'])} Hz", ratio, row["kind"], part, _shape(row, elastic)))
    return table(title, columns, rows, right=("mode", "frequency", "damping"))


def _shape(row: Mapping[str, Any], elastic: Mapping[str, bool]) -> str:
    """The larger entries of a shape; a joint whose rotor and link move together has one entry."""
    shown = []
    for joint, part, value in _entries(row):
        twin = row["rotor" if part == "link" else "link"][joint]
        together = not elastic[joint] or cell(value, 2) == cell(twin, 2)
        if abs(value) >= SHOWN_SHAPE_SHARE and not (together and part == "rotor"):
            shown.append(f"{joint} {cell(value, 2)}" if together else f"{joint} {part} {cell(value, 2)}")
    return ", ".join(shown)


def along(model: FlexibleJointModel, path: Path) -> PathFrequencies:
    """Frequencies along the q of a recording, with free rotors.

    Raises:
        InputError: a joint whose q the recording lacks.
    """
    recording = read_recording(path)
    with placed(file=path):
        poses = recording.signal("q", model.joint_names)
    kept = evenly(len(poses), PATH_POSES)
    return frequencies_over_path(model, poses[kept])
