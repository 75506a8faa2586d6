"""Draw the README's picture of a measured robot: the gap, its name, the gap after.

python scripts/readme_robot.py --data ../shared/data

The second axis of the KUKA KR 300 on record B, which took no part: the torque that was measured, what the published
model needs for the motion, and what it needs with the effect that `benchmarks/measured/kuka_kr300/kuka_study.py` found;
the corrected model is the one in its results.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import matplotlib as mpl

import flexdyn as fd

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

ROOT = Path(__file__).resolve().parents[1]
STUDY = ROOT / "benchmarks" / "measured" / "kuka_kr300"
FOUND = ROOT / "benchmarks" / "results" / "kuka_kr300"
OUT = ROOT / "benchmarks" / "figures" / "measured_robot.png"
MEASURED, BEFORE, AFTER = "#222222", "#d55e00", "#0072b2"
AXIS, RECORD = 1, "B"

sys.path.insert(0, str(STUDY))
from kuka_torque import Inverse, inverse, read_records  # noqa: E402


def name_of_it() -> str:
    """The effect that was named on the axis, with its number, as the study's results have it."""
    report = json.loads(FOUND.with_suffix(".json").read_text(encoding="utf-8"))["diagnosis"]
    (found,) = [each for each in report["findings"] if each["joint"] == f"axis{AXIS + 1}"]
    numbers = ", ".join(f"{key} {x['value']:.3g} {x['unit']}" for key, x in found["parameters"].items())
    others = "".join(f" or {each['effect'].replace('_', ' ')}" for each in found["indistinguishable_from"])
    return f"{found['effect'].replace('_', ' ')}{others}: {numbers}"


def draw_torque(axes: Axes, of: Inverse, colour: str, words: str) -> None:
    """What was measured, and what a model needs."""
    axes.plot(of.t, 1e-3 * of.torque[:, AXIS], color=MEASURED, lw=1.6, label="measured")
    axes.plot(of.t, 1e-3 * (of.torque - of.missing)[:, AXIS], color=colour, lw=1.3, label=words)
    axes.set(title=f"{words}: {100 * of.error(AXIS):.0f} % of the torque is missing", ylabel="torque [kN m]")
    axes.legend(loc="lower right", fontsize=8)


def main() -> int:
    """Draw and write; without the data say so and do nothing."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    folder = parser.parse_args().data / "kuka_kr300"
    if not (folder / "recorded_B.mat").is_file():
        print(f"skipped: {folder} does not hold recorded_A.mat, recorded_B.mat, recorded_C.mat (--data)")
        return 0
    record = read_records(folder)[RECORD]
    before = inverse(fd.load_model(STUDY / "rigid.yaml"), record)
    after = inverse(fd.load_model(FOUND / "diagnosis" / "model.yaml"), record)
    plt.rcParams |= {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 11}
    figure, panels = plt.subplot_mosaic(
        [["before", "missing"], ["after", "missing"]], figsize=(10.5, 4.8), width_ratios=[1.6, 1], layout="constrained"
    )
    draw_torque(panels["before"], before, BEFORE, "published model")
    draw_torque(panels["after"], after, AFTER, "with what was found")
    panels["before"].sharex(panels["after"])
    panels["after"].set_xlabel("t [s]")
    for of, colour, words in ((before, BEFORE, "published model"), (after, AFTER, "with what was found")):
        moves = abs(of.omega[:, AXIS]) > 5e-3
        panels["missing"].plot(
            of.q[moves, AXIS], 1e-3 * of.missing[moves, AXIS], ".", ms=2.5, color=colour, label=words
        )
    panels["missing"].axhline(0.0, color=MEASURED, lw=0.6)
    panels["missing"].set(xlabel="angle of axis 2 [rad]", ylabel="missing torque [kN m]", title=name_of_it())
    panels["missing"].legend(markerscale=4, fontsize=8)
    figure.suptitle("KUKA KR 300, axis 2, a record that took no part")
    figure.savefig(OUT, dpi=150)
    return 0


if __name__ == "__main__":
    sys.exit(main())
