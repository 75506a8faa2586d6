"""The Zarr chunks of a store's arrays ("pieces"), written by the thread that has the data.

zarr would pass each to an event loop that all threads share, which takes longer than writing the piece.
"""

from __future__ import annotations

import os
import secrets
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

LEVEL = 1
"""Level of the compression."""
CHECKSUM = 4
"""Bytes of the checksum."""


def write_piece(folder: Path, chunk: int, shape: tuple[int, ...], values: Any, fill: Any) -> None:
    """Write one piece of an array, completely or not at all.

    Args:
        folder: of the array.
        chunk: number of the piece along the first axis; it covers the other axes completely.
        shape: of every piece.
        values: of this piece: numbers or text; the last piece may be shorter.
        fill: value of the rest of a shorter piece.

    Raises:
        OSError: it cannot be written.
    """
    whole = values
    if len(values) < shape[0]:
        whole = np.full(shape, fill, dtype=values.dtype)
        whole[: len(values)] = values
    place, content = _place(folder, chunk, len(shape)), _encoded(whole)
    fresh = f"{place}.{secrets.token_hex(16)}.partial"
    try:
        _write(fresh, content)
        os.rename(fresh, place)
    except BaseException:
        with suppress(OSError):
            os.unlink(fresh)
        raise


def is_whole(folder: Path, chunk: int, axes: int) -> bool:
    """Whether a piece exists and its checksum is correct.

    Args:
        folder: of the array.
        chunk: number of the piece along the first axis.
        axes: of the array.
    """
    try:
        content = Path(_place(folder, chunk, axes)).read_bytes()
    except OSError:
        return False
    return len(content) > CHECKSUM and content[-CHECKSUM:] == _checksum(content[:-CHECKSUM])


def _place(folder: Path, chunk: int, axes: int) -> str:
    return f"{folder}/c.{chunk}{'.0' * (axes - 1)}"


def _write(path: str, content: bytes) -> None:
    """Write a new file with as few calls as possible: at each call other threads wait for the interpreter's lock."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        left = memoryview(content)
        while left:
            left = left[os.write(handle, left) :]
    finally:
        os.close(handle)


def _encoded(values: Any) -> bytes:
    """Numbers, or texts with their lengths, compressed by zstd, then a CRC-32C: the codecs that the arrays name."""
    from numcodecs.vlen import VLenUTF8
    from numcodecs.zstd import Zstd

    little = values.dtype.newbyteorder("<")
    plain = VLenUTF8().encode(values) if values.dtype == object else np.ascontiguousarray(values, dtype=little)
    packed = bytes(Zstd(level=LEVEL).encode(plain))
    return packed + _checksum(packed)


def _checksum(content: bytes) -> bytes:
    from google_crc32c import value

    return int(value(content)).to_bytes(CHECKSUM, "little")
