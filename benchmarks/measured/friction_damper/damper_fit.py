"""Fit the damper's numbers to the force of three cycles of a 1 Hz file.

    python benchmarks/measured/friction_damper/damper_fit.py --data ../shared/data --start fitted.json -o fitted.json

The error of a model with dry friction and backlash has corners and valleys: without a start the best of many random
points is polished by Nelder and Mead. Those of ``fitted.json`` come from searches by CMA-ES over 3000 random points of
the same model, written a second time, and were polished here. Only cycles of `FIT` are read.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from damper_data import FIT, HERE, TENSIONS, Array, Bench, error, needed_force, read_records
from scipy.optimize import minimize

import flexdyn as fd

NUMBERS = {
    "stiffness": ("N/m", 2e6, 8e6),
    "damping": ("N s/m", 3e3, 3e4),
    "half_gap": ("m", 8e-4, 2.5e-3),
    "drum": ("kg", 20.0, 400.0),
    "level_positive": ("N", 2e3, 1.3e4),
    "level_negative": ("N", 2e3, 1.3e4),
    "presliding_level": ("N", 50.0, 4e3),
    "presliding_stiffness": ("N/m", 3e5, 2e6),
    "mass": ("kg", 400.0, 1600.0),
    "lead": ("s", 2e-4, 2e-3),
}
"""Numbers of the model with units and the range of the first points, drawn by logarithms."""
OFFSET = 500.0
"""Scale of the offset, which may be negative [N]."""
FAILED = 10.0
"""Cost of numbers that cannot be simulated [1]."""


def model_of(x: Array) -> tuple[fd.FlexibleJointModel, Bench]:
    """The model and the bench at a point of the search: logarithms, but for the last."""
    n = dict(zip(NUMBERS, np.exp(x[:-1]).tolist(), strict=True))
    e = fd.effects
    laws = [
        e.Backlash("damper", half_gap=n["half_gap"]),
        e.AsymmetricFriction(
            "damper", side="link", level_positive=n["level_positive"], level_negative=n["level_negative"]
        ),
        e.PreslidingFriction("damper", side="motor", level=n["presliding_level"], stiffness=n["presliding_stiffness"]),
        e.Payload(frame="drum", mass=n["drum"]),
    ]
    drive = {"gear_ratio": 1.0, "rotor_inertia": 1.0, "stiffness": n["stiffness"], "damping": n["damping"]}
    model = fd.load_model(HERE / "plain.yaml").replace(joints={"damper": drive}, effects=laws)
    return model, Bench(n["mass"], OFFSET * float(x[-1]), n["lead"])


def point_of(numbers: dict[str, float]) -> Array:
    """The point of the search that a set of numbers is at."""
    return np.append(np.log([numbers[name] for name in NUMBERS]), numbers["offset"] / OFFSET)


def numbers_of(x: Array) -> dict[str, float]:
    """The numbers of a point."""
    return dict(zip(NUMBERS, np.exp(x[:-1]).tolist(), strict=True)) | {"offset": OFFSET * float(x[-1])}


def fitted(record: fd.Recording, start: Array | None, draws: int, evaluations: int) -> Array:
    """The point of least force error over the cycles of `FIT`.

    Args:
        record: a 1 Hz file; what comes later than `FIT` is not read.
        start: point to polish; None: the best of random ones.
        draws: random points.
        evaluations: of the polish.
    """
    seen = record.trim(0.0, FIT[1])
    t, q, force = seen.t, seen["q.damper"], seen["tau.damper"]

    def cost(x: Array) -> float:
        try:
            return error(force, needed_force(*model_of(x), t, q), t, FIT)
        except fd.FlexdynError:
            return FAILED

    if start is None:
        low, high = (np.append(np.log([each[k] for each in NUMBERS.values()]), end) for k, end in ((1, -1.5), (2, 0.5)))
        points = np.random.default_rng(0).uniform(low, high, (draws, len(low)))
        start = min(points, key=cost)
    first = np.vstack([start, start + 0.1 * np.eye(len(start))])
    options = {"maxfev": evaluations, "adaptive": True, "initial_simplex": first}
    return np.asarray(minimize(cost, start, method="Nelder-Mead", options=options).x)


def main() -> None:
    """Fit all tensions, and write the numbers."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("-o", type=Path, required=True, help="the file of numbers")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    parser.add_argument("--start", type=Path, help="numbers to start from; default: random ones")
    parser.add_argument("--draws", type=int, default=1000)
    parser.add_argument("--evaluations", type=int, default=1000)
    options = parser.parse_args()
    records = read_records(options.data / "arts_damper")
    starts = {} if options.start is None else json.loads(options.start.read_text(encoding="utf-8"))
    found = {}
    for tension in TENSIONS:
        name = f"1Hz_{tension}lb"
        start = point_of(starts[name]) if name in starts else None
        found[name] = numbers_of(fitted(records[name], start, options.draws, options.evaluations))
    options.o.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
