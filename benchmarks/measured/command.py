"""The command that every study of measured data is: find the data, hold the bounds, write the results and the page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from measure import Bound, write_results

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a study came to.

    Attributes:
        bounds: that must hold.
        results: as the result file keeps them.
        write_page: into a folder.
    """

    bounds: Sequence[Bound]
    results: dict[str, Any]
    write_page: Callable[[Path], None]


def command(script: str, about: str, data: str, needs: Sequence[str], study: Callable[[Path], Outcome]) -> int:
    """Run a study as a program; where its data is not there, say so and do nothing.

    Args:
        script: path of its file.
        about: its docstring.
        data: name of its folder among the measured data.
        needs: files or folders that must be in there.
        study: of that folder.

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
    made = study(folder)
    name = Path(script).resolve().relative_to(ROOT).as_posix()
    write_results(options.o, f"python {name}", made.results)
    made.write_page(options.o.with_suffix(""))
    print(*made.bounds, sep="\n")
    return 0 if all(each.passed for each in made.bounds) else 1
