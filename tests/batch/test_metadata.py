"""The metadata of a store are those that zarr itself would write."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from zarr.codecs import Crc32cCodec, ZstdCodec

import flexdyn as fd
from flexdyn.batch.store import create
from flexdyn.batch.studyfile import read_study
from tests.batch.studies import write_study

TYPES = {"string": "str", "float64": "float64", "int64": "int64"}
FILL: dict[str, Any] = {"string": "not done", "float64": np.nan, "int64": 0}


def made_by_zarr(like: Path, folder: Path) -> None:
    """Make an empty store with the arrays of another one, by zarr alone."""
    theirs = zarr.open_group(like, mode="r", use_consolidated=False)
    group = zarr.open_group(folder, mode="w-", zarr_format=3, attributes=dict(theirs.attrs))
    for name, array in theirs.arrays():
        kind = array.metadata.to_dict()["data_type"]
        group.create_array(
            name,
            shape=array.shape,
            chunks=array.chunks,
            dtype=TYPES[kind],
            fill_value=FILL[kind],
            dimension_names=array.metadata.dimension_names,
            attributes=dict(array.attrs),
            compressors=[ZstdCodec(level=1), Crc32cCodec()],
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(group.store)


def test_zarr_writes_the_same_metadata(tmp_path: Path) -> None:
    """A group of the same arrays made by zarr: every metadata file says the same, in the same order."""
    create(read_study(write_study(tmp_path, metrics=["tip_deflection_max"])), tmp_path / "ours.zarr")
    made_by_zarr(tmp_path / "ours.zarr", tmp_path / "theirs.zarr")
    files = sorted(file.relative_to(tmp_path / "theirs.zarr") for file in (tmp_path / "theirs.zarr").rglob("zarr.json"))
    assert len(files) == 1 + 3 + 2 + 3 + 1 + 1  # group, coordinates, channels, parameters, metric, status
    for file in files:
        ours, theirs = (json.loads((tmp_path / store / file).read_text()) for store in ("ours.zarr", "theirs.zarr"))
        assert ours == theirs
        assert list(ours) == list(theirs)


def test_shapes_and_what_is_not_done(tmp_path: Path) -> None:
    """What zarr reads of a store without runs: sizes in runs, samples and joints, NaN and ``not done``."""
    create(read_study(write_study(tmp_path)), tmp_path / "out.zarr")
    group = zarr.open_group(tmp_path / "out.zarr", mode="r")
    assert group["q"].shape == (12, 21, 2)
    assert group["q"].chunks == (4, 21, 2)
    assert np.isnan(group["q"][:]).all()
    assert group["status"][:].tolist() == ["not done"] * 12
    assert group["run"][:].tolist() == list(range(12))
    assert group["joint"][:].tolist() == ["shoulder", "elbow"]
    np.testing.assert_array_equal(group["time"][:], np.arange(21) / 100)
    assert group.attrs["flexdyn"] == fd.__version__
