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


def sanitizers_table(results: Mapping[str, Any]) -> str:
    """Tests on cores that were built with sanitizers, and what these reported."""
    head = ["sanitizer", "commit", "date", "tests passed", "failed", "skipped", "findings"]
    keys = ("sanitizer", "commit", "date", "passed", "failed", "skipped", "findings")
    body = [[f"{row[key]:,}" if isinstance(row[key], int) else row[key] for key in keys] for row in results["runs"]]
    return markdown_table(head, body, text=3)


def growth_table(results: Mapping[str, Any]) -> str:
    """Random arms on which the solvers part: what a tiny turn of the first joint becomes, and the solvers beside it."""
    head = ["seed", "joints", "solvers apart at default tolerances", "a turn grows by", "until, s"]
    head += ["1e-9 rad at the start, then", "solvers at tight tolerances, then"]
    body = [
        [
            *(str(each[key]) for key in ("seed", "joints")),
            *(f"{each[key]:.1e}" for key in ("default", "factor")),
            f"{each['lost']:.2f}",
            *(f"{each[key]:.1e}" for key in ("turned", "solvers")),
        ]
        for each in results["models"]
    ]
    return markdown_table(head, body)


def slowest_table(results: Mapping[str, Any]) -> str:
    """The dearest files within the limits of every reader, and what a megabyte more would cost."""
    head = ["reader", "file", "size, MB", "time, s", "a MB more, s"]
    body = [
        [
            *(str(row[key]) for key in ("reader", "file")),
            *(f"{row[key]:.2f}" for key in ("megabytes", "seconds")),
            f"limit of {row['limit']}" if row["limit"] else f"{row['seconds'] / row['megabytes']:.2g}",
        ]
        for row in results["rows"]
    ]
    return markdown_table(head, body, text=2)


def long_runs_table(results: Mapping[str, Any]) -> str:
    """Memory and time of much work, early on and at its end."""
    head = ["work", "how much", "memory after 20 %, MB", "at the end, MB", "of it the run's own data, MB"]
    head += ["CPU of a unit, last tenth / second tenth"]
    body = [
        [
            *(row[key] for key in ("name", "units")),
            *(f"{each:.1f}" for each in (*row["memory"], row["kept"])),
            f"{row['cost'][1] / row['cost'][0]:.2f}",
        ]
        for row in results["rows"]
    ]
    return markdown_table(head, body, text=2)


def long_pages_table(results: Mapping[str, Any]) -> str:
    """What a long motion costs in a diagnosis and its pages in a browser, each beside the shorter one."""
    rows: Sequence[Mapping[str, Any]] = results["rows"]
    first, lengths = rows[0], [f"{row['seconds']:,.0f} s" for row in rows]
    head = ["", "", *lengths, "times"]
    body = [
        _beside("diagnosis", "memory, MB", [row["memory"] for row in rows]),
        _beside("diagnosis", "computing", [row["computing"] for row in rows], times_alone=True),
    ]
    for name in first["pages"]:
        pages = [row["pages"][name] for row in rows]
        body += [
            _beside(name, "size, MB", [page["megabytes"] for page in pages]),
            _beside(name, "browser's memory, MB", [page["memory"] for page in pages]),
            _beside(name, "computing until drawn", [page["computing"] for page in pages], times_alone=True),
        ]
    return markdown_table(head, body, text=2)


def _beside(name: str, what: str, found: Sequence[float], *, times_alone: bool = False) -> list[str]:
    """One quantity for every length, and the last over the first; seconds of a busy machine would say little."""
    shown = ["" if times_alone else f"{each:,.1f}" for each in found]
    return [name, what, *shown, f"{found[-1] / found[0]:.2f}"]


def random_runs_table(results: Mapping[str, Any]) -> str:
    """Random models through every solver, and how far the solvers are apart."""
    head = ["models", "solver", "runs", "ended", "budget spent", "other error", "proposed solver ended", "worst CPU, s"]
    body, apart = [], []
    for which, found in results["surveys"].items():
        for name, row in found["rows"].items():
            numbers = [row[key] for key in ("models", "ended", "budget spent", "other error", "rescued")]
            body.append([which, name, *map(str, numbers), f"{row['seconds']:.1f}"])
        far = [pair for pair in found["differ"] if pair[1] > 1e-3]
        said = ", ".join(f"{seed}: {size:.2g}" for seed, size in far[:12]) or "none"
        steps = (f"{each:.2g}" for each in found["fixed_step"])
        apart.append([which, str(len(found["differ"])), str(len(far)), said, *steps])
    beside = ["models", "DormandPrince and Rosenbrock ended", "apart by 1e-3 of the motion", "seed: difference"]
    beside += ["TimeStepping from Rosenbrock, median", "nine of ten below"]
    return markdown_table(head, body, text=2) + "\n\n" + markdown_table(beside, apart)
