"""One case diagnosed by the posterior over structures, which is built beside the present engine.

python benchmarks/posterior.py model.yaml fit.npz check.npz -o DIR
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import flexdyn as fd
from flexdyn.diagnose.decision.run import diagnose


def main() -> int:
    """Diagnose, and save the report."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("fit", type=Path)
    parser.add_argument("check", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    o = parser.parse_args()
    model = fd.load_model(o.model)
    answer = diagnose(model, [fd.read_recording(o.fit)], [fd.read_recording(o.check)])
    answer.save(o.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
