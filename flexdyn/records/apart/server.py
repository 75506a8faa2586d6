"""The process that reads: it has the library loaded, and forks a child for every file.

If a child crashes, the server ends too: the caller notices the end and starts another one. A file that was read or
refused leaves no trace, because its child has ended.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import pickle
import resource
import signal
import sys
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from flexdyn.errors import FlexdynError
from flexdyn.records.apart.messages import send, send_table
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


SIGNALLED = 64
"""The server's exit code, plus the number of the signal that ended its child."""
_OUT = 1


def serve(module: str) -> None:
    """Read the files that are requested on stdin, one line of JSON for each, until stdin ends.

    Args:
        module: whose `read_here` gives the table of a path and a request, and whose `library` loads what it needs.
    """
    reader = import_module(module)
    reader.library()
    gc.freeze()  # the child's garbage collection skips older objects; visiting them would copy their memory
    send(_OUT, "ready", None)
    for line in sys.stdin.buffer:
        child = os.fork()
        if not child:
            _answer(reader, json.loads(line))
        _, status = os.waitpid(child, 0)
        if status:
            os._exit(SIGNALLED + os.WTERMSIG(status) if os.WIFSIGNALED(status) else 1)


def _answer(reader: Any, task: Any) -> None:
    """Answer one task, and end the process."""
    code = 1
    try:
        limit_this_process(task["seconds"], task["bytes"])
        request = pickle.loads(bytes.fromhex(task["request"]))  # noqa: S301 - the caller's, not the file's
        request = replace(request, progress=partial(send, _OUT, "progress"))
        send_table(_OUT, reader.read_here(Path(task["path"]), request))
        code = 0
    except FlexdynError as error:
        send(_OUT, "error", {"problem": error.problem, **error.data})
        code = 0
    except MemoryError:
        send(_OUT, "memory", None)
        code = 0
    finally:
        os._exit(code)
