"""Pieces of a store are those that zarr itself writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr

import flexdyn as fd
from flexdyn.batch.pieces import write_piece
from tests.batch.studies import pieces, tree, write_study


def test_zarr_writes_the_same_bytes(tmp_path: Path) -> None:
    """Every array of a finished study, read and written again by zarr: the store does not change by a byte."""
    out = tmp_path / "out.zarr"
    fd.run_study(write_study(tmp_path, runs=10), out)
    before = tree(out)
    group = zarr.open_group(out, mode="r+")
    for _, array in group.arrays():
        array.with_config({"write_empty_chunks": True})[:] = array[:]
    assert tree(out) == before
    assert len(pieces(out)) == 7 * 3


@pytest.mark.parametrize(
    "values", [np.linspace(0.0, 1.0, 12).reshape(4, 3), np.array(["ok", "", "µ" * 300, "no"], dtype=object)]
)
def test_a_short_piece_is_filled(tmp_path: Path, values: Any) -> None:
    """The last piece may hold fewer runs: zarr reads them back, and the filling after them."""
    shape = (7, *values.shape[1:])
    kind = "str" if values.dtype == object else "float64"
    codecs = [zarr.codecs.ZstdCodec(level=1), zarr.codecs.Crc32cCodec()]
    names: Any = {"name": "default", "separator": "."}
    fill: Any = "none" if kind == "str" else -1.0
    array = zarr.create_array(
        tmp_path, shape=shape, chunks=shape, dtype=kind, fill_value=fill, compressors=codecs, chunk_key_encoding=names
    )
    write_piece(tmp_path, 0, shape, values, fill)
    assert array[:4].tolist() == values.tolist()
    assert set(np.ravel(array[4:]).tolist()) == {fill}


def test_what_is_half_written_does_not_stay(tmp_path: Path) -> None:
    """Values that no piece can hold: nothing lies in the folder afterwards."""
    with pytest.raises(TypeError):
        write_piece(tmp_path, 0, (2,), np.array([1, None], dtype=object), "none")
    with pytest.raises(OSError, match="No such file"):
        write_piece(tmp_path / "nowhere", 0, (2,), np.zeros(2), 0.0)
    assert not list(tmp_path.iterdir())
