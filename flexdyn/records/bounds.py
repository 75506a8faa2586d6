"""Limits of recordings in any format; `docs/limits.md` lists them together with those of each reader."""

from __future__ import annotations

from flexdyn.errors import InputError

MOST_FILE = 2**40
"""Largest file [bytes]."""
MOST_BYTES = 16 * 2**30
"""Largest size of all arrays that are read [bytes]."""
MOST_EXPANSION = 1100
"""Largest ratio of unpacked to packed size [1]: deflate compresses at most by a factor of 1032."""
SMALL = 2**28
"""Up to this unpacked size a file may unpack to `MOST_EXPANSION` times its size [bytes]."""
USUAL_EXPANSION = 64
"""Largest ratio of unpacked to packed size for more than `SMALL` bytes [1]."""
MOST_COLUMNS = 10_000
"""Largest number of channels, columns, arrays, variables or datasets of a file."""
MOST_SAMPLES = 2**31 - 1
"""Largest number of samples of a channel."""


def most_bytes(on_disk: int) -> int:
    """Largest size of the arrays of a file [bytes].

    Args:
        on_disk: bytes of the file.
    """
    return min(MOST_BYTES, MOST_EXPANSION * on_disk, max(SMALL, USUAL_EXPANSION * on_disk))


def check_size(declared: int, on_disk: int) -> None:
    """Refuse a file that declares more data than it can contain, before any of it is unpacked.

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
    """Refuse a file with more columns than any robot has.

    Raises:
        InputError: more than `MOST_COLUMNS`.
    """
    if columns > MOST_COLUMNS:
        remedy = "copy the channels wanted into a file of their own"
        raise InputError(f"the file has more than {MOST_COLUMNS} columns", remedy=remedy)
