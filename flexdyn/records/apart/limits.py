"""Limits of a process that reads one file, which depend only on the size of the file."""

from __future__ import annotations

import contextlib
import os
import resource
import signal

from flexdyn.records.bounds import most_bytes

COMPUTING_SECONDS = 10
"""Computing time that any file may take [s]; a sound file of a megabyte takes about 0.01 s."""
BYTES_A_SECOND = 20_000_000
"""Bytes on disk for which a larger file may take one more second."""
WAITING = 10
"""Clock time per computing time [1]: a busy machine or a slow disk is no fault of the file."""
BYTES = 2**30
"""Bytes of memory that any file may take in addition to the process itself."""


def seconds_for(on_disk: int) -> int:
    """Seconds of computing that reading a file may take.

    Args:
        on_disk: bytes of the file.
    """
    return COMPUTING_SECONDS + on_disk // BYTES_A_SECOND


def bytes_for(on_disk: int) -> int:
    """Bytes of memory that reading a file may take: twice the bytes that it may declare, and a constant.

    Args:
        on_disk: bytes of the file.
    """
    return BYTES + 2 * most_bytes(on_disk)


def limit_this_process(seconds: int, memory: int) -> None:
    """Limit time and memory of this process permanently; the system ends it if it takes more time.

    Memory is bounded on Linux only: other systems do not keep to the limit.

    Args:
        seconds: of computing.
        memory: bytes beyond what the process has already.
    """
    limits = {"RLIMIT_CORE": 0, "RLIMIT_FSIZE": 0, "RLIMIT_CPU": seconds}
    with contextlib.suppress(OSError), open("/proc/self/statm", "rb") as stream:
        limits["RLIMIT_AS"] = int(stream.read().split()[0]) * os.sysconf("SC_PAGE_SIZE") + memory
    for name, most in limits.items():
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(getattr(resource, name), (most, most + (name == "RLIMIT_CPU")))
    signal.alarm(WAITING * seconds)
