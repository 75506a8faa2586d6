"""How long may a file within the limits of docs/limits.md keep its reader busy?

    python benchmarks/slowest_files.py [--megabytes 8] [-o FILE.json]

For every reader some files that cost it most: the smallest cells, the most columns, the smallest messages, the best
packed zeros, the longest YAML, the largest URDF. The time of formats without a limit of bytes grows with the file, so
that it is told for a megabyte. CPU time; by the clock where another process reads (HDF5 and MATLAB 7.3).
"""

from __future__ import annotations

import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from measure import Bound, arguments, conclude  # noqa: E402
from slowest_made import CASES, Case  # noqa: E402
from trust_tables import slowest_table  # noqa: E402

import flexdyn as fd  # noqa: E402

PER_MEGABYTE = 2.0  # s of computing: a minute for a file of 30 MB
LIMITED = 60.0  # s


def timed(case: Case, folder: Path, megabytes: float) -> dict[str, Any]:
    """One file, made and read."""
    path = folder / f"input{case.suffix}"
    case.make(path, megabytes)
    clock: Callable[[], float] = time.perf_counter if case.apart else time.process_time
    begin = clock()
    try:
        case.read(path)
        answer = "read"
    except fd.InputError as error:
        answer = f"refused: {error.problem[:60]}"
    seconds = clock() - begin
    size = path.stat().st_size / 1e6
    row = {"reader": case.reader, "file": case.name, "megabytes": size, "seconds": seconds, "answer": answer}
    print(f"{case.reader}, {case.name}: {size:.2f} MB in {seconds:.2f} s, {answer}", file=sys.stderr, flush=True)
    return row | {"limit": case.limit}


def main() -> int:
    """Time all of them, print, write."""
    parser = arguments(__doc__)
    parser.add_argument("--megabytes", type=float, default=8.0, help="of files that may have any size")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = []
    with tempfile.TemporaryDirectory() as place:
        for k, case in enumerate(CASES):
            folder = Path(place) / str(k)
            folder.mkdir()
            rows.append(timed(case, folder, args.megabytes))
    content = {"rows": rows}
    print(slowest_table(content))
    limited = [row["seconds"] for row in rows if row["limit"]]
    others = [row["seconds"] / max(1.0, row["megabytes"]) for row in rows if not row["limit"]]
    bounds = [
        Bound("slowest file where bytes, columns or time are limited, s", float(np.max(limited)), LIMITED),
        Bound("slowest megabyte of the others, s", float(np.max(others)), PER_MEGABYTE),
    ]
    command = f"python benchmarks/slowest_files.py --megabytes {args.megabytes:g}"
    return conclude(bounds, args.output, command, content)


if __name__ == "__main__":
    sys.exit(main())
