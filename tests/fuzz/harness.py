"""Inputs run in forked processes with bounds of memory and time; what became of each is counted.

A child takes inputs one after the other until one of them ends it; the next child goes on behind that one. The system
ends a child whose input computes for more than `HANG` seconds, or whose memory grows by more than `MEMORY`.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import os
import random
import resource
import select
import signal
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexdyn.errors import FlexdynError
from tests.fuzz.targets import Target

HANG = 10.0
"""Seconds of computing after which an input counts as one that hangs."""
WAIT = 300.0
"""Seconds by the clock, likewise: the machine may be busy with other things."""
MEMORY = 3 * 2**30
"""Bytes that a child may take beyond what it has at its start."""
LONGEST_LINE = 2000


@dataclass
class Tally:
    """What became of the inputs of one target.

    Attributes:
        name: of the target.
        inputs: how many were tried.
        outcomes: how many were read, refused, and ended in each kind of fault.
        faults: where each kind of fault was, and how often.
        slowest: seconds of computing of the slowest input (by the clock where another process reads).
        slowest_input: its number.
        memory: bytes, the most that any child took.
    """

    name: str
    inputs: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0
    slowest_input: int = 0
    memory: int = 0

    @property
    def bad(self) -> int:
        """Inputs that were neither read nor refused by one line."""
        return self.inputs - self.outcomes["read"] - self.outcomes["refused"]

    def to_dict(self) -> dict[str, Any]:
        """As the result file writes it.

        The slowest input in seconds of computing, by the clock where another process reads; the most bytes that a
        process held, the program itself included.
        """
        kinds = ("read", "refused", "crash", "hang", "traceback", "line")
        outcomes = {kind: self.outcomes[kind] for kind in kinds}
        return {"name": self.name, "inputs": self.inputs} | outcomes | {"seconds": self.slowest, "bytes": self.memory}


def input_of(target: Target, seeds: list[bytes], seed: int, number: int) -> bytes:
    """The input of a number: the same on every machine."""
    return target.mutate(random.Random(f"{seed} {target.name} {number}"), seeds)


def run(target: Target, count: int, seed: int, folder: Path) -> Tally:
    """Try so many inputs.

    Args:
        target: what to try them on.
        count: how many.
        seed: of the inputs.
        folder: to work in; inputs that end in a fault are kept in ``folder/faults``.
    """
    work = folder / target.name
    work.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(work):
        seeds = target.seeds(work)
    tally = Tally(target.name)
    while tally.inputs < count:
        _batch(target, seeds, seed, min(count, tally.inputs + target.batch), work, tally)
    return tally


def _batch(target: Target, seeds: list[bytes], seed: int, end: int, work: Path, tally: Tally) -> None:
    """Let one child go on to `end`, or to the input that ends it."""
    out, into = os.pipe()
    child = os.fork()
    if not child:
        os.close(out)
        _child(target, seeds, seed, range(tally.inputs, end), work, into)
    os.close(into)
    answered = _listen(out, tally)
    os.close(out)
    if not answered:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if tally.inputs < end:
        how = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else f"exit {status}"
        kind = "hang" if how == "SIGPROF" or not answered else "crash"
        _count(tally, kind, f"{kind}: {how}")
    _keep(target, seeds, seed, tally, work)


def _listen(out: int, tally: Tally) -> bool:
    """Count what a child says; whether it went on saying something."""
    rest = b""
    while True:
        if not select.select([out], [], [], WAIT)[0]:
            return False
        piece = os.read(out, 2**16)
        if not piece:
            return True
        *lines, rest = (rest + piece).split(b"\n")
        for line in lines:
            told = json.loads(line)
            tally.memory = max(tally.memory, told["memory"])
            if "outcome" in told:
                if told["seconds"] > tally.slowest:
                    tally.slowest, tally.slowest_input = told["seconds"], tally.inputs
                _count(tally, told["outcome"], told["where"])


def _count(tally: Tally, outcome: str, where: str) -> None:
    tally.outcomes[outcome] += 1
    if where:
        tally.faults[where] += 1
        if tally.faults[where] <= 3:
            tally.faults[f"  input {tally.inputs}"] += 0
    tally.inputs += 1


def _keep(target: Target, seeds: list[bytes], seed: int, tally: Tally, work: Path) -> None:
    """Write the inputs that ended in a fault into a folder, to be looked at."""
    for entry in tally.faults:
        if entry.startswith("  input "):
            number = int(entry.split()[-1])
            kept = work.parent / "faults" / f"{target.name}-{number}{target.suffix}"
            kept.parent.mkdir(exist_ok=True)
            if not kept.exists():
                kept.write_bytes(input_of(target, seeds, seed, number))


def _child(target: Target, seeds: list[bytes], seed: int, numbers: range, work: Path, into: int) -> None:
    """Try inputs and say what became of each; never returns."""
    os.chdir(work)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    faulthandler.disable()  # the tests switch it on, and it would tell every crash at length
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with open("/proc/self/statm", encoding="ascii") as stream:
        most = int(stream.read().split()[0]) * os.sysconf("SC_PAGE_SIZE") + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    for number in numbers:
        data = input_of(target, seeds, seed, number)
        signal.setitimer(signal.ITIMER_PROF, HANG)
        begin = _clock(target)
        outcome, where = _outcome(target, data, work)
        seconds = _clock(target) - begin
        signal.setitimer(signal.ITIMER_PROF, 0)
        _say(into, outcome=outcome, where=where, seconds=seconds, memory=_memory(resource.RUSAGE_SELF))
    target.end()
    _say(into, memory=_memory(resource.RUSAGE_CHILDREN))
    os._exit(0)


def _outcome(target: Target, data: bytes, work: Path) -> tuple[str, str]:
    """What becomes of one input, and where if it is a fault."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            target.run(work, data)
        except FlexdynError as error:
            line = str(error)
            if not line.isprintable() or len(line) > LONGEST_LINE:
                return "line", f"not one short line: {type(error).__name__} of {_place(error)}"
            return "refused", ""
        except BaseException as error:
            return "traceback", f"{type(error).__name__} of {_place(error)}: {str(error)[:80]!r}"
    for warning in told:
        if issubclass(warning.category, RuntimeWarning) or not str(warning.message).isprintable():
            return "line", f"warning {warning.category.__name__} {str(warning.message)[:80]!r} of {warning.filename}"
    return "read", ""


def _place(error: BaseException) -> str:
    """The last line of the package that an error went through."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/flexdyn/" in frame.filename]
    last = frames[-1] if frames else traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename.rpartition('/flexdyn/')[2]}:{last.lineno}"


def _clock(target: Target) -> float:
    return time.perf_counter() if target.apart else time.process_time()


def _memory(who: int) -> int:
    return resource.getrusage(who).ru_maxrss * 1024


def _say(into: int, **content: Any) -> None:
    os.write(into, json.dumps(content).encode() + b"\n")
