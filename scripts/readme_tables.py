"""Fill the tables of README and docs from what they show: benchmark results, the effects catalogue, the shipped robots.

    python scripts/readme_tables.py            writes the pages
    python scripts/readme_tables.py --check    exit code 1 if a page is not what that would write

A table stands between ``<!-- table:NAME -->`` and ``<!-- /table:NAME -->``; NAME is a key of `TABLES`.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import flexdyn as fd
from flexdyn.records.files import FORMATS

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
sys.path[:0] = [str(ROOT / "benchmarks"), str(ROOT / "scripts")]

from constants_table import constants_table  # noqa: E402
from coverage_runs import coverage_table  # noqa: E402
from lines_table import lines_table  # noqa: E402
from result_tables import (  # noqa: E402
    MEASURED,
    accuracy_table,
    discovery_table,
    effect_checks_table,
    libraries_table,
    markdown_table,
    measured_names_table,
    measured_table,
    peers_table,
    rates_table,
    reliability_table,
)
from same_results import same_results_table  # noqa: E402
from signal_tables import (  # noqa: E402
    noise_estimators_table,
    signals_in_diagnosis_table,
    signals_on_robots_table,
    smoothers_table,
)
from trust_tables import (  # noqa: E402
    fuzz_table,
    growth_table,
    long_pages_table,
    long_runs_table,
    random_runs_table,
    sanitizers_table,
    slowest_table,
)
from wheels_table import wheels_table  # noqa: E402

MARKER = re.compile(r"<!-- (/?)table:(\w+) -->")


_NO_SIDE = {"inertia": "link", "model": "any"}


def effects() -> str:
    """The catalogue of flexdyn's own effects: name, side, law, parameters with units."""
    rows = []
    for name, kind in fd.effects.catalogue().items():
        if kind.__module__.startswith("flexdyn."):
            rows.append(
                [f"`{name}`", ", ".join(kind.sides) or _NO_SIDE[kind.stage], f"`{kind.law}`", _parameters(kind)]
            )
    return markdown_table(["effect", "side", "law", "parameters [unit]"], rows, text=4)


def robots() -> str:
    """The shipped models: what they are, their joints and stiffness, where the numbers come from."""
    rows = []
    for name in fd.shipped_models():
        model = fd.load_model(name)
        title = (ROOT / "robots" / name / "README.md").read_text(encoding="utf-8").splitlines()[0]
        source = f"[robots/{name}](robots/{name}/README.md)"
        rows.append([f"`{name}`", title.partition(": ")[2], str(model.n), _stiffness(model), source])
    return markdown_table(["model", "what", "joints", "stiffness", "source of every number"], rows, text=5)


_OF_FORMATS = {
    ".csv": ("-", "any delimiter, decimal commas and preambles by a map", "csv"),
    ".npz": ("-", "`numpy.savez`; two-dimensional arrays by a map", None),
    ".h5": ("`hdf5`", "h5py, flat or grouped; any group and two-dimensional arrays by a map", "h5"),
    ".parquet": ("`parquet`", "pandas", "parquet"),
    ".mat": ("- (v7.3: `hdf5`)", "MATLAB v5 and v7.3, structs included", "mat"),
    ".bag": (
        "`ros`",
        "ROS 1, ROS 2 (its folder too): JointState, controller states; any numbers by a map",
        "mcap",
    ),
}
"""By its first suffix: extra, what is read of others, and the large file that was measured."""


def formats() -> str:
    """What recordings are read from and written to, and the memory that reading a large file takes."""
    peaks = {name: each["peak_over_numbers"] for name, each in _results("large_recordings")["formats"].items()}
    peaks["mcap"] = _results("large_mcap")["bounds"][0]["value"]
    suffixes: dict[str, list[str]] = {}
    for suffix, fmt in FORMATS.items():
        suffixes.setdefault(fmt.read.__module__, []).append(suffix)
    rows = []
    for group in suffixes.values():
        extra, others, measured = _OF_FORMATS[group[0]]
        peak = "-" if measured is None else f"{peaks[measured]:.2f}"
        rows.append([" ".join(f"`{suffix}`" for suffix in group), extra, others, peak])
    header = ["read and written", "extra", "of other programs", "peak memory / size of the numbers"]
    return markdown_table(header, rows, text=3)


OF_RESULTS: dict[str, tuple[str, Callable[[Any], str]]] = {
    "accuracy": ("analytic_two_link", accuracy_table),
    "coverage": ("coverage", coverage_table),
    "discovery": ("discovery", discovery_table),
    "discovery_wide": ("discovery_wide", discovery_table),
    "reliability": ("discovery", reliability_table),
    "peers": ("peers", peers_table),
    "effect_checks": ("effects", effect_checks_table),
    "fuzz": ("fuzz", fuzz_table),
    "libraries": ("libraries", libraries_table),
    "lines": ("lines", lines_table),
    "long_pages": ("long_pages", long_pages_table),
    "long_runs": ("long_runs", long_runs_table),
    "noise_estimators": ("noise_estimators", noise_estimators_table),
    "random_growth": ("random_growth", growth_table),
    "random_runs": ("random_runs", random_runs_table),
    "rates": ("rates", rates_table),
    "same_results": ("same_results", same_results_table),
    "sanitizers": ("sanitizers", sanitizers_table),
    "signals_in_diagnosis": ("signals_in_diagnosis", signals_in_diagnosis_table),
    "signals_on_robots": ("signals_on_robots", signals_on_robots_table),
    "slowest_files": ("slowest_files", slowest_table),
    "smoothers": ("smoothers", smoothers_table),
    "wheels": ("wheels", wheels_table),
}
"""Tables of one result file: the file, and what makes the table of it. Without the file there is no table."""


