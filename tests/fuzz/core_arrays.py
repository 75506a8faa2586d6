"""The core's functions of arrays, called with arrays of shapes, kinds, layouts and sizes that they are not made for."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.errors import InputError

LENGTHS = (0, 1, 1, 2, 3, 5, 7, 8, 9, 15, 16, 17, 33)
KINDS = ("f8", ">f8", "f4", "f2", "i8", "i1", "u8", "c16", "bool", "O", "U3", "M8[s]", "g")
NUMBERS = (0.0, -0.0, 1e-300, 5e-324, 1.7e308, -1e15, np.nan, np.inf, -np.inf)
WHOLE = (0, 1, -1, 2**31, 2**62, 2**63, 2**64 - 1, 2**64, 10**400, 1.5, np.nan, None, "x", True)
EMPTY = ((2**59, 0), (0, 2**59), (2**59, 0, 0), (0, 1, 1, 2**40), (2**29, 2**29, 0, 0), (2**20, 2**20, 0, 2**12))
"""Shapes that take no memory, and whose lengths overflow when they are multiplied."""
GUARD, MARK = 64, 7.0
Arguments = dict[str, Any]


def run(rng: random.Random) -> None:
    """One call, of three two with one or two arguments spoilt.

    Raises:
        InputError: it was refused.
        AssertionError: numbers beside an output were written.
        TypeError, ValueError: fitting arrays were refused.
    """
    name = rng.choice(sorted(FITTING))
    arguments = FITTING[name](rng)
    outputs = [key for key in arguments if key in OUTPUTS]
    guarded = {key: _guarded(arguments[key]) for key in outputs}
    arguments |= {key: inner for key, (_, inner) in guarded.items()}
    spoilt = rng.sample(sorted(arguments), k=min(len(arguments), rng.choice((0, 1, 2))))
    for key in spoilt:
        arguments[key] = _spoilt(rng, arguments[key])
    try:
        getattr(_core, name)(**arguments)
    except (TypeError, ValueError, MemoryError) as error:
        if not spoilt:
            raise
        raise InputError(f"{name} refuses them") from error
    for whole, inner in guarded.values():
        assert (whole[:GUARD] == MARK).all(), f"{name} writes before its output"
        assert (whole[GUARD + inner.size :] == MARK).all(), f"{name} writes behind its output"


def _guarded(values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Memory with an output in its middle, and that output; what is written too far is seen."""
    whole = np.full(values.size + 2 * GUARD, MARK, values.dtype)
    inner = whole[GUARD : GUARD + values.size].reshape(values.shape)
    inner[...] = values
    return whole, inner


def _spoilt(rng: random.Random, value: Any) -> Any:
    """Something near a fitting argument, or far from it."""
    if not isinstance(value, np.ndarray):
        return rng.choice((*WHOLE, *NUMBERS))
    how = rng.choice((_of_other_shape, _of_other_shape, _of_other_kind, _laid_out, _laid_out, _of_other_size, _strange))
    with np.errstate(all="ignore"):
        return how(rng, value)


def _of_other_shape(rng: random.Random, value: np.ndarray[Any, Any]) -> Any:
    """A row more or less, axes exchanged, joined or added, or nothing with lengths that overflow."""
    if rng.random() < 0.2:
        return np.zeros(rng.choice(EMPTY), value.dtype)
    if rng.random() < 0.5:
        shape = [max(0, length + rng.choice((0, 0, -1, 1))) for length in value.shape]
        return np.ones(shape, value.dtype)
    return rng.choice((value.T, value.ravel(), value[None], np.ascontiguousarray(value.T), value[..., None]))


def _of_other_kind(rng: random.Random, value: np.ndarray[Any, Any]) -> Any:
    return value.astype(rng.choice(KINDS))


def _laid_out(rng: random.Random, value: np.ndarray[Any, Any]) -> Any:
    """The same numbers backwards, with gaps, by columns, not aligned, not to be written, or one for all."""
    gaps = np.repeat(value, 2, axis=0)[::2]
    raw = bytearray(value.nbytes + 1)
    shifted: np.ndarray[Any, Any] = np.ndarray(value.shape, value.dtype, raw, offset=1)
    shifted[...] = value
    fixed = value.copy()
    fixed.flags.writeable = False
    first = value.ravel()[:1] if value.size else np.zeros(1, value.dtype)
    same = np.lib.stride_tricks.as_strided(first, value.shape, (0,) * value.ndim)
    return rng.choice((value[::-1], value[..., ::-1], gaps, np.asfortranarray(value), shifted, fixed, same))


