"""The places of the numbers in the bytes of a message, from its definition.

rosbags deserialises one message at a time into Python objects. Messages of one topic usually differ only in their
numbers. So one message is analysed, and all messages with the same texts and lengths are then read with NumPy. Unlike
rosbags' own deserialiser, this one generates no code from definitions, which come from the file.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from rosbags.interfaces import Nodetype

from flexdyn.arrays import Flags, Indices
from flexdyn.errors import InputError

Path = tuple[str | int, ...]
Fields = Mapping[str, Sequence[tuple[str, Any]]]
Bytes = npt.NDArray[np.uint8]

_TYPES = {
    **{"bool": "?", "byte": "i1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8"},
}
_MOST_STEPS = 100_000
_MOST_DEPTH = 32


@dataclass(frozen=True)
class MessageNumber:
    """A number in a message: path of fields and indices, byte it begins at, NumPy type."""

    path: Path
    offset: int
    kind: str

    def of(self, block: Bytes) -> npt.NDArray[Any]:
        """This number in every message of a block (messages, bytes)."""
        size = np.dtype(self.kind).itemsize
        return np.ascontiguousarray(block[:, self.offset : self.offset + size]).view(self.kind)[:, 0]

    def put(self, block: Bytes, values: npt.NDArray[Any]) -> None:
        """Write this number into every message of a block."""
        size = np.dtype(self.kind).itemsize
        block[:, self.offset : self.offset + size] = values.astype(self.kind)[:, None].view(np.uint8)


@dataclass(frozen=True, eq=False)
class MessageLayout:
    """The content of a message and of similar ones: numbers in order, texts by path, and the equal bytes."""

    numbers: tuple[MessageNumber, ...]
    texts: Mapping[Path, str]
    fixed: Indices
    template: Bytes

    def matches(self, block: Bytes) -> Flags:
        """Whether each message of a block, all of the same length, has this layout."""
        return np.asarray((block[:, self.fixed] == self.template).all(axis=1))


def lay_out(raw: bytes, msgtype: str, fields: Fields, *, cdr: bool) -> MessageLayout:
    """The layout of one message.

    Args:
        raw: bytes of the message in the bag.
        msgtype: such as ``sensor_msgs/msg/JointState``.
        fields: fields by message type, as rosbags parses them.
        cdr: ROS 2's encoding (aligned, either byte order), not ROS 1's (packed).

    Raises:
        InputError: the bytes are not such a message.
    """
    walk = _Walk(raw, fields, cdr)
    walk.message(msgtype, (), 0)
    left = len(raw) - walk.at
    if left > (3 if cdr else 0):
        raise InputError(f"the message goes on for {left} bytes after its last field", value=msgtype)
    fixed = np.array(walk.fixed, np.intp)
    return MessageLayout(tuple(walk.numbers), walk.texts, fixed, np.frombuffer(raw, np.uint8)[fixed])


class _Walk:
    """One pass over the bytes of a message."""

    def __init__(self, raw: bytes, fields: Fields, cdr: bool) -> None:
        self.raw, self.fields, self.cdr = raw, fields, cdr
        self.at = self.origin = 4 if cdr else 0
        if cdr and raw[:2] not in (b"\0\0", b"\0\1"):
            raise InputError("the message is not in CDR, ROS 2's plain encoding", value=raw[:4].hex())
        self.order = ">" if cdr and raw[1] == 0 else "<"
        self.numbers: list[MessageNumber] = []
        self.texts: dict[Path, str] = {}
        self.fixed: list[int] = [0, 1] if cdr else []
        self.steps = 0

    def message(self, msgtype: str, path: Path, depth: int) -> None:
        """Process the fields of a message."""
        if msgtype not in self.fields or depth > _MOST_DEPTH:
            problem = "nests too deep" if msgtype in self.fields else "is not defined in the bag"
            raise InputError(f"the message type {problem}", value=msgtype)
        for name, description in self.fields[msgtype]:
            self._field(description, (*path, name), depth)

    def _field(self, description: Any, path: Path, depth: int) -> None:
        """Read a field: a nested message, a plain value, or an array of these."""
        node, what = description
        self.steps += 1
        if self.steps > _MOST_STEPS:
            raise InputError(f"the message has more than {_MOST_STEPS} fields", remedy="choose another topic")
        if node == Nodetype.NAME:
            self.message(what, path, depth + 1)
        elif node == Nodetype.BASE:
            self._base(what[0], path)
        else:
            (kind, element), count = what
            if node == Nodetype.SEQUENCE:
                count = self._count()
            if count > len(self.raw) - self.at:
                raise self._cut()
            if kind == Nodetype.BASE and element[0] != "string":
                self._numbers(element[0], path, count)
            else:
                for index in range(count):
                    self._field((kind, element), (*path, index), depth)

    def _base(self, kind: str, path: Path) -> None:
        """Read a text or a single number."""
        if kind == "string":
            self.texts[path] = self._text()
        else:
            self._numbers(kind, path, None)

    def _numbers(self, kind: str, path: Path, count: int | None) -> None:
        """One number (no count), or several; lists of bytes are no columns (pictures, blobs)."""
        if kind not in _TYPES:
            raise InputError("this type of field is not supported", key=".".join(map(str, path)), value=kind)
        size = np.dtype(_TYPES[kind]).itemsize
        code = _TYPES[kind] if size == 1 else self.order + _TYPES[kind]
        if count == 0:
            return
        self._align(size)
        begin = self._take(size * (1 if count is None else count))
        if count is None:
            self.numbers.append(MessageNumber(path, begin, code))
        elif size > 1:
            self.steps += count
            if self.steps > _MOST_STEPS:
                raise InputError(f"the message has more than {_MOST_STEPS} numbers", remedy="choose another topic")
            self.numbers += [MessageNumber((*path, index), begin + size * index, code) for index in range(count)]

    def _count(self) -> int:
        """Read the length of a sequence or text; messages of one layout have the same."""
        self._align(4)
        begin = self._take(4)
        self.fixed += range(begin, begin + 4)
        return int(struct.unpack_from(f"{self.order}I", self.raw, begin)[0])

    def _text(self) -> str:
        """Read a text; its letters belong to the layout."""
        count = self._count()
        begin = self._take(count)
        self.fixed += range(begin, begin + count)
        data = self.raw[begin : begin + count]
        try:
            return (data[:-1] if self.cdr else data).decode()
        except UnicodeDecodeError:
            raise InputError("a text of the message is not UTF-8", value=data[:40]) from None

    def _align(self, size: int) -> None:
        """Skip the padding of CDR before a value of this size."""
        if self.cdr:
            self.at += (self.origin - self.at) % size

    def _take(self, size: int) -> int:
        """The place of the next bytes, and go on behind them."""
        begin = self.at
        if begin + size > len(self.raw):
            raise self._cut()
        self.at = begin + size
        return begin

    def _cut(self) -> InputError:
        return InputError(f"the message of {len(self.raw)} bytes is cut or of another type")
