"""What a recording promises: checked, locked, comparable, and clear about what is wrong."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording
from flexdyn.records.units import unit_of

T = np.array([0.0, 0.1, 0.25, 0.4])
ONES = np.ones(4)


def small(**channels: Any) -> Recording:
    """A recording of two joints; keywords add or replace channels, with ``__`` for the dot."""
    columns = {"q.elbow": ONES, "q.wrist": 2 * ONES, "tau.elbow": 3 * ONES, "energy.kinetic": 4 * ONES}
    return Recording(T, {**columns, **{name.replace("__", "."): value for name, value in channels.items()}}, name="log")


def test_names_and_extent() -> None:
    """Joints and signals come from the contract's channels in order; other channels are carried but are no joints."""
    rec = small()
    assert rec.joints == ("elbow", "wrist")
    assert rec.signals == ("q", "tau")
    assert list(rec.channels) == ["q.elbow", "q.wrist", "tau.elbow", "energy.kinetic"]
    assert (len(rec), rec.duration) == (4, 0.4)
    assert rec.rate == pytest.approx(7.5)
    assert rec.has("q", "wrist")
    assert not rec.has("tau", "wrist")
    assert "energy.kinetic" in rec
    for word in ("elbow", "wrist", "q, tau", "4 samples", "0.4 s", "7.5 Hz"):
        assert word in repr(rec)


def test_a_joint_name_may_hold_dots() -> None:
    """The signal ends at the first dot."""
    assert Recording(T, {"q.arm.left": ONES}).joints == ("arm.left",)


def test_signal_stacks_joints_in_the_order_asked() -> None:
    """Columns follow the joints asked for, not the file; a missing one is named."""
    rec = small()
    np.testing.assert_array_equal(rec.signal("q", ["wrist", "elbow"]), np.column_stack([2 * ONES, ONES]))
    assert rec.signal("q", []).shape == (4, 0)
    with pytest.raises(InputError, match=r"^tau\.wrist: no such channel") as caught:
        rec.signal("tau", ["elbow", "wrist"])
    assert caught.value.channel == "tau.wrist"


def test_an_unknown_channel_names_the_near_miss() -> None:
    """A typing error is answered with what was probably meant."""
    with pytest.raises(InputError, match=r"did you mean 'q\.elbow'"):
        small()["q.elbw"]


def test_arrays_are_copied_and_locked() -> None:
    """Neither the caller's array nor the recording's can change the recording afterwards."""
    mine = np.zeros(4)
    rec = Recording(T, {"q.a": mine}, meta={"who": {"name": ["x"]}})
    mine[0] = 9.0
    assert rec["q.a"][0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        rec["q.a"][0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        rec.t[0] = 1.0
    with pytest.raises(TypeError):
        rec.channels["q.b"] = mine  # type: ignore[index]
    with pytest.raises(TypeError):
        rec.meta["who"]["name"] = "y"
    with pytest.raises(AttributeError):
        rec.name = "other"  # type: ignore[misc]


def test_integers_lists_and_big_endian_become_doubles() -> None:
    """Whatever real numbers come in, doubles of this machine come out."""
    rec = Recording([0, 1], {"q.a": [True, False], "q.b": np.array([1, 2], ">i4"), "q.c": np.array([1, 2], ">f8")})
    assert all(values.dtype == np.dtype(np.float64) and values.dtype.isnative for values in rec.channels.values())
    np.testing.assert_array_equal(rec["q.c"], [1.0, 2.0])


def test_equality_is_bit_for_bit() -> None:
    """Minus zero is not zero, order and meta count, the name does not."""
    zero, minus = Recording(T, {"q.a": 0 * ONES}), Recording(T, {"q.a": -0.0 * ONES})
    assert zero != minus
    assert zero == Recording(T, {"q.a": 0 * ONES}, name="other")
    assert hash(zero) == hash(Recording(T, {"q.a": 0 * ONES}, name="other"))
    assert zero != Recording(T, {"q.a": 0 * ONES}, meta={"a": 1})
    assert zero.same_as(Recording(T, {"q.a": 0 * ONES}, meta={"a": 1}))
    assert Recording(T, {"q.a": T, "q.b": T}) != Recording(T, {"q.b": T, "q.a": T})
    assert zero != Recording(2 * T, {"q.a": 0 * ONES})
    assert zero != "log"


@pytest.mark.parametrize("move", [copy.copy, copy.deepcopy, lambda rec: pickle.loads(pickle.dumps(rec))])  # noqa: S301
def test_copies_and_pickles_are_equal_and_locked(move: Any) -> None:
    """A recording can be sent to a worker and stays what it was."""
    rec = Recording(T, {"q.a": ONES}, meta={"a": [1, {"b": None}]}, name="log")
    other = move(rec)
    assert other == rec
    assert other.name == "log"
    assert not other["q.a"].flags.writeable
    assert not other.t.flags.writeable


@pytest.mark.parametrize(
    ("t", "row", "words"),
    [
        ([0.0, 0.2, 0.1, 0.3], 2, "time runs backwards"),
        ([0.0, 0.1, 0.1, 0.3], 2, "two samples at one time"),
        ([0.0, -0.0, 0.1, 0.3], 1, "two samples at one time"),
        ([0.0, 0.1, np.nan, 0.3], 2, "not a finite number"),
        ([0.0, 0.1, 0.2, np.inf], 3, "not a finite number"),
    ],
)
def test_time_must_increase(t: list[float], row: int, words: str) -> None:
    """The first row at which time fails is named."""
    with pytest.raises(InputError, match=rf"^t: row {row}: {words}") as caught:
        Recording(t, {"q.a": ONES})
    assert (caught.value.row, caught.value.channel) == (row, "t")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite_names_row_and_channel(bad: float) -> None:
    """No NaN gets in silently."""
    with pytest.raises(InputError, match=r"^q\.wrist: row 2: not a finite number, got") as caught:
        small(q__wrist=[0.0, 1.0, bad, bad])
    assert (caught.value.row, caught.value.channel) == (2, "q.wrist")


def test_masked_samples_are_gaps() -> None:
    """A masked array's hidden values are not used."""
    with pytest.raises(InputError, match="row 1"):
        small(q__wrist=np.ma.MaskedArray([0, 1, 2, 3], mask=[False, True, False, False]))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.ones(3), "3 samples where t has 4"),
        (np.ones((4, 1)), r"shape \(4, 1\)"),
        (1.0, r"shape \(\)"),
        (["a", "b", "c", "d"], "not doubles"),
        ([[1], [1, 2], [3], [4]], "objects"),
        (np.array([1, 2, 3, None]), "objects"),
        (np.ones(4, complex), "complex"),
        (np.ones(4, np.longdouble), "not doubles"),
        (np.full(4, 2**53 + 1), r"2\^53"),
        (np.full(4, -(2**63)), r"2\^53"),
    ],
)
def test_columns_must_be_doubles(values: Any, words: str) -> None:
    """One real number per sample, each exactly a double."""
    with pytest.raises(InputError, match=words) as caught:
        small(q__wrist=values)
    assert caught.value.channel == "q.wrist"


