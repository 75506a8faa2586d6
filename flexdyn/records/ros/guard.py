"""Check what rosbags does not: the unpacked size of a bag before it is unpacked, and whether a .db3 is complete.

Normal bags are far below these limits; a file of kilobytes that unpacks to gigabytes is refused here.
"""

from __future__ import annotations

import struct
import sys
from bz2 import BZ2Decompressor
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import lz4.frame  # type: ignore[import-untyped]
from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import decompressors

from flexdyn.errors import InputError
from flexdyn.records.bounds import MOST_EXPANSION

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MOST_MESSAGE = 16 * 2**20
"""Largest message that is read [bytes]."""

_LARGEST_CHUNK = 2**30
_MOST_OPEN = 2**31
_PIECE = 2**20
_UNPACK = {"zstd": zstd.ZstdDecompressor, "lz4": lz4.frame.LZ4FrameDecompressor, "bz2": BZ2Decompressor}
_DATABASE_HEADER = 100
"""Bytes; https://sqlite.org/fileformat2.html, section 1.3."""


def unpacked(data: bytes, compression: str, most: int) -> bytes:
    """Unpack all frames of compressed data, up to `most` bytes.

    Raises:
        InputError: there are more bytes.
    """
    whole = bytearray()
    while data:
        frame = _UNPACK[compression]()
        whole += frame.decompress(data, most + 1 - len(whole))
        if len(whole) > most:
            raise InputError(f"{compression} data unpack to more than {most} bytes", remedy="the file is damaged")
        if not frame.eof:
            raise InputError(f"{compression} data are cut", remedy="copy the file again")
        data = frame.unused_data
    return bytes(whole)


def unpack_file(source: Path, target: Path) -> None:
    """Unpack a file of zstd in bounded memory, and onto bounded disk space.

    Args:
        source: packed file.
        target: new file.

    Raises:
        InputError: it unpacks to too much.
    """
    left = MOST_EXPANSION * source.stat().st_size
    with zstd.open(source, "rb") as packed, open(target, "xb") as plain:
        while piece := packed.read(_PIECE):
            left -= len(piece)
            if left < 0:
                remedy = "unpack it with zstd -d, and read what comes out"
                raise InputError(f"the file unpacks to more than {MOST_EXPANSION} times its size", remedy=remedy)
            plain.write(piece)


class Chunk(NamedTuple):
    """A chunk of an MCAP file, from its header."""

    offset: int
    compression: str
    packed: int
    plain: int


def check_mcap(path: Path) -> dict[int, Chunk]:
    """Unpack every compressed chunk once, within the size that it declares.

    Returns:
        The chunks by offset.

    Raises:
        InputError: a chunk is too large, or larger than it declares.
    """
    chunks = {}
    with open(path, "rb") as file:
        size = file.seek(0, 2)
        for chunk, data in _chunks(file, size):
            most = min(_LARGEST_CHUNK, MOST_EXPANSION * size)
            if chunk.plain > most:
                raise InputError(f"a chunk announces {chunk.plain} bytes", remedy=f"at most {most} are unpacked")
            if chunk.compression in _UNPACK:
                unpacked(data, chunk.compression, chunk.plain)
            chunks[chunk.offset] = chunk
    return chunks


def _chunks(file: Any, size: int) -> Iterator[tuple[Chunk, bytes]]:
    """Headers of the chunks of an MCAP file, with their packed bytes where they are compressed."""
    offset = 8
    while offset + 9 <= size:
        file.seek(offset)
        kind, length = struct.unpack("<BQ", file.read(9))
        if kind == 0x06 and offset + 9 + length <= size and length >= 40:
            _, _, plain, _, name = struct.unpack("<QQQII", file.read(32))
            compression = file.read(min(name, 8)).decode("ascii", "replace")
            if name > 8 or name + 40 > length:
                raise InputError("a chunk's header is damaged", remedy="copy the file again")
            (packed,) = struct.unpack("<Q", file.read(8))
            if packed > length - 40 - name:
                raise InputError("a chunk's header is damaged", remedy="copy the file again")
            data = file.read(packed) if compression in _UNPACK else b""
            yield Chunk(offset, compression, packed, plain), data
        offset += 9 + length


