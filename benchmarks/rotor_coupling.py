"""When does the reduced model fail? Reduced against full rotor coupling over gear ratios, at the same reflected J.

The reduced model leaves out what a rotor's spin does to the links that carry it, terms of size J/N beside M. So the
question is one of the gear ratio alone: the springs and J = N^2 times the rotor's inertia stay what they are.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from numpy.typing import NDArray
from result_tables import markdown_table

import flexdyn as fd

Array = NDArray[np.float64]
RATIOS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
ARMS = ("scara_two_link", "ur5")
MODES = 3
SOLVER = fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12)


def plain(name: str) -> fd.FlexibleJointModel:
    """A shipped model with its springs, dampers and payload alone: nothing hides the coupling."""
    model = fd.load_model(name)
    payloads = [effect for effect in model.effects if isinstance(effect, fd.effects.Payload)]
    return model.replace(effects=payloads, urdf_dynamics="ignore")


def geared(model: fd.FlexibleJointModel, ratio: float, coupling: str) -> fd.FlexibleJointModel:
    """The model with every gear ratio N and every reflected J as it was."""
    gears = {
        name: {"gear_ratio": ratio, "rotor_inertia": joint.reflected_inertia / ratio**2}
        for name, joint in model.joints.items()
    }
    return model.replace(joints=gears, rotor_coupling=coupling)


def frequencies(model: fd.FlexibleJointModel) -> Array:
    """The first vibrations with free rotors (MODES,) [Hz]; what gravity makes fall is no vibration."""
    found = fd.modes(model)
    vibrates = np.array([kind == "vibration" for kind in found.kinds])
    return np.asarray(found.frequencies[vibrates][:MODES])


def motion(model: fd.FlexibleJointModel) -> Array:
    """Link positions over 1 s (101, n) [rad]: from rest, torques that alone would give each rotor 1 or -1 rad/s^2."""
    q = np.array([model.initial.get("q", {}).get(joint, 0.0) for joint in model.joint_names])
    weight = fd.LinkSide(model).bias(q, np.zeros(model.n))
    push = np.where(np.arange(model.n) % 2, -1.0, 1.0) * model.rotor_inertia
    return fd.simulate(model, weight + push, 1.0, SOLVER, theta0="equilibrium", rate=100).q


def compare(model: fd.FlexibleJointModel, ratio: float) -> dict[str, Any]:
    """What the reduction changes at one gear ratio; `refused` where no arm could be built like that."""
    reduced = geared(model, ratio, "reduced")
    try:
        full = geared(model, ratio, "full")
        gap = np.abs(frequencies(reduced) / frequencies(full) - 1.0)
        moved = [motion(each) for each in (full, reduced)]
    except fd.InputError as problem:
        return {"ratio": ratio, "refused": problem.problem}
    error = np.abs(moved[0] - moved[1]).max()
    return {
        "ratio": ratio,
        "frequency_errors": [float(f"{each:.3g}") for each in gap],
        "motion_error_rad": float(f"{error:.3g}"),
        "motion_range_rad": float(f"{np.ptp(moved[0], axis=0).max():.3g}"),
    }


def table(arms: Mapping[str, list[dict[str, Any]]]) -> str:
    """A row for each gear ratio."""
    parts = ["greatest error of the first frequencies (at most 3)", "of 1 s of motion / its range"]
    header = ["gear ratio", *(f"{name}: {part}" for name in arms for part in parts)]
    rows = []
    for k, ratio in enumerate(RATIOS):
        row = [f"{ratio:g}"]
        for cases in arms.values():
            case = cases[k]
            if "refused" in case:
                row += ["impossible", "impossible"]
                continue
            row.append(f"{max(case['frequency_errors']):.2%}")
            row.append(f"{case['motion_error_rad'] / case['motion_range_rad']:.2%}")
        rows.append(row)
    return markdown_table(header, rows, text=0)


def bounds(arms: Mapping[str, list[dict[str, Any]]]) -> list[Bound]:
    """With a gear of 100 or more the difference falls like 1/N: twice the ratio, half the error."""
    held = []
    for name, cases in arms.items():
        coarse, fine = (max(case["frequency_errors"]) for case in cases[-2:])
        held.append(Bound(f"{name}: |error at N = 100 / error at 200 - 2|", abs(coarse / fine - 2.0), 0.2))
    return held


def main() -> int:
    """Compare, print, write; 1 if a bound does not hold."""
    parser = arguments(__doc__)
    options = parser.parse_args()
    arms = {name: [compare(plain(name), ratio) for ratio in RATIOS] for name in ARMS}
    print(table(arms), end="\n\n")
    held = bounds(arms)
    return conclude(held, options.output, "python benchmarks/rotor_coupling.py", {"arms": arms})


if __name__ == "__main__":
    sys.exit(main())
