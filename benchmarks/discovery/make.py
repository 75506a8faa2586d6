"""Make cases: a model file, a URDF and two recordings each, and the truth in a folder of its own.

    python benchmarks/discovery/make.py --family single --seed 3 --count 20 -o DIR

writes DIR/<case>/{model.yaml,arm.urdf,fit.npz,check.npz} and DIR.truth/<case>.json. Families: see cases.py.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from cases import CHECK, FAMILIES, FIT, make_case, sensors_of, truth_columns
from model_text import model_yaml, urdf
from recording import Sensors
from wide import SUFFIX, split

SIX = "six"
PUBLISHED, PUBLISHED_SIX = "published", "published_six"
ALL = (*FAMILIES, SIX, PUBLISHED, PUBLISHED_SIX)


def build(family: str, seed: int, number: int, fit: float, check: float, sensors: Sensors) -> dict[str, Any]:
    """Name, files, recordings and truth of one case."""
    if split(family)[0] == SIX:
        from six_cases import make_six

        return make_six(seed, number, fit, check, sensors, wider=split(family)[1])
    if family == PUBLISHED:
        from published import make_published

        return make_published(seed, number, fit, check)
    if family == PUBLISHED_SIX:
        from published_six import make_published_six

        return make_published_six(seed, number, fit, check)
    case = make_case(family, seed, number, fit, check, sensors)
    truth = {
        "case": case.name,
        "family": family,
        "seed": seed,
        "number": number,
        "fit": fit,
        "check": check,
        "hidden": [one.to_dict() for one in case.hidden],
        "arm": dataclasses.asdict(case.arm),
        "given": dataclasses.asdict(case.given),
        "sensors": dataclasses.asdict(case.sensors),
        "tolerance": case.tolerance,
        "scale": truth_columns(case),
    }
    files = {"model.yaml": model_yaml(case.given, case.tolerance), "arm.urdf": urdf(case.given)}
    return {"name": case.name, "files": files, "recordings": case.recordings, "truth": truth}


def ending(family: str, wide: bool) -> str:
    """The family from the wider ranges, where it has any: published robots vary enough."""
    return f"{family}{SUFFIX}" if wide and not family.startswith(PUBLISHED) else family


def write_case(case: dict[str, Any], folder: Path) -> Path:
    """Write a case below a folder; the truth goes beside it. The case's own folder."""
    name = str(case["name"])
    place, secret = folder / name, folder.parent / f"{folder.name}.truth"
    place.mkdir(parents=True, exist_ok=True)
    secret.mkdir(parents=True, exist_ok=True)
    for file, text in case["files"].items():
        (place / file).write_text(text, encoding="utf-8")
    for part, channels in case["recordings"].items():
        np.savez(place / f"{part}.npz", **channels)
    (secret / f"{name}.json").write_text(json.dumps(case["truth"], indent=1) + "\n", encoding="utf-8")
    return place


def main() -> int:
    """Make the cases that were asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--family", choices=ALL, default="single")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--fit", type=float, default=FIT, help="[s]")
    parser.add_argument("--check", type=float, default=CHECK, help="[s]")
    parser.add_argument("--wide", action="store_true", help="draw from wider ranges (wide.py)")
    parser.add_argument("--velocities", action="store_true", help="record v and omega")
    parser.add_argument("--torque-sensor", action="store_true", help="record tau_s")
    parser.add_argument("--joint-turn", action="store_true", help="17 bit per turn of the joint, not of the motor")
    parser.add_argument("--actuator-noise", action="store_true", help="torque noise in the motor, not in the recording")
    parser.add_argument("-o", "--output", type=Path, required=True)
    o = parser.parse_args()
    sensors = dataclasses.replace(
        sensors_of(o.family),
        velocities=o.velocities,
        torque_sensor=o.torque_sensor,
        actuator_noise=o.actuator_noise,
        motor_bits_per_turn_of="joint" if o.joint_turn else "motor",
    )
    family = ending(o.family, o.wide)
    for number in range(o.first, o.first + o.count):
        place = write_case(build(family, o.seed, number, o.fit, o.check, sensors), o.output)
        print(place, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
