"""Fuzzing of the model file: random structures in place of any value, and damage to its text."""

from __future__ import annotations

import copy
import datetime
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.io.yaml import dump_yaml
from flexdyn.model.model_file import model_from_dict

CONTENT: dict[str, Any] = {
    "flexdyn": 1,
    "robot": {
        "urdf": "scara_two_link",
        "package_dirs": ["."],
        "gravity": [0.0, 0.0, -9.81],
        "lock": {"elbow": 0.1},
        "urdf_dynamics": "use",
        "rotor_coupling": "reduced",
    },
    "joints": {"*": {"damping": 1.0}, "shoulder": {"rotor_inertia": 0.1, "stiffness": 40.0, "gear_ratio": 2.0}},
    "initial": {"q": {"shoulder": 1.0}, "theta": {"shoulder": 1.0}},
    "tolerance": {"*": 0.03, "joints.shoulder.stiffness": 0.1},
    "effects": [
        {"effect": "viscous_friction", "joint": "shoulder", "side": "motor", "coefficient": 3.0},
        {"effect": "torque_speed_limit", "joint": "shoulder", "stall_torque": 1.0, "no_load_speed": 2.0},
        {"effect": "payload", "mass": 1.0, "frame": "tool"},
    ],
}
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-(10**30), 10**30),
    st.floats(),
    st.text(max_size=20),
    st.binary(max_size=5),
    st.dates(),
    st.sampled_from(["shoulder", "elbow", "*", "inf", "payload", "q", "\0", "x" * 5000, datetime.datetime.min]),
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(SCALARS, inner, max_size=3), max_leaves=6
)


def one_line(error: fd.InputError) -> None:
    """It is printable, without a line break, and of bounded length."""
    assert str(error).isprintable()
    assert len(str(error)) < 1500


def paths(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of every value in a structure."""
    yield at
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in entries:
        yield from paths(inner, (*at, key))


def changed(path: tuple[Any, ...], value: Any) -> Any:
    """The valid content with one value replaced."""
    if not path:
        return value
    content = copy.deepcopy(CONTENT)
    place: Any = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return content


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(path=st.sampled_from(list(paths(CONTENT))), value=VALUES)
@example(path=("joints", "shoulder", "stiffness"), value=10**5000)
@example(path=("effects", 2, "frame"), value={"a": 1})
@example(path=("robot", "urdf"), value="x" * 5000)
def test_no_value_anywhere_raises_anything_else(tmp_path: Path, path: tuple[Any, ...], value: Any) -> None:
    """A model or an InputError of one line: nothing else, whatever stands wherever."""
    try:
        model = model_from_dict(changed(path, value), tmp_path)
    except fd.InputError as error:
        one_line(error)
    else:
        assert isinstance(hash(model), int)


VALID = dump_yaml(CONTENT)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    at=st.integers(0, len(VALID)),
    length=st.integers(0, 12),
    insert=st.text("{}[]:,#&*!|>'\"%@`-?\n\t 01.e<=~\\x", max_size=6),
)
def test_no_damage_to_the_text_raises_anything_else(tmp_path: Path, at: int, length: int, insert: str) -> None:
    """Characters lost and syntax strewn in: a model or one line."""
    file = tmp_path / "model.yaml"
    file.write_text(VALID[:at] + insert + VALID[at + length :], encoding="utf-8")
    try:
        fd.load_model(file)
    except fd.InputError as error:
        one_line(error)