def _of_results(file: str, table: Callable[[Any], str]) -> str:
    return table(_results(file))


TABLES: dict[str, Callable[[], str]] = {
    **{
        name: partial(_of_results, file, table)
        for name, (file, table) in OF_RESULTS.items()
        if (RESULTS / f"{file}.json").is_file()
    },
    "measured": lambda: measured_table(_measured()),
    "measured_names": lambda: measured_names_table(_measured()),
    "constants": lambda: constants_table(derived=False),
    "constants_derived": lambda: constants_table(derived=True),
    "effects": effects,
    "formats": formats,
    "robots": robots,
}


def markers(text: str) -> list[str]:
    """The names of the tables that a text has room for, in order.

    Raises:
        ValueError: a table that nobody makes, or a marker without its partner.
    """
    found = [(slash, name) for slash, name in MARKER.findall(text)]
    for opening, closing in zip(found[::2], [*found[1::2], ("", "")], strict=False):
        if opening[0] or closing != ("/", opening[1]):
            raise ValueError(f"the marker of table {opening[1]} has no partner")
        if opening[1] not in TABLES:
            raise ValueError(f"no such table: {opening[1]}; known: {', '.join(TABLES)}")
    return [name for slash, name in found if not slash]


def pages() -> list[Path]:
    """The README and the pages of docs that have room for tables."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [path for path in found if "generated" not in path.parts and MARKER.search(path.read_text(encoding="utf-8"))]


def filled(text: str, page: Path = ROOT / "README.md") -> str:
    """The text of a page with every table as it should be."""
    for name in dict.fromkeys(markers(text)):
        begin, end = f"<!-- table:{name} -->", f"<!-- /table:{name} -->"
        inside = f"{begin}\n{_table(name, page)}\n{end}".replace("\\", r"\\")
        text = re.sub(re.escape(begin) + ".*?" + re.escape(end), inside, text, flags=re.DOTALL)
    return text


def stale(text: str, page: Path = ROOT / "README.md") -> list[str]:
    """The names of the tables in the text of a page that are not what they should be."""
    names = dict.fromkeys(markers(text))
    return [name for name in names if f"<!-- table:{name} -->\n{_table(name, page)}\n<!--" not in text]


def _table(name: str, page: Path) -> str:
    """A table whose links, which are made for a page at the root, lead from this page."""
    up = "../" * (len(page.relative_to(ROOT).parts) - 1)
    return re.sub(r"\]\((?!\w+:)", f"]({up}", TABLES[name]())


def _measured() -> dict[str, dict[str, Any]]:
    return {name: _results(name) for name in MEASURED if (RESULTS / f"{name}.json").is_file()}


def _results(name: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return content


def _parameters(kind: type[fd.effects.Effect]) -> str:
    shown = []
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        if field.name in ("joint", "side"):
            continue
        unit = f" [{field.metadata['unit']}]" if "unit" in field.metadata else ""
        optional = field.default is not dataclasses.MISSING and field.default is not None
        shown.append(f"`{field.name}`{unit}" + (f" = {field.default:g}" if optional else ""))
    return ", ".join(shown)


def _stiffness(model: fd.FlexibleJointModel) -> str:
    """The range of K by kind of joint."""
    sliding = np.array([kind == "prismatic" for kind in model.robot.kinds])
    shown = []
    for which, unit in ((~sliding, "N m/rad"), (sliding, "N/m")):
        K = model.stiffness[which & model.elastic]
        if K.size:
            ends = dict.fromkeys(f"{end:,.10g}" for end in (K.min(), K.max()))
            shown.append(" to ".join(ends) + f" {unit}")
    rigid = int((~model.elastic).sum())
    return "; ".join([*shown, *([f"{rigid} rigid"] if rigid else [])])


def main() -> int:
    """Write the pages, or check them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if a table is stale")
    options = parser.parse_args()
    found = 0
    for page in pages():
        text, name = page.read_text(encoding="utf-8"), page.relative_to(ROOT)
        old = stale(text, page)
        found += len(old)
        if options.check:
            for table in old:
                print(f"{name}: table {table} is stale; run python scripts/readme_tables.py", file=sys.stderr)
            continue
        beside = page.with_name(f"{page.name}.part")
        beside.write_text(filled(text, page), encoding="utf-8")
        os.replace(beside, page)
        print(f"{name}: {len(markers(text))} tables, {len(old)} changed")
    return 1 if options.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
