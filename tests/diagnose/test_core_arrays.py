"""What the core's functions of rows and windows refuse: arrays that they would read or write beyond the end of."""

from __future__ import annotations

import random
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from flexdyn import _core
from flexdyn.errors import InputError
from tests.fuzz import core_arrays

HUGE = 2**59
"""Rows without columns take no memory; 32 times this is 0 in 64 bits."""


def test_a_distance_of_rows_that_overflows_is_refused() -> None:
    """Three rows at every 2^63-th sample, of which there are three."""
    out = np.zeros((3, 1))
    for every in (2**62, 2**63, 2**64 - 1):
        with pytest.raises(ValueError, match="a sample for every tap"):
            _core.filter_rows(np.ones((3, 1)), np.ones(3), every, out)
    with pytest.raises(ValueError, match="not 0"):
        _core.filter_rows(np.ones((3, 1)), np.ones(3), 0, out)
    assert not out.any()


def test_numbers_of_products_that_overflow_are_refused() -> None:
    """32 times 2^59 products would be none in 64 bits."""
    which, out = np.zeros(32, np.int64), np.zeros((32, 0))
    with pytest.raises(ValueError, match="rows differ"):
        _core.mixed_products(np.zeros((1, 0), np.float32), which, np.zeros((HUGE, 0)), out)


@pytest.mark.parametrize("column", [-1, 3, 2**62, -(2**62)])
def test_columns_that_are_not_there_are_refused(column: int) -> None:
    """Before anything is multiplied."""
    out = np.zeros((2, 1))
    with pytest.raises(ValueError, match="no such column"):
        _core.mixed_products(np.ones((3, 4), np.float32), np.array([0, column]), np.ones((1, 4)), out)
    assert not out.any()


def test_rows_of_no_equation_are_refused() -> None:
    """Rows would be divided by zero."""
    with pytest.raises(ValueError, match="equations"):
        _core.whiten_apart(np.zeros((0, 1)), np.zeros(0, bool), np.zeros((20, 0)), np.zeros((0, 20, 0), np.float32))
    with pytest.raises(ValueError, match="equations"):
        _core.whiten_apart(np.ones((5, 1)), np.zeros(5, bool), np.ones((1, 5)), np.zeros((2, 1, 2), np.float32))


def test_a_band_wider_than_its_rows_is_refused() -> None:
    """And one without a diagonal, and a mask of other rows."""
    for factor, masked in ((np.ones((3, 4)), 3), (np.ones((3, 0)), 3), (np.ones((3, 2)), 2)):
        with pytest.raises(ValueError, match="rows"):
            _core.whiten(factor, np.zeros(masked, bool), np.ones((1, 3)), np.zeros((1, 3)))


def test_nothing_with_huge_lengths_is_done_at_once() -> None:
    """Arrays without memory, and loops of 2^59 steps that would do nothing."""
    empty = np.zeros((HUGE, 0))
    _core.whiten(np.zeros((0, 1)), np.zeros(0, bool), empty, empty)
    _core.by_rows(empty, empty)
    _core.noise_band(np.zeros((HUGE, 1, 0)), np.ones((1, 1, 1)), np.zeros((0, 0)))
    stack, table = np.zeros((2**29, 2**29, 0, 0)), np.zeros((2**29, 2**29, 0))
    first, prior = np.zeros((2**29, 0)), np.zeros((2**29, 0, 0))
    _core.window_gains(stack, stack, stack, table, table, prior, 1.0, stack, stack, stack, table, table)
    _core.window_innovations(stack, stack, table, 1.0, stack, stack, stack, table, first, table)


def test_windows_with_lengths_that_overflow_are_refused() -> None:
    """2^20 windows of 2^20 blocks with 2^12 states: the product of the lengths is 0 in 64 bits."""
    flow, seen = np.zeros((0, 1, 1, 2**12)), np.zeros((2**20, 2**20, 0, 2**12))
    table = np.zeros((2**20, 2**20, 0))
    tall, whitener = np.zeros((2**20, 2**20, 2**12, 0)), np.zeros((2**20, 2**20, 0, 0))
    with pytest.raises(ValueError, match="flow is"):
        _core.window_innovations(flow, seen, table, 1.0, tall, tall, whitener, table, np.zeros((0, 2**12)), table)


@pytest.mark.parametrize(
    "out",
    [
        np.zeros((3, 2), np.float32),
        np.zeros((3, 2), np.int64),
        np.zeros((3, 2), ">f8"),
        np.zeros((3, 2))[::-1],
        np.zeros((6, 2))[::2],
        np.asfortranarray(np.zeros((3, 2))),
        np.broadcast_to(0.0, (3, 2)),
        np.ndarray((3, 2), np.float64, bytearray(49), offset=1),
        np.zeros(6),
        [[0.0, 0.0]] * 3,
    ],
    ids=["f4", "i8", "swapped", "backwards", "gaps", "by columns", "read-only", "not aligned", "flat", "list"],
)
def test_an_output_is_never_converted(out: np.ndarray) -> None:
    """A converted copy would take the results, and the caller's array would stay as it was."""
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _core.filter_rows(np.ones((20, 2)), np.ones(3), 2, out)


def test_inputs_are_converted_whatever_their_layout() -> None:
    """By columns, backwards, with gaps, or not aligned."""
    x, wanted = np.random.default_rng(0).standard_normal((20, 2)), np.empty((3, 2))
    _core.filter_rows(x, np.ones(3), 2, wanted)
    shifted: np.ndarray = np.ndarray(x.shape, x.dtype, bytearray(x.nbytes + 1), offset=1)
    shifted[...] = x
    assert not shifted.flags.aligned
    for same in (np.asfortranarray(x), x[::-1].copy()[::-1], np.repeat(x, 2, axis=0)[::2], shifted):
        found = np.empty_like(wanted)
        _core.filter_rows(same, np.ones(3), 2, found)
        np.testing.assert_array_equal(found, wanted)


def test_a_job_that_is_none_is_refused() -> None:
    """One line in place of a crash."""
    with pytest.raises(ValueError, match="None"):
        _core.simulate_many([None], 1, None)  # type: ignore[list-item]


def test_whatever_arrays_are_given_nothing_is_written_beside_an_output() -> None:
    """Two thousand calls, most of them with one or two arguments spoilt; the long run is scripts/fuzz.py."""
    refused = 0
    for number in range(2000):
        try:
            core_arrays.run(random.Random(number))
        except InputError:
            refused += 1
    assert 400 < refused < 1600


def test_calls_in_several_threads_do_not_meet() -> None:
    """The core computes without the interpreter's lock."""

    def some(first: int) -> int:
        for number in range(first, first + 200):
            try:
                core_arrays.run(random.Random(number))
            except InputError:
                continue
        return first

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(some, range(0, 1600, 200))) == list(range(0, 1600, 200))
