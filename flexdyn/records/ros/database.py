"""Check the database of a ROS 2 bag (.db3) for what SQLite and rosbags pass over in silence."""

from __future__ import annotations

import struct
from pathlib import Path

from flexdyn.errors import InputError

_DATABASE_HEADER = 100
"""Bytes; https://sqlite.org/fileformat2.html, section 1.3."""


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
