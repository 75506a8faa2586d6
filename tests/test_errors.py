"""Errors are one line, carry their data, survive a trip to another process, and cannot be flooded."""

from __future__ import annotations

from typing import Any

import pytest

from flexdyn import FlexdynError, InputError, MissingExtra, SimulationError
from flexdyn.errors import did_you_mean, shown
from tests.arms import repickled


def test_the_line_names_file_key_value_and_remedy() -> None:
    """In this order, and only what is known."""
    error = InputError(
        "it must be above 0", file="arm.yaml", key="joints.elbow.stiffness", value=-1.0, remedy="use .inf"
    )
    assert str(error) == "arm.yaml: joints.elbow.stiffness: it must be above 0, got -1.0; use .inf"
    assert str(InputError("it is wrong")) == "it is wrong"


def test_data_reads_as_attributes() -> None:
    """What an error carries is there by name; what it does not carry is an AttributeError."""
    error = InputError("no", key="a", row=3)
    assert (error.key, error.row, error.file) == ("a", 3, None)
    with pytest.raises(AttributeError, match="column"):
        _ = error.column


@pytest.mark.parametrize(
    "error",
    [
        InputError("no", file="f", key="k", value=[1], remedy="r", row=7),
        SimulationError("stopped", t=1.5, state=[1.0], reason="not finite"),
        MissingExtra("h5py", "hdf5"),
    ],
)
def test_errors_survive_pickling(error: FlexdynError) -> None:
    """A worker can send them home whole."""
    again = repickled(error)
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert again.data == error.data


def test_kinds_are_what_python_programs_expect() -> None:
    """Bad input is a ValueError, a failed run a RuntimeError, a missing library an ImportError."""
    assert issubclass(InputError, ValueError)
    assert issubclass(SimulationError, RuntimeError)
    assert issubclass(MissingExtra, ImportError)
    assert "pip install 'flexdyn[hdf5]'" in str(MissingExtra("h5py", "hdf5"))


def test_at_fills_in_the_place_from_outside_in() -> None:
    """A caller that knows the key above or the file adds it; what is there already stays."""
    inner = InputError("no", key="stiffness", value=3)
    outer = inner.at(key="joints.elbow").at(file="arm.yaml", key=None).at(file="other.yaml")
    assert str(outer) == "arm.yaml: joints.elbow.stiffness: no, got 3"
    assert str(inner) == "stiffness: no, got 3"


def _deep(depth: int) -> Any:
    value: Any = "x" * 1000
    for _ in range(depth):
        value = [value] * 9
    return value


FLOODS: dict[str, Any] = {
    "nested": _deep(30),
    "text": "y" * 10**6,
    "number": 10**5000,
    "mapping": {str(k): k for k in range(10**5)},
    "escape": "a\nb\x1b[2J",
}


@pytest.mark.parametrize("kind", FLOODS)
def test_no_value_floods_the_line(kind: str) -> None:
    """Whatever was given, the line stays one line of bounded length that no terminal obeys."""
    line = str(InputError("no", value=FLOODS[kind]))
    assert len(line) < 300
    assert line.isprintable()
    assert len(shown(FLOODS[kind])) < 300


@pytest.mark.parametrize("key", ["y" * 10**6, "a\nb\x1b[2J", "\u202ereversed"])
def test_no_key_or_file_floods_the_line(key: str) -> None:
    """Nor does what stands where a name should."""
    line = str(InputError("no", key=key, file=key))
    assert len(line) < 600
    assert line.isprintable()


def test_a_message_of_a_library_below_becomes_one_line() -> None:
    """Line breaks in a problem are spaces in the error."""
    assert str(SimulationError("first\n   second")) == "first second"


def test_near_misses() -> None:
    """The near miss where there is one, else what is known, never without bound."""
    assert did_you_mean("stifness", ["stiffness", "damping"]) == "did you mean 'stiffness'?"
    assert did_you_mean("zzz", ["a", "b"]) == "known: a, b"
    assert did_you_mean("zzz", map(str, range(1000))).endswith("38, 39, ...")
