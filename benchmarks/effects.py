"""What holds for every effect: energy, mirror symmetry, neutrality, agreement with SciPy.

    python benchmarks/effects.py [-o FILE.json]

Energy: the ledger of a driven run; what the effect took in it, and the least power that it took in any millisecond.
Mirror: the mirrored effect in the mirrored motion gives the mirrored run. Neutral: with neutral numbers nothing changes
in any solver, bit for bit. SciPy: the largest difference of any state from equations and laws written a second time.
Exit code 1 if a bound does not hold.
"""

from __future__ import annotations

import dataclasses
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from effect_cases import EXACT, START, TORQUE, Array, acting, arm_of, scipy_difference
from measure import Bound, arguments, conclude
from result_tables import effect_checks_table

import flexdyn as fd
from flexdyn.effects import Effect, JointEffect
from tests.effects.arms import model_of, own, states

DURATION = 1.5  # s
OTHERS: list[Effect] = [fd.effects.ViscousFriction("elbow", side="link", coefficient=0.1)]
SOLVERS = (
    fd.solvers.DormandPrince(),
    fd.solvers.RungeKutta4(step=1e-3),
    fd.solvers.Rosenbrock(),
    fd.solvers.TimeStepping(step=1e-3),
)
NEGATED = ("offset", "rest", "cos_1", "cos_2")
"""Numbers that change their sign in a mirror."""
SWAPPED = {
    "lower": "upper",
    "level_positive": "level_negative",
    "coefficient_positive": "coefficient_negative",
}
MAY_SUPPLY = ("joint_coupling",)


def measured(effect: Any) -> dict[str, Any]:
    """Everything about one effect."""
    difference, events = scipy_difference(effect)
    return {
        "side": getattr(effect, "side", None),
        "parameters": {field.name: getattr(effect, field.name) for field in effect.parameters()},
        **energy(effect),
        "mirror": mirror_difference(effect),
        "neutral": [type(solver).__name__ for solver in SOLVERS if neutral_changes_nothing(effect, solver)],
        "scipy": difference,
        "events": events,
    }


def energy(effect: Any) -> dict[str, Any]:
    """What the effect took [J], the least power it took in a millisecond [W], and what the ledger leaves over.

    The ledger's residual is relative to the largest of its entries. An effect without an entry takes nothing.
    """
    model = model_of(arm_of(effect), [effect, *OTHERS])
    run = fd.simulate(model, TORQUE, DURATION, EXACT, rate=1000.0, **START)
    ledger = run.energy
    entries = [*ledger.supplied.T, ledger.kinetic, ledger.spring, *ledger.dissipated.values()]
    turnover = max(float(np.ptp(entry)) for entry in entries)
    place = f"{effect.name}.{effect.joint}.{effect.side}" if isinstance(effect, JointEffect) else ""
    taken = ledger.dissipated.get(place)
    found: dict[str, Any] = {"ledger": float(np.abs(ledger.residual).max()) / turnover}
    if taken is not None and effect.stage != "link":
        found |= {"taken": float(taken[-1]), "least_power": float(np.diff(taken).min() / 1e-3)}
    elif taken is not None:  # an end stop's entry holds what its spring stores
        found |= {"taken": float(taken[-1]), "least_power": min(0.0, float(taken.min()))}
    return found


def mirrored(effect: Any) -> Any:
    """The effect as a mirror shows it: positions, velocities and torques negated."""
    numbers = {field.name: getattr(effect, field.name) for field in effect.parameters()}
    changed = {key: -value for key, value in numbers.items() if key in NEGATED}
    if "phase" in numbers:  # a level that swings is the same from both sides, an error or torque is not
        key = "harmonic" if effect.stage == "dry" else "phase"
        changed[key] = -numbers[key]
    for one, other in SWAPPED.items():
        if one in numbers:
            sign = -1.0 if one == "lower" else 1.0
            changed |= {one: sign * numbers[other], other: sign * numbers[one]}
    return dataclasses.replace(effect, **changed)


def mirror_difference(effect: Any) -> float:
    """Largest sum of a channel and its mirror image [rad, rad/s, N m]."""
    arm = arm_of(effect)
    runs = [
        fd.simulate(
            model_of(arm, [each, *OTHERS]),
            sign * np.array(TORQUE),
            DURATION,
            EXACT,
            rate=200.0,
            q0=sign * np.array(START["q0"]),
            v0=sign * np.array(START["v0"]),
        )
        for sign, each in ((1.0, effect), (-1.0, mirrored(effect)))
    ]
    one, two = (run.to_recording() for run in runs)
    return max(float(np.abs(one[channel] + two[channel]).max()) for channel in one.channels)


def neutral_changes_nothing(effect: Any, solver: fd.solvers.Solver) -> bool:
    """Whether run, statistics and recording are the same, bit for bit, with the neutral effect and without it."""
    neutral = dataclasses.replace(effect, **effect.neutral)
    one, two = (
        fd.simulate(model_of(arm_of(effect), effects), TORQUE, 0.3, solver, rate=200.0, **START)
        for effects in (OTHERS, [neutral, *OTHERS])
    )
    same = _bits(states(one)) == _bits(states(two)) and dict(one.stats) == dict(two.stats)
    return bool(same and one.to_recording().same_as(two.to_recording()))


def _bits(array: Array) -> bytes:
    return np.ascontiguousarray(array).tobytes()


def bounds(effects: dict[str, Any]) -> list[Bound]:
    """What every effect promises."""
    found = []
    for name, row in effects.items():
        found.append(Bound(f"{name}: difference from SciPy", row["scipy"], 1e-6))
        found.append(Bound(f"{name}: mirror", row["mirror"], 1e-9))
        found.append(Bound(f"{name}: residual of the ledger", row["ledger"], 1e-8))
        found.append(Bound(f"{name}: solvers in which its neutral form acts", len(SOLVERS) - len(row["neutral"]), 0))
        if "least_power" in row and name not in MAY_SUPPLY:
            found.append(Bound(f"{name}: power supplied [W]", -row["least_power"], 1e-9))
    return found


def main() -> int:
    """Measure, print, write; 1 if a bound does not hold."""
    parser = arguments(__doc__)
    options = parser.parse_args()
    warnings.simplefilter("error", fd.EnergyWarning)  # a ledger that does not close would warn
    rows = {name: measured(acting(kind)) for name, kind in fd.effects.catalogue().items() if own(kind)}
    results = {"solvers": [type(solver).__name__ for solver in SOLVERS], "effects": rows}
    print(effect_checks_table(results), end="\n\n")
    held = bounds(rows)
    return conclude(held, options.output, "python benchmarks/effects.py", results)


if __name__ == "__main__":
    sys.exit(main())
