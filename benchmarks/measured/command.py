"""The command that every study of measured data is: find the data, hold the bounds, write the results and the page."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from measure import Bound, write_results

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Parts:
    """What a study is made of.

    Attributes:
        study: of a folder of data.
        bounds: that must hold, of the study.
        results: of the study and its bounds, as the result file keeps them.
        write_page: of the study and its bounds, into a folder.
    """

    study: Callable[[Path], Any]
    bounds: Callable[[Any], list[Bound]]
    results: Callable[[Any, list[Bound]], dict[str, Any]]
    write_page: Callable[[Any, list[Bound], Path], None]


@dataclass(frozen=True)
class Cost:
    """What a study took.

    Attributes:
        processor_seconds: without the page [s].
        peak_megabytes: the most memory that the process held [MB]; None where the system does not tell.
    """

    processor_seconds: float
    peak_megabytes: float | None


def peak_megabytes() -> float | None:
    """The most memory that this process has held [MB]; Linux only, see footprint.py; None elsewhere."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    lines = (line.split() for line in status.read_text(encoding="utf-8").splitlines())
    return next((int(line[1]) * 1024 / 1e6 for line in lines if line and line[0] == "VmHWM:"), None)


def command(script: str, about: str, data: str, needs: Sequence[str], parts: Parts) -> int:
    """Run a study as a program; where its data is not there, say so and do nothing.

    Args:
        script: path of its file.
        about: its docstring.
        data: name of its folder among the measured data.
        needs: files or folders that must be in there.
        parts: of the study.

    Returns:
        0 where all bounds hold, else 1.
    """
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("-o", type=Path, required=True, help="the result file; the page goes into a folder beside it")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    options = parser.parse_args()
    folder = options.data / data
    if not all((folder / each).exists() for each in needs):
        print(f"skipped: {folder} does not hold {', '.join(needs)} (--data)")
        return 0
    begin = time.process_time()
    made = parts.study(folder)
    held = parts.bounds(made)
    results = parts.results(made, held)
    cost = Cost(time.process_time() - begin, peak_megabytes())
    name = Path(script).resolve().relative_to(ROOT).as_posix()
    write_results(options.o, f"python {name}", {**results, "cost": asdict(cost)})
    parts.write_page(made, held, options.o.with_suffix(""))
    print(*held, sep="\n")
    return 0 if all(each.passed for each in held) else 1