@pytest.mark.parametrize(
    "name", ["", " q.a", "q.a ", "q,a", "q.a\n", "q\x00a", "t", "__meta__", "q.", "q.\udc80", "q" * 256]
)
def test_names_that_no_format_could_carry_are_refused(name: str) -> None:
    """A recording that exists can be written in every format."""
    with pytest.raises(InputError):
        Recording(T, {"q.ok": ONES, name: ONES})


def test_too_little_data_is_refused() -> None:
    """Two samples and one channel are the least."""
    with pytest.raises(InputError, match="1 samples are too few"):
        Recording([0.0], {"q.a": [0.0]})
    with pytest.raises(InputError, match="no channel beside t"):
        Recording(T, {})
    with pytest.raises(InputError, match="not a mapping"):
        Recording(T, [ONES])  # type: ignore[arg-type]


def test_meta_is_json() -> None:
    """Arrays and tuples come back as JSON has them; what JSON lacks is refused."""
    rec = Recording(T, {"q.a": ONES}, meta={"x": np.arange(2), "y": (1, np.float64(2.5)), "z": None})
    assert rec.meta == {"x": (0, 1), "y": (1, 2.5), "z": None}
    nested: dict[str, Any] = {}
    for _ in range(100_000):
        nested = {"a": nested}
    for bad in ({"x": np.nan}, {"x": object()}, {("a", "b"): 1}, nested, {"x": "y" * (2**24 + 1)}, [1]):
        with pytest.raises(InputError, match=r"^meta: "):
            Recording(T, {"q.a": ONES}, meta=bad)  # type: ignore[arg-type]


def test_units() -> None:
    """Radians unless told otherwise; a unit that is not SI is refused, for no one could tell from the numbers."""
    assert [unit_of(name) for name in ("t", "q.a", "omega.a", "tau_s.a", "temperature.a", "energy.kinetic")] == [
        "s",
        "rad",
        "rad/s",
        "N m",
        "degC",
        "",
    ]
    rec = Recording(T, {"q.a": ONES, "tau.a": ONES, "e": ONES}, meta={"units": {"q.a": "m", "tau.a": "Nm", "e": "J"}})
    assert [rec.unit(name) for name in ("t", "q.a", "tau.a", "e")] == ["s", "m", "N m", "J"]
    with pytest.raises(InputError, match=r"q\.a: the unit is not SI, got 'deg'; convert it to rad or m"):
        Recording(T, {"q.a": ONES}, meta={"units": {"q.a": "deg"}})
    with pytest.raises(InputError, match=r"did you mean 'q\.elbow'"):
        Recording(T, {"q.elbow": ONES}, meta={"units": {"q.elbw": "m"}})
    with pytest.raises(InputError, match="not a mapping"):
        Recording(T, {"q.a": ONES}, meta={"units": ["m"]})
