"""A published robot of seven joints: the Panda's URDF without friction, diagnosed from motors' encoders and torques.

    python benchmarks/published_panda.py [--count 2] [--seed 1] [--keep DIR] [-o FILE.json]

The truth is `panda_truth.py`: Pinocchio's inertias, each off by up to 5 %, and friction that sticks on every joint. Two
joints have a Stribeck curve, one or two have friction that grows with the load. The model file has the URDF, no
friction, rotors off by a factor of up to 1.5, and rigid joints. Encoders count 17 bits in a turn of the joint; each
sample of a torque has noise. The diagnosis is the program, in a folder without the truth.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from measure import Bound, arguments, conclude
from panda_truth import ROTOR, Friction, recorded, true_arm

from flexdyn.robot.names import find_robot

LINKS_OFF, ROTORS_OFF = 0.05, 1.5
NOISE = np.array([0.1, 0.12, 0.1, 0.1, 0.03, 0.03, 0.02])  # N m
COULOMB = np.array([1.2, 1.5, 0.9, 1.1, 0.5, 0.4, 0.35])  # N m
VISCOUS = np.array([2.0, 1.8, 1.5, 1.3, 0.6, 0.5, 0.4])  # N m s/rad
COUNT = 2.0 * np.pi / 2**17  # rad
FIT, CHECK = 30.0, 12.0  # s
JOINTS = [f"panda_joint{k}" for k in range(1, 8)]


def main() -> int:
    """Make, diagnose and score the cases."""
    parser = arguments(__doc__)
    parser.add_argument("--count", type=int, default=2, help="cases")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="keep cases and reports in this folder")
    o = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        place = o.keep or Path(scratch)
        cases = [_case(place / f"panda_{o.seed}_{k}", np.random.default_rng((o.seed, k))) for k in range(o.count)]
    print(*(json.dumps(case) for case in cases), sep="\n")
    found, wanted = (sum(case[key] for case in cases) for key in ("found", "wanted"))
    bounds = [
        Bound("false names", float(sum(len(case["false"]) for case in cases)), 0.0),
        Bound("share of the effects that were not found", 1.0 - found / wanted, 0.1),
    ]
    command = f"python benchmarks/published_panda.py --count {o.count} --seed {o.seed}"
    return conclude(bounds, o.output, command, {"cases": cases})


def _case(folder: Path, rng: np.random.Generator) -> dict[str, Any]:
    """One arm: its files, what the program says, and the score."""
    folder.mkdir(parents=True, exist_ok=True)
    friction, stribeck, loaded = _friction(rng)
    arm = true_arm(find_robot("panda")[0], rng, LINKS_OFF)
    for name, seconds in (("fit", FIT), ("check", CHECK)):
        t, q, tau = recorded(arm, friction, seconds, rng)
        theta, noisy = np.floor(q / COUNT) * COUNT, tau + NOISE * rng.normal(size=tau.shape)
        columns: dict[str, Any] = {"t": t}
        columns |= {f"theta.{joint}": theta[:, j] for j, joint in enumerate(JOINTS)}
        columns |= {f"tau.{joint}": noisy[:, j] for j, joint in enumerate(JOINTS)}
        np.savez(folder / f"{name}.npz", **columns)
    (folder / "model.yaml").write_text(_model(rng), encoding="utf-8")
    report, cost = _diagnosed(folder)
    hidden = {(kind, joint) for joint in JOINTS for kind in ("coulomb_friction", "viscous_friction")}
    hidden |= {("stribeck_friction", JOINTS[j]) for j in stribeck}
    hidden |= {("load_dependent_friction", JOINTS[j]) for j in loaded}
    return _score(report, hidden) | cost


def _friction(rng: np.random.Generator) -> tuple[Friction, list[int], list[int]]:
    """Friction, and the joints with Stribeck curves and with friction that grows with the load."""
    coulomb, excess, load = COULOMB * rng.uniform(0.7, 1.4, 7), np.zeros(7), np.zeros(7)
    stribeck = sorted(rng.choice(7, 2, replace=False).tolist())
    loaded = sorted(rng.choice([1, 3], rng.integers(1, 3), replace=False).tolist())  # joints that carry weight
    excess[stribeck] = rng.uniform(0.3, 0.6, 2) * coulomb[stribeck]
    load[loaded] = rng.uniform(0.02, 0.05, len(loaded))
    shape = rng.uniform(0.05, 0.1, 7), rng.uniform(1.0, 2.0, 7)
    return Friction(coulomb, VISCOUS * rng.uniform(0.5, 1.5, 7), excess, *shape, load), stribeck, loaded


def _model(rng: np.random.Generator) -> str:
    """The model file: the URDF, guessed rotors, rigid joints, no friction."""
    rotors = ROTOR / 1e4 * np.exp(rng.uniform(-1.0, 1.0, 7) * np.log(ROTORS_OFF))
    joints = [
        f"  {joint}: {{gear_ratio: 100.0, rotor_inertia: {rotor:.5g}, stiffness: .inf, damping: 0.0}}"
        for joint, rotor in zip(JOINTS, rotors, strict=True)
    ]
    head = [
        "flexdyn: 1",
        "robot:",
        "  urdf: panda",
        "  gravity: [0.0, 0.0, -9.81]",
        "  lock: {panda_finger_joint1: 0.0}",
    ]
    tail = ['tolerance: {"joints.*.rotor_inertia": 0.5, "*": 0.05}', "effects: []"]
    return "\n".join([*head, "  urdf_dynamics: ignore", "joints:", *joints, *tail]) + "\n"


def _diagnosed(folder: Path) -> tuple[dict[str, Any], dict[str, float]]:
    """The report of the program, and what it cost."""
    program = str(Path(sys.executable).with_name("flexdyn"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "diagnose", "model.yaml", "fit.npz", "--check", "check.npz", "-o", "report"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    report: dict[str, Any] = json.loads((folder / "report" / "report.json").read_text("utf-8"))
    return report, {"seconds": round(seconds, 1), "memory_mb": round(after.ru_maxrss / 1024)}


def _score(report: dict[str, Any], hidden: set[tuple[str, str]]) -> dict[str, Any]:
    """Effects found, half a point for an "A or B" that holds one; names that are not hidden are false."""
    found, false = 0.0, []
    for finding in report["findings"]:
        names = [(each["effect"], each["joint"]) for each in (finding, *finding["indistinguishable_from"])]
        true = [name for name in names if name in hidden]
        found += (1.0 if len(names) == 1 else 0.5) if true else 0.0
        if not true:
            false.append(" or ".join(f"{effect} {joint}" for effect, joint in names))
    gap = report["gap"]["test"]
    return {
        "verdict": report["verdict"],
        "found": found,
        "wanted": len(hidden),
        "false": false,
        "gap": {key: round(gap[key], 2) for key in ("before", "after", "floor")},
    }


if __name__ == "__main__":
    sys.exit(main())
