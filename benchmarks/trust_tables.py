"""Tables of what was tried to break flexdyn: hostile inputs, random models, long runs, the slowest allowed files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from result_tables import markdown_table

FAULTS = ("crash", "hang", "traceback", "line")
"""What no input may lead to, as the fuzzer counts it; the last is an answer of more than one line."""


def fuzz_table(results: Mapping[str, Any]) -> str:
    """What became of hostile inputs, a row for each reader and a last one for all."""
    head = ["", "inputs", "read", "refused", "crashes", "hangs", "tracebacks", "not one line", "slowest", "memory"]
    rows: Sequence[Mapping[str, Any]] = results["readers"]
    kinds = ("inputs", "read", "refused", *FAULTS)
    every = {"name": "all"} | {kind: sum(row[kind] for row in rows) for kind in kinds}
    every |= {key: max(row[key] for row in rows) for key in ("seconds", "bytes")}
    body = [
        [
            row["name"],
            *(f"{row[kind]:,}" for kind in kinds),
            f"{row['seconds']:.2f} s",
            f"{row['bytes'] / 2**20:.0f} MiB",
        ]
        for row in (*rows, every)
    ]
    return markdown_table(head, body)