def check_index(index: Iterable[Any], chunks: dict[int, Chunk]) -> None:
    """Refuse an index (rosbags' ChunkInfo) that does not match the chunks, or with too many chunks at one time.

    rosbags keeps all unpacked chunks that overlap in time.

    Raises:
        InputError: such an index.
    """
    seen = set()
    events: list[tuple[int, int]] = []
    for info in index:
        told = Chunk(info.chunk_start_offset, info.compression, info.compressed_size, info.uncompressed_size)
        if told.offset in seen or chunks.get(told.offset) != told:
            raise InputError("the index disagrees with the chunks", remedy="the file is damaged; recover or reindex it")
        seen.add(told.offset)
        events += [(info.message_start_time, told.plain), (info.message_end_time + 1, -told.plain)]
    held = 0
    for _, size in sorted(events):
        held += size
        if held > _MOST_OPEN:
            raise InputError("chunks of more than 2 GiB overlap in time", remedy="sort the file by time first")


class BoundedReader(Reader):  # type: ignore[misc]
    """rosbags' reader of ROS 1 bags, with limits for the index and for unpacked data."""

    def open(self) -> None:
        """Open the bag and read its index."""
        size = self.path.stat().st_size
        self.index_left = size
        self.plain_left = MOST_EXPANSION * size
        super().open()

    def read_index_data(self, pos: int, indexes: dict[int, list[Any]]) -> None:
        """Read one part of the index; overlapping parts are together longer than the file.

        Args:
            pos: where the part begins in the file [bytes].
            indexes: by connection, to which it is added.

        Raises:
            InputError: the index is longer than the file.
        """
        begin = self.bio.tell()
        super().read_index_data(pos, indexes)
        self.index_left -= self.bio.tell() - begin
        if self.index_left < 0:
            raise InputError("the index is longer than the file", remedy="the bag is damaged: rosbag reindex")

    def read_chunk(self) -> Any:
        """Read a chunk's header; its data are unpacked later.

        Raises:
            InputError: when unpacked, the same chunks come many times.
        """
        chunk = super().read_chunk()
        kind = next(name for name, unpack in decompressors.items() if unpack is chunk.decompressor)

        def bounded(data: bytes) -> bytes:
            """The data of a chunk, unpacked; what may still be unpacked becomes less."""
            most = min(_LARGEST_CHUNK, self.plain_left)
            plain = unpacked(data, kind, most) if kind in _UNPACK else data
            self.plain_left -= len(plain)
            if self.plain_left < 0:
                raise InputError("the same chunks would be unpacked many times", remedy="sort the bag by time first")
            return plain

        return chunk._replace(decompressor=bounded)


def check_database(path: Path) -> None:
    """Refuse a database that is not all there.

    Raises:
        InputError: messages are left in the journal, which rosbags does not read; or the file is shorter than its
            header says, which some versions of SQLite accept as long as they do not need the end.
    """
    journal = path.with_name(f"{path.name}-wal")
    if journal.is_file() and journal.stat().st_size:
        problem = "the recorder was stopped: messages are left in the journal"
        remedy = "open it once with sqlite3 and run PRAGMA wal_checkpoint(TRUNCATE) to take them in"
        raise InputError(problem, value=journal.name, remedy=remedy)
    size = path.stat().st_size
    with open(path, "rb") as file:
        header = file.read(_DATABASE_HEADER)
    if len(header) < _DATABASE_HEADER:
        raise InputError("not a bag, or truncated", value=f"{size} bytes", remedy="copy the file again")
    page, changes, pages, counted_at = struct.unpack(">16xH6xII60xI4x", header)
    whole = pages * (2**16 if page == 1 else page)
    # An old writer leaves a count behind that holds for an earlier state of the file.
    if changes == counted_at and size < whole:
        raise InputError(f"truncated: {whole} bytes are announced", value=f"{size} bytes", remedy="copy the file again")
