"""The process that reads: it has the library loaded, and forks a child for every file.

A child that dies takes the server with it: whoever asked sees the end, and starts another one. A file that was read,
or refused in words, leaves no trace, for its child is gone too.
"""

from __future__ import annotations

import gc
import json
import os
import sys
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from flexdyn.errors import FlexdynError
from flexdyn.records.apart.limits import limit_this_process
from flexdyn.records.apart.messages import request_of, send, send_error, send_table

SIGNALLED = 64
"""The server's exit code, plus the number of the signal that ended its child."""
_OUT = 1


def serve(module: str) -> None:
    """Read the files that are asked for on stdin, one line of JSON each, until it ends.

    Args:
        module: whose `read_here` gives the table of a path and a request, and whose `library` loads what it needs.
    """
    reader = import_module(module)
    reader.library()
    gc.freeze()  # no child goes through what was there before it, which would copy it
    send(_OUT, "ready", None)
    for line in sys.stdin.buffer:
        child = os.fork()
        if not child:
            _read(reader, json.loads(line))
        _, status = os.waitpid(child, 0)
        if status:
            os._exit(SIGNALLED + os.WTERMSIG(status) if os.WIFSIGNALED(status) else 1)


def _read(reader: Any, task: Any) -> None:
    """Answer one task, and end the process."""
    code = 1
    try:
        limit_this_process(task["seconds"], task["bytes"])
        request = replace(request_of(task["request"]), progress=partial(send, _OUT, "progress"))
        send_table(_OUT, reader.read_here(Path(task["path"]), request))
        code = 0
    except FlexdynError as error:
        send_error(_OUT, error)
        code = 0
    except MemoryError:
        send(_OUT, "memory", None)
        code = 0
    finally:
        os._exit(code)
