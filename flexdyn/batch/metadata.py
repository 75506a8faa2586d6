"""The metadata of a store, byte for byte as zarr writes them in version 3 of its format.

zarr itself makes the arrays one by one, each with an event loop and several accesses to the file system. This takes
longer than a hundred short runs.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from flexdyn.batch.layout import StoreArray
from flexdyn.batch.pieces import LEVEL

FILE = "zarr.json"
"""The file's name, in the folder of the store and of every array."""
_SERIALIZERS: dict[str, dict[str, Any]] = {
    "string": {"name": "vlen-utf8", "configuration": {}},
    "float64": {"name": "bytes", "configuration": {"endian": "little"}},
    "int64": {"name": "bytes", "configuration": {"endian": "little"}},
}


def array_metadata(each: StoreArray) -> dict[str, Any]:
    """The metadata of one array.

    Args:
        each: the array.
    """
    return {
        "shape": list(each.shape),
        "data_type": each.dtype,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(each.piece)}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": "NaN" if each.dtype == "float64" else each.fill,
        "codecs": [
            _SERIALIZERS[each.dtype],
            {"name": "zstd", "configuration": {"level": LEVEL, "checksum": False}},
            {"name": "crc32c"},
        ],
        "attributes": dict(each.attrs),
        "dimension_names": list(each.dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }


def group_metadata(attrs: Mapping[str, Any], arrays: Sequence[StoreArray]) -> dict[str, Any]:
    """The metadata of the whole store, with those of all its arrays, so that a reader needs one file.

    Args:
        attrs: of the store.
        arrays: in it.
    """
    found = {each.name: array_metadata(each) for each in sorted(arrays, key=lambda each: each.name)}
    return {
        "attributes": dict(attrs),
        "zarr_format": 3,
        "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": found},
        "node_type": "group",
    }


def encoded(content: Mapping[str, Any]) -> bytes:
    """The bytes of the file.

    Args:
        content: metadata.
    """
    return json.dumps(content, indent=2).encode()
