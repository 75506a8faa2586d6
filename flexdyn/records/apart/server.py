"""The process that reads: it has the library loaded, and forks a child for every file.

If a child crashes, the server ends too: the caller notices the end and starts another one. A file that was read or
refused leaves no trace, because its child has ended.
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
