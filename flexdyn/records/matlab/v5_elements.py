"""The elements that a MAT-file of version 5 is made of: a tag with type and length, then so many bytes."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from flexdyn.errors import InputError

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
"""Encoding by the type of an element of text."""


class Cursor:
    """Goes from element to element; no element may extend beyond the existing bytes."""

    def __init__(self, data: bytes, order: str, at: int = 0, end: int | None = None) -> None:
        self.data, self.order, self.at = data, order, at
        self.end = len(data) if end is None else end

    def tag(self) -> tuple[int, int, int]:
        """Type of the present element, and begin and end of its bytes; these may be beyond the end of the data."""
        if self.at + 8 > self.end:
            raise cut()
        first, second = struct.unpack_from(f"{self.order}II", self.data, self.at)
        if first >> 16:
            return first & 0xFFFF, self.at + 4, self.at + 4 + min(first >> 16, 4)
        return first, self.at + 8, self.at + 8 + second

    def element(self) -> tuple[int, int, int]:
        """The same, then move to the next element."""
        kind, start, stop = self.tag()
        if stop > self.end:
            raise cut()
        self.at += 8 if start - self.at == 4 else 8 + (stop - start + 7) // 8 * 8
        return kind, start, stop

    def numbers(self) -> npt.NDArray[Any]:
        """An element of numbers, not copied."""
        kind, start, stop = self.element()
        if kind not in _TYPES:
            raise InputError(f"data of the unknown type {kind}", remedy="the file is damaged")
        dtype = np.dtype(self.order + _TYPES[kind])
        if (stop - start) % dtype.itemsize:
            raise cut()
        return np.frombuffer(self.data, dtype, (stop - start) // dtype.itemsize, start)

    def text(self) -> str:
        """An element of text."""
        kind, start, stop = self.element()
        code = TEXTS.get(kind, "latin-1")
        if code in ("utf-16", "utf-32"):
            code += "-le" if self.order == "<" else "-be"
        return self.data[start:stop].decode(code, "replace")


def cut() -> InputError:
    """The error for missing bytes."""
    return InputError("the file is truncated or damaged", remedy="copy the file again")
