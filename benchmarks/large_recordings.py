"""Long recordings: peak memory over the size of the numbers, and megabytes per second, for files of a gigabyte.

Every reading is a fresh process; its peak is VmHWM above that of the same process before it opens the file (Linux);
seconds are those of the processor, others on the machine take none of them.
Run alone: ``python benchmarks/large_recordings.py -o benchmarks/results/large_recordings.json``.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measure import Bound, write_results

CHANNELS = 20
MOST_MEMORY = 3.0
"""Times the size of the numbers as doubles."""

READ = """
import json, sys, time
import numpy as np
import flexdyn as fd
{prepare}

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))

shares = []
before, begin = peak(), time.process_time()
{read}
seconds = time.process_time() - begin
print(json.dumps(dict(grown=peak() - before, seconds=seconds, numbers=numbers, shares=len(shares))))
"""
OURS = """
rec = fd.read_recording(sys.argv[1], progress=shares.append)
numbers = rec.t.nbytes + sum(values.nbytes for values in rec.channels.values())
"""
PANDAS = """
frame = pandas.read_csv(sys.argv[1], float_precision="round_trip")
numbers = int(frame.memory_usage(index=False).sum())
"""

Maker = Callable[[Path, float], None]


def main() -> int:
    """Measure every format, print a line each, write the results; 1 if a bound is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("-o", type=Path, metavar="FILE", help="where to write the results")
    parser.add_argument("--gigabytes", type=float, default=1.0, help="size of each file")
    parser.add_argument("--only", nargs="+", choices=sorted(FORMATS), default=sorted(FORMATS))
    arguments = parser.parse_args()
    results: dict[str, Any] = {}
    for name in arguments.only:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"log.{name}"
            FORMATS[name](path, arguments.gigabytes)
            results[name] = measured(path)
    bounds = [
        Bound(f"{name}: peak over numbers", found["peak_over_numbers"], MOST_MEMORY) for name, found in results.items()
    ]
    for bound in bounds:
        print(bound)
    if arguments.o:
        command = f"python benchmarks/large_recordings.py --gigabytes {arguments.gigabytes:g}"
        content = {"channels": CHANNELS, "formats": results, "bounds": [bound.to_dict() for bound in bounds]}
        write_results(arguments.o, command, content)
    return 0 if all(bound.passed for bound in bounds) else 1


def measured(path: Path) -> dict[str, Any]:
    """Memory and speed of one file; of CSV, pandas' speed and memory beside it."""
    found = _row(path, _python(READ.format(prepare="", read=OURS), path))
    if path.suffix == ".csv":
        options = "import pandas, warnings; warnings.simplefilter('ignore')"
        found["pandas"] = _row(path, _python(READ.format(prepare=options, read=PANDAS), path))
    print(path.suffix, json.dumps(found))
    return found


def _row(path: Path, raw: dict[str, float]) -> dict[str, Any]:
    size = path.stat().st_size
    return {
        "file_megabytes": round(size / 1e6),
        "numbers_megabytes": round(raw["numbers"] / 1e6),
        "peak_over_numbers": round(raw["grown"] / raw["numbers"], 3),
        "megabytes_per_second": round(size / 1e6 / raw["seconds"], 1),
        "processor_seconds": round(raw["seconds"], 1),
        "reports_of_progress": int(raw["shares"]),
    }


def _python(code: str, path: Path) -> dict[str, float]:
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    numbers: dict[str, float] = json.loads(done.stdout)
    return numbers


def make_csv(path: Path, gigabytes: float) -> None:
    """Full digits of noise; the rows of one block repeat, time goes on."""
    block = np.random.default_rng(1).normal(size=(10_000, CHANNELS))
    rows = ["," + ",".join(map(repr, row)) + "\n" for row in block.tolist()]
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("t," + ",".join(f"q.joint{k}" for k in range(CHANNELS)) + "\n")
        sample = 0
        while stream.tell() < gigabytes * 1e9:
            stream.writelines(f"{(sample + k) * 1e-3!r}{row}" for k, row in enumerate(rows))
            sample += len(rows)


def _make_binary(path: Path, gigabytes: float) -> None:
    """Noise in the format that the suffix names, through the writer."""
    import flexdyn as fd

    samples = int(gigabytes * 1e9 / 8 / (CHANNELS + 1))
    random = np.random.default_rng(1)
    channels = {f"q.joint{k}": random.normal(size=samples) for k in range(CHANNELS)}
    fd.write_recording(fd.Recording(np.arange(samples) * 1e-3, channels), path)


FORMATS: dict[str, Maker] = {"csv": make_csv, "parquet": _make_binary, "mat": _make_binary, "h5": _make_binary}
"""Makers of a file of about so many gigabytes, by suffix; a new format takes one line."""

if __name__ == "__main__":
    raise SystemExit(main())
