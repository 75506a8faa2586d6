"""Errors are one line, carry their data, survive a trip to another process, and cannot be flooded."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from flexdyn import FlexdynError, InputError, MissingExtra, SimulationError
from flexdyn.checks import check_known, number, whole
from flexdyn.errors import did_you_mean, placed, shown
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


def test_a_place_is_added_to_errors_that_lack_it() -> None:
    """File and key of the caller in front of the key of the fault; a file that is known already stays."""
    with (
        pytest.raises(InputError, match=r"^arm\.yaml: joints\.elbow\.stiffness: it must be above 0$"),
        placed(file="arm.yaml", key="joints.elbow"),
    ):
        raise InputError("it must be above 0", key="stiffness")
    with pytest.raises(InputError, match=r"^robot\.urdf: no link$"), placed(file="arm.yaml"):
        raise InputError("no link", file="robot.urdf")


def test_an_unknown_word_is_refused_with_the_nearest_one() -> None:
    """Words of any kind that YAML has; the channel is the key where no other is given."""
    check_known("q", ("q", "v"), "no such signal")
    with pytest.raises(InputError, match=r"^signal: no such signal, got 'thata'; did you mean 'theta'\?$"):
        check_known("thata", {"theta": 1}, "no such signal", key="signal", value="thata")
    with pytest.raises(InputError, match=r"^q\.elbow: no such channel; known: v\.elbo$"):
        check_known([1], ["v.elbo"], "no such channel", channel="q.elbow")


@pytest.mark.parametrize(
    ("value", "limits", "fits"),
    [
        (1.5, {}, True),
        (np.float32(2.0), {"least": 2.0}, True),
        (0.0, {"above": 0.0}, False),
        (-1.0, {"least": 0.0}, False),
        (math.inf, {}, False),
        (math.inf, {"infinite": True}, True),
        (-math.inf, {"infinite": True}, False),
        (math.nan, {"infinite": True}, False),
        (True, {}, False),
        ("1.5", {}, False),
    ],
)
def test_numbers_are_checked(value: object, limits: dict[str, Any], fits: bool) -> None:
    """Finite unless infinity is allowed, within its limits; truth values and text are no numbers."""
    if fits:
        assert number("x", value, **limits) == value
        return
    with pytest.raises(InputError, match=r"^x: a finite number is needed, got"):
        number("x", value, **limits)


@pytest.mark.parametrize("value", [True, 1.0, "2", 0, 8])
def test_whole_numbers_are_checked(value: object) -> None:
    """From 1 to 7: no truth value, no decimal number, no text, none outside."""
    assert whole("n", np.int32(7), 1, 7) == 7
    with pytest.raises(InputError, match=r"^n: a whole number of at least 1 is needed, got"):
        whole("n", value, 1, 7)
