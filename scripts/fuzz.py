"""Try hostile inputs on every reader, the command line and the border of the core, and print what became of them.

python scripts/fuzz.py -o benchmarks/results/fuzz.json
python scripts/fuzz.py --inputs 5000 --only HDF5 --only URDF
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import flexdyn  # noqa: F401 - the installed one: the folder of the same name beside the tests has no core

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from measure import Bound, write_results  # noqa: E402
from trust_tables import FAULTS, fuzz_table  # noqa: E402

from tests.fuzz.harness import Tally, run  # noqa: E402
from tests.fuzz.targets import TARGETS  # noqa: E402


def main() -> int:
    """Run the fuzzer.

    Returns:
        1 if any input crashed, hung, or was answered by anything but a result or one line.
    """
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=200_000, help="how many in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", choices=[target.name for target in TARGETS])
    parser.add_argument("--folder", type=Path, help="to work in; what ended in a fault stays in its folder faults")
    parser.add_argument("-o", "--output", type=Path, help="a file for the results")
    given = parser.parse_args()
    targets = [target for target in TARGETS if not given.only or target.name in given.only]
    share = sum(target.share for target in targets)
    folder = (given.folder or Path(tempfile.mkdtemp(prefix="fuzz"))).resolve()
    tallies: list[Tally] = []
    for target in targets:
        begin = time.monotonic()
        tally = run(target, round(given.inputs * target.share / share), given.seed, folder)
        tallies.append(tally)
        took = f"{tally.inputs} inputs in {time.monotonic() - begin:.0f} s"
        print(f"{target.name}: {took}, {tally.bad} faults, slowest {tally.slowest_input}", file=sys.stderr, flush=True)
        for where, count in tally.faults.most_common():
            print(f"    {count or '':>6} {where}", file=sys.stderr, flush=True)
    content: dict[str, Any] = {"seed": given.seed, "readers": [tally.to_dict() for tally in tallies]}
    print(fuzz_table(content))
    if given.output is not None:
        counted = {kind: sum(row[kind] for row in content["readers"]) for kind in FAULTS}
        content["bounds"] = [
            Bound(f"inputs that end in a {kind}", count, 0).to_dict() for kind, count in counted.items()
        ]
        write_results(given.output, f"python scripts/fuzz.py --inputs {given.inputs} --seed {given.seed}", content)
    if any(tally.bad for tally in tallies):
        print(f"the inputs that ended in a fault are in {folder / 'faults'}", file=sys.stderr)
    return int(any(tally.bad for tally in tallies))


if __name__ == "__main__":
    sys.exit(main())
