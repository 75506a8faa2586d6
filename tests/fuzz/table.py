"""The table of a run of the fuzzer, for people."""

from __future__ import annotations

from collections.abc import Sequence

from tests.fuzz.harness import Tally

HEAD = ("", "inputs", "read", "refused", "crashes", "hangs", "tracebacks", "not one line", "slowest", "memory")


def table(tallies: Sequence[Tally]) -> str:
    """One row a target and a last one for all, in Markdown.

    The slowest input is in seconds of computing, by the clock where another process reads; memory is the most that a
    process held, the program itself included.
    """
    rows = [_row(tally) for tally in tallies]
    every = Tally("all")
    for tally in tallies:
        every.inputs += tally.inputs
        every.outcomes += tally.outcomes
        every.slowest, every.memory = max(every.slowest, tally.slowest), max(every.memory, tally.memory)
    lines = [HEAD, ("---", *("---:",) * (len(HEAD) - 1)), *rows, _row(every)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _row(tally: Tally) -> tuple[str, ...]:
    kinds = ("read", "refused", "crash", "hang", "traceback", "line")
    counts = (f"{tally.outcomes[kind]}" for kind in kinds)
    return (tally.name, f"{tally.inputs}", *counts, f"{tally.slowest:.2f} s", f"{tally.memory / 2**20:.0f} MiB")