def _of_other_size(rng: random.Random, value: np.ndarray[Any, Any]) -> Any:
    """Numbers that are huge, tiny, or none; as flags, bytes that are neither 0 nor 1."""
    if value.dtype == bool:
        return np.full(value.shape, 0xA5, np.uint8).view(bool)
    changed = value.copy()
    if changed.size:
        number = rng.choice(NUMBERS)
        changed.flat[rng.randrange(changed.size)] = (
            number if changed.dtype.kind == "f" else rng.choice((-1, 2**62, -(2**62)))
        )
    return changed * changed.dtype.type(10.0 ** rng.uniform(-300, 300)) if changed.dtype == float else changed


def _strange(rng: random.Random, value: np.ndarray[Any, Any]) -> Any:
    return rng.choice((None, 1.0, "x", [], [[]], value.tolist(), object(), memoryview(b""), {}, np.float64(1.0)))


def _numbers(rng: random.Random, *shape: int) -> np.ndarray[Any, Any]:
    return np.random.default_rng(rng.randrange(2**32)).standard_normal(shape)


def _lengths(rng: random.Random, count: int) -> list[int]:
    return [rng.choice(LENGTHS) for _ in range(count)]


def _filter_rows(rng: random.Random) -> Arguments:
    rows, columns, more = _lengths(rng, 3)
    taps, every = rng.choice(LENGTHS[1:]), rng.choice((1, 2, 5))
    samples = max(0, rows - 1) * every + taps + more % 3
    x, out = _numbers(rng, samples, columns), np.zeros((rows, columns))
    return {"x": x, "taps": _numbers(rng, taps), "every": every, "out": out}


def _mixed_products(rng: random.Random) -> Arguments:
    columns, others, rows, kept = _lengths(rng, 4)
    which = np.array([rng.randrange(kept) for _ in range(columns)] if kept else [], np.int64)
    one = _numbers(rng, kept, rows).astype(np.float32)
    return {"one": one, "which": which, "other": _numbers(rng, others, rows), "out": np.zeros((len(which), others))}


def _noise_band(rng: random.Random) -> Arguments:
    times, terms, many = _lengths(rng, 3)
    lags = rng.randint(1, 4)
    band = np.zeros((times * many, lags * many + rng.randint(0, 2)))
    return {"terms": _numbers(rng, times, terms, many), "weights": _numbers(rng, lags, terms, terms), "band": band}


def _by_rows(rng: random.Random) -> Arguments:
    rows, width = _lengths(rng, 2)
    return {"band": _numbers(rng, rows, width), "factor": np.zeros((rows, width))}


def _whiten(rng: random.Random) -> Arguments:
    rows, columns = _lengths(rng, 2)
    width = rng.randint(1, rows) if rows else 0
    masked = np.array([rng.random() < 0.2 for _ in range(rows)], bool)
    factor, raw = _numbers(rng, rows, width), _numbers(rng, columns, rows)
    return {"factor": factor, "masked": masked, "raw": raw, "out": np.zeros((columns, rows))}


def _whiten_apart(rng: random.Random) -> Arguments:
    many, fitting = rng.randint(1, 4), _whiten(rng)
    columns, rows = fitting["raw"].shape
    many = many if rows % many == 0 else 1
    return fitting | {"out": np.zeros((many, columns, rows // many), np.float32)}


def _window_gains(rng: random.Random) -> Arguments:
    windows, blocks, channels, nx = (min(length, 7) for length in _lengths(rng, 4))
    square, gain = (windows, blocks, nx, nx), (windows, blocks, nx, channels)
    root, row = _numbers(rng, *square), (windows, blocks, channels)
    whitener = (windows, blocks, channels, channels)
    given: Arguments = {"flow": _numbers(rng, *square), "push": root @ np.swapaxes(root, 2, 3)}
    given |= {"seen": _numbers(rng, windows, blocks, channels, nx), "counted": np.ones(row), "sensor": np.ones(row)}
    given |= {"prior": np.broadcast_to(np.eye(nx), (windows, nx, nx)).copy(), "limit": 1e9}
    made = {"gain": gain, "first_gain": gain, "whitener": whitener, "carried": row, "doubt": row}
    return given | {key: np.zeros(shape) for key, shape in made.items()}


def _window_innovations(rng: random.Random) -> Arguments:
    known = _window_gains(rng)
    keys = ("flow", "seen", "counted", "limit", "gain", "first_gain", "whitener")
    row = known["counted"].shape
    given = {key: known[key] for key in keys} | {"mean": _numbers(rng, *row)}
    return given | {"first": np.zeros(known["prior"].shape[:2]), "white": np.zeros(row)}


OUTPUTS = ("out", "factor", "gain", "first_gain", "whitener", "carried", "doubt", "first", "white")
FITTING: dict[str, Callable[[random.Random], Arguments]] = {
    "filter_rows": _filter_rows,
    "mixed_products": _mixed_products,
    "noise_band": _noise_band,
    "by_rows": _by_rows,
    "whiten": _whiten,
    "whiten_apart": _whiten_apart,
    "window_gains": _window_gains,
    "window_innovations": _window_innovations,
}
