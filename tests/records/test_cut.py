"""Trimming, splitting, shifting: samples are chosen, never changed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError
from flexdyn.records import Recording

T = np.arange(101) / 10.0
REC = Recording(T, {"q.a": np.sin(T), "tau.a": np.cos(T)}, meta={"units": {"q.a": "m"}, "who": "x"}, name="log")


def test_trim_keeps_both_ends() -> None:
    """Samples from start to end, bit for bit, with meta and name."""
    part = REC.trim(1.0, 2.0)
    np.testing.assert_array_equal(part.t, T[10:21])
    np.testing.assert_array_equal(part["q.a"], REC["q.a"][10:21])
    assert part.meta == REC.meta
    assert part.name == "log"
    assert REC.trim() == REC
    assert len(REC.trim(end=0.95)) == 10
    assert len(REC.trim(9.85)) == 2


@pytest.mark.parametrize("bounds", [(3.0, 2.0), (20.0, None), (None, -1.0), (1.0, 1.05)])
def test_a_trim_that_leaves_nothing_is_refused(bounds: tuple[float | None, float | None]) -> None:
    """The line tells from when to when the recording runs."""
    with pytest.raises(InputError, match="the recording runs from 0 to 10 s"):
        REC.trim(*bounds)


@settings(max_examples=50, deadline=None)
@given(at=st.lists(st.floats(0.11, 9.8), min_size=1, max_size=5))
def test_pieces_make_the_whole(at: list[float]) -> None:
    """Nothing is lost or doubled: pieces put together are the recording."""
    if np.diff(np.searchsorted(T, sorted(at))).min(initial=2) < 2:
        with pytest.raises(InputError, match="too short"):
            REC.split(at=at)
        return
    pieces = REC.split(at=at)
    assert len(pieces) == len(at) + 1
    np.testing.assert_array_equal(np.concatenate([piece.t for piece in pieces]), T)
    np.testing.assert_array_equal(np.concatenate([piece["tau.a"] for piece in pieces]), REC["tau.a"])
    for piece, time in zip(pieces[1:], sorted(at), strict=True):
        assert piece.t[0] >= time


def test_split_at_gaps() -> None:
    """Between samples longer apart than stated; a lone sample between two gaps is dropped."""
    t = np.array([0.0, 0.1, 0.2, 1.0, 1.1, 5.0, 9.0, 9.1])
    pieces = Recording(t, {"q.a": t}).split(gaps=0.5)
    assert [list(piece.t) for piece in pieces] == [[0.0, 0.1, 0.2], [1.0, 1.1], [9.0, 9.1]]
    assert REC.split(gaps=0.5) == (REC,)
    with pytest.raises(InputError, match="would have one sample"):
        REC.split(gaps=0.01)


def test_a_split_needs_one_way() -> None:
    """Neither, both, and nonsense are refused."""
    for given_ in ({}, {"at": [1.0], "gaps": 1.0}, {"gaps": 0.0}, {"gaps": np.nan}, {"at": [np.nan]}, {"at": [0.0]}):
        with pytest.raises(InputError, match=r"^(at|gaps): "):
            REC.split(**given_)


def test_a_clock_is_shifted() -> None:
    """Every time moves, no sample changes; and back again."""
    later = REC.shifted(0.5)
    np.testing.assert_array_equal(later.t, T + 0.5)
    np.testing.assert_array_equal(later["q.a"], REC["q.a"])
    np.testing.assert_allclose(later.shifted(-0.5).t, T, atol=1e-14)


def test_single_channels_are_shifted_against_the_rest() -> None:
    """What was measured at t stands at t + shift: a sine by interpolation, a held torque by its steps."""
    moved = REC.shifted({"q.a": 0.25, "tau.a": -0.3})
    np.testing.assert_array_equal(moved.t, T[3:98])
    np.testing.assert_allclose(moved["q.a"], np.sin(moved.t - 0.25), atol=3e-6)
    np.testing.assert_array_equal(moved["tau.a"], REC["tau.a"][6:101])
    assert REC.shifted({}) == REC
    with pytest.raises(InputError, match=r"seconds\.q\.b: no such channel; did you mean 'q\.a'"):
        REC.shifted({"q.b": 0.1})
    with pytest.raises(InputError, match=r"seconds: not a time"):
        REC.shifted(np.inf)
    with pytest.raises(InputError, match="samples lie"):
        REC.shifted({"q.a": 100.0})
