"""What any recording may hold and take, whatever its format; `docs/limits.md` lists these with those of each reader."""

from __future__ import annotations

from flexdyn.errors import InputError

MOST_FILE = 2**40
"""Bytes of a file."""
MOST_BYTES = 16 * 2**30
"""Bytes of all arrays that are read."""
MOST_EXPANSION = 1100
"""Deflate shrinks at most 1032 times: what declares more than this times its file's size is no honest file."""
SMALL = 2**28
"""Bytes up to which a file may unpack to `MOST_EXPANSION` times its size."""
USUAL_EXPANSION = 64
"""Times its size to which a file may unpack beyond `SMALL`."""
MOST_COLUMNS = 10_000
"""Channels, columns, arrays, variables or datasets of a file."""
MOST_SAMPLES = 2**31 - 1
"""Samples of a channel."""


def most_bytes(on_disk: int) -> int:
    """Bytes that the arrays of a file may have.

    Args:
        on_disk: bytes of the file.
    """
    return min(MOST_BYTES, MOST_EXPANSION * on_disk, max(SMALL, USUAL_EXPANSION * on_disk))


def check_size(declared: int, on_disk: int) -> None:
    """Refuse a file that announces more than it can honestly hold, before any of it is unpacked.

    Args:
        declared: bytes of all arrays as the file's headers give them.
        on_disk: bytes of the file.

    Raises:
        InputError: more than `most_bytes`.
    """
    if declared > most_bytes(on_disk):
        problem = f"the file of {on_disk} bytes declares {declared} bytes of arrays"
        usual = f"{USUAL_EXPANSION} times the file's size, up to 256 MiB {MOST_EXPANSION} times"
        raise InputError(problem, remedy=f"the limits are 16 GiB and {usual}")


def check_count(columns: int) -> None:
    """Refuse a file of more columns than any robot has.

    Raises:
        InputError: more than `MOST_COLUMNS`.
    """
    if columns > MOST_COLUMNS:
        remedy = "copy the channels wanted into a file of their own"
        raise InputError(f"the file has more than {MOST_COLUMNS} columns", remedy=remedy)
