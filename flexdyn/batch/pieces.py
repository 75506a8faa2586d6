"""The pieces of a store's arrays, written by the thread that has them, as the Zarr format has it.

zarr would hand each to an event loop that all threads share, which takes longer than the piece itself.
"""

from __future__ import annotations

import secrets
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

LEVEL = 1
"""Of the compression."""


def write_piece(folder: Path, chunk: int, shape: tuple[int, ...], values: Any, fill: Any) -> None:
    """Write one piece of an array, whole or not at all.

    Args:
        folder: of the array.
        chunk: number of the piece along the first axis; it is all of the others.
        shape: of every piece.
        values: of this one: floats or text; where it is the last it may be shorter.
        fill: what the rest of it holds.

    Raises:
        OSError: the disk refuses it.
    """
    whole = values
    if len(values) < shape[0]:
        whole = np.full(shape, fill, dtype=values.dtype)
        whole[: len(values)] = values
    place = folder / ".".join(["c", str(chunk), *["0"] * (len(shape) - 1)])
    fresh = place.with_name(f"{place.name}.{secrets.token_hex(16)}.partial")
    try:
        fresh.write_bytes(_encoded(whole))
        fresh.replace(place)
    except BaseException:
        with suppress(OSError):
            fresh.unlink()
        raise


def _encoded(values: Any) -> bytes:
    """Floats, or texts with their lengths, compressed by zstd, then a CRC-32C: the codecs that the arrays name."""
    from google_crc32c import value as checksum
    from numcodecs.vlen import VLenUTF8
    from numcodecs.zstd import Zstd

    plain = VLenUTF8().encode(values) if values.dtype == object else np.ascontiguousarray(values, dtype="<f8")
    packed = bytes(Zstd(level=LEVEL).encode(plain))
    return packed + int(checksum(packed)).to_bytes(4, "little")
