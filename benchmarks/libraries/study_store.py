"""The store of a study: zarr's own writer against pieces and metadata written by hand.

The arrays are those of a study of 128 runs a chunk: positions of two joints, ten numbers of a run, and its status.
"""

from __future__ import annotations

import shutil
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from comparison import Case, Comparison, times_of

from flexdyn.batch.layout import StoreArray
from flexdyn.batch.pieces import LEVEL, write_piece
from flexdyn.batch.store import make_arrays

RUNS, CHUNKS, SAMPLES, JOINTS = 128, 16, 41, 2
STATUS = "status"
Columns = dict[str, Any]


def compare(data: Path) -> Comparison:
    """Both make a store and fill it, chunk by chunk.

    Args:
        data: folder of the measured data, which holds no studies.
    """
    columns = _columns()
    with tempfile.TemporaryDirectory() as place:
        ours, library = Path(place) / "ours", Path(place) / "library"
        _made_by_hand(ours, columns)
        _made_by_zarr(library, columns)
        cases = [Case("read again by zarr", _same(ours, columns), _same(library, columns))]
        times = {
            f"{CHUNKS} chunks of {RUNS} runs": times_of(
                partial(_made_by_zarr, library, columns), partial(_made_by_hand, ours, columns)
            )
        }
    return Comparison("the store of a study", "flexdyn.batch.pieces", "zarr, assignment to an Array", cases, times)


def _columns() -> Columns:
    """What one chunk of runs gives."""
    draw = np.random.default_rng(0)
    found: Columns = {"q": draw.standard_normal((RUNS, SAMPLES, JOINTS))}
    found |= {f"number_{k}": draw.standard_normal(RUNS) for k in range(10)}
    return found | {STATUS: np.full(RUNS, "ok", dtype=object)}


def _layout(name: str, values: Any) -> StoreArray:
    shape = (RUNS * CHUNKS, *values.shape[1:])
    kind = "string" if name == STATUS else "float64"
    return StoreArray(name, ("run", "time", "joint")[: values.ndim], shape, values.shape, kind, {})


def _made_by_hand(folder: Path, columns: Columns) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    made = [_layout(name, values) for name, values in columns.items()]
    make_arrays(folder, {}, made)
    for chunk in range(CHUNKS):
        for each in made:
            write_piece(folder / each.name, chunk, each.piece, columns[each.name], each.fill)


def _made_by_zarr(folder: Path, columns: Columns) -> None:
    """The same arrays with the same codecs, as zarr's documentation writes them."""
    group = zarr.open_group(folder, mode="w")
    arrays = {}
    for name, values in columns.items():
        each = _layout(name, values)
        arrays[name] = group.create_array(
            name,
            shape=each.shape,
            chunks=each.piece,
            dtype=each.dtype,
            compressors=[zarr.codecs.ZstdCodec(level=LEVEL), zarr.codecs.Crc32cCodec()],
            fill_value=each.fill,
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    for chunk in range(CHUNKS):
        for name, values in columns.items():
            arrays[name][chunk * RUNS : (chunk + 1) * RUNS] = values


def _same(folder: Path, columns: Columns) -> str:
    """Whether zarr reads what was written."""
    for name, values in columns.items():
        found = zarr.open_array(folder / name, mode="r")[:]
        if not np.array_equal(np.asarray(found), np.concatenate([values] * CHUNKS)):
            return f"{name} differs"
    return ""
