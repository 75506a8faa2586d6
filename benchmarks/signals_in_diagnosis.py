"""Would one noise estimator and one smoother do? Hidden-effect cases, diagnosed with those for users in their place.

    python benchmarks/signals_in_diagnosis.py -o benchmarks/results/signals_in_diagnosis.json

Three times the same cases: as flexdyn is; with `estimate_noise` weighing encoders; with kernels of `Smoother`, of the
cut-off of the diagnosis' own, in all its filters.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from measure import arguments, conclude
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data import channel_noise
from flexdyn.records.signals.kernels import GaussianSmoother, kernels

sys.path.insert(0, str(Path(__file__).parent / "discovery"))

from cases import CHECK, FIT, sensors_of
from make import build, write_case
from overview import summary
from score import read, score

Array = NDArray[np.float64]
FAMILIES = ("none", "single", "hard")
DEGREE, TAPER = 3, 3
"""Of a `Smoother`, as users get it."""


def whole_noise(x: Array) -> float:
    """All of the noise of an encoder (samples,), where the diagnosis takes what changes from sample to sample."""
    return fd.estimate_noise(np.arange(len(x)), x).std


def local_polynomial(sigma: float, dt: float) -> GaussianSmoother:
    """Kernels of the `Smoother` whose cut-off is that of a Gaussian of this standard deviation [s]."""
    cutoff = np.sqrt(np.log(2.0)) / (2.0 * np.pi * sigma)
    try:
        width = fd.Smoother.at_cutoff(cutoff, 1.0 / dt, DEGREE, TAPER).width
    except fd.InputError:
        width = 5  # the narrowest one, where the clock is slow
    found = kernels(width // 2, DEGREE, TAPER)
    return GaussianSmoother(np.array([found.value, found.first / dt, found.second / dt**2]))


@contextmanager
def variant(name: str) -> Iterator[None]:
    """The diagnosis with one part exchanged."""
    if name == "noise of users":
        with patch.object(channel_noise, "reading_noise", whole_noise):
            yield
    elif name == "smoother of users":
        with patch.object(GaussianSmoother, "of_width", local_polynomial):
            yield
    else:
        yield


VARIANTS = ("as it is", "noise of users", "smoother of users")


def diagnosed(folder: Path, name: str, place: Path) -> tuple[dict[str, Any] | None, float]:
    """The report of one variant, None where it fails, and its processor time [s]."""
    model = fd.load_model(folder / "model.yaml")
    fit, check = (fd.read_recording(folder / f"{each}.npz") for each in ("fit", "check"))
    begin = time.process_time()
    with variant(name):
        try:
            fd.diagnose(model, fit, check=check).save(place)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
            print(f"{folder.name}, {name}: {error}", file=sys.stderr)
            return None, time.process_time() - begin
    return read(place / "report.json"), time.process_time() - begin


def main() -> int:
    """Make the cases, diagnose each in every variant, print and write."""
    parser = arguments(__doc__)
    parser.add_argument("--seed", type=int, default=71)
    parser.add_argument("--count", type=int, default=12, help="cases of each family")
    given = parser.parse_args()
    rows: dict[str, list[dict[str, Any]]] = {name: [] for name in VARIANTS}
    with tempfile.TemporaryDirectory() as scratch:
        for family in FAMILIES:
            for number in range(given.count):
                case = build(family, given.seed, number, FIT, CHECK, sensors_of(family))
                folder = write_case(case, Path(scratch) / family)
                truth = read(Path(scratch) / f"{family}.truth" / f"{folder.name}.json")
                if truth is None:
                    raise FileNotFoundError(f"{folder.name} has no truth")
                for name in VARIANTS:
                    report, seconds = diagnosed(folder, name, Path(scratch) / "reports" / name / folder.name)
                    rows[name].append(score(truth, report) | {"seconds": seconds})
                print(folder.name, *(rows[name][-1]["outcome"] for name in VARIANTS), sep="  ", flush=True)
    keys = ("cases", "points", "right", "half", "beside", "wrong", "missed", "failed", "coverage", "intervals")
    content = {
        "variants": {
            name: {
                family: {key: found[key] for key in (*keys, "false_names", "median_seconds")}
                for family, found in summary(each).items()
            }
            for name, each in rows.items()
        }
    }
    command = f"signals_in_diagnosis.py --seed {given.seed} --count {given.count}"
    return conclude([], given.output, command, content)


if __name__ == "__main__":
    sys.exit(main())
