"""Draw the README's picture of a measured robot: the gap, its name, the gap after.

python scripts/readme_robot.py --data ../shared/data

The double pendulum on record 143524, which took no part: windows of half a second, driven by the torque asked for, with
the published model without friction and with what `benchmarks/measured/double_pendulum/pendulum_study.py` found; the
corrected model is the one in its results.
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
STUDY = ROOT / "benchmarks" / "measured" / "double_pendulum"
FOUND = ROOT / "benchmarks" / "results" / "double_pendulum"
OUT = ROOT / "benchmarks" / "figures" / "measured_robot.png"
MEASURED, BEFORE, AFTER = "#222222", "#d55e00", "#0072b2"

sys.path.insert(0, str(STUDY))
from pendulum_data import CHECK, JOINTS, Windows, read_records, windows  # noqa: E402


def name_of_it(joint: str) -> str:
    """What was named at a joint, with its number, as the study's results have it."""
    report = json.loads(FOUND.with_suffix(".json").read_text(encoding="utf-8"))["diagnosis"]
    found = [each for each in report["findings"] if each["joint"] == joint]
    names = [
        f"{each['effect'].replace('_', ' ')}, "
        + ", ".join(f"{key} {x['value']:.2g} {x['unit']}" for key, x in each["parameters"].items())
        for each in found
    ]
    return " and ".join(names) or "nothing named"


def draw(axes: Axes, of: Windows, j: int, colour: str, words: str) -> None:
    """A model's windows at one joint over what was measured."""
    for k, t in enumerate(of.t):
        label = f"{words}: {of.rms[j]:.3f} rad" if k == 0 else None
        axes.plot(t, of.simulated[k, :, j], color=colour, lw=1.2, label=label)


def main() -> int:
    """Draw and write; without the data say so and do nothing."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the measured data")
    folder = parser.parse_args().data / "dfki_double_pendulum"
    if not folder.is_dir():
        print(f"skipped: there is no {folder} (--data)")
        return 0
    record = read_records(folder)[CHECK[0]]
    before = windows(fd.load_model(STUDY / "frictionless.yaml"), record)
    after = windows(fd.load_model(FOUND / "diagnosis" / "model.yaml"), record)
    plt.rcParams |= {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 11}
    figure, panels = plt.subplots(len(JOINTS), 1, figsize=(10.5, 5.4), sharex=True, layout="constrained")
    for j, (joint, axes) in enumerate(zip(JOINTS, panels, strict=True)):
        draw(axes, before, j, BEFORE, "published model without friction")
        draw(axes, after, j, AFTER, "with what was found")
        for k, t in enumerate(after.t):
            axes.plot(t, after.measured[k, :, j], color=MEASURED, lw=1.2, ls=":", label="" if k else "measured")
        low, high = after.measured[:, :, j].min(), after.measured[:, :, j].max()
        margin = 0.35 * (high - low)
        axes.set(
            ylabel=f"{joint} [rad]", ylim=(low - margin, high + 2.0 * margin), title=f"{joint}: {name_of_it(joint)}"
        )
        axes.legend(loc="upper left", ncols=3, fontsize=8)
    panels[-1].set_xlabel("t [s]")
    figure.savefig(OUT, dpi=150)
    return 0


if __name__ == "__main__":
    sys.exit(main())
