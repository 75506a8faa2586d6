"""Libraries against our own code: who is right on what users have, and who is faster.

    python benchmarks/libraries/decide.py -o benchmarks/results/libraries.json
    python benchmarks/libraries/decide.py --only mat_files -o benchmarks/results/libraries.json

Our own code stays where the library is wrong on an input on which ours is right, needs more than twice the processor
time, or is not there in a plain installation; else the library takes its place. With `--only`, the other comparisons of
the result file stay as they are. Measured files are looked for in the folder of `--data`, and left out where it is not.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from comparison import Comparison
from measure import write_results
from result_tables import libraries_table

PARTS = ("mat_files", "csv_files", "bag_messages", "study_store", "spectra")


def main() -> int:
    """Compare, print the table, write the results; 1 if our own code is wrong somewhere."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("-o", type=Path, metavar="FILE", help="where to write the results")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    options = parser.parse_args()
    made: dict[str, Any] = {}
    if options.o and options.o.is_file():
        made = json.loads(options.o.read_text(encoding="utf-8"))["parts"]
    for part in options.only:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what a reader guesses is beside the point here
            found = importlib.import_module(part).compare(options.data)
        made[part] = [each.to_dict() for each in ([found] if isinstance(found, Comparison) else found)]
    versions = {name: version(name) for name in ("pandas", "pyarrow", "rosbags", "zarr")}
    results = {"libraries": versions, "parts": {part: made[part] for part in PARTS if part in made}}
    print(libraries_table(results))
    if options.o:
        write_results(options.o, "python benchmarks/libraries/decide.py", results)
    wrong = [
        case["name"] for each in results["parts"].values() for one in each for case in one["cases"] if case["ours"]
    ]
    print(*(f"FAIL  our own code is wrong: {name}" for name in wrong), sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
