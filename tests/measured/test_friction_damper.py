"""Force under a prescribed motion: the bench's mass, what is read off, and the right model's force, in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from damper_data import SLOW, bench_mass, computed_force, error, plain_model, read_off, read_records, without_bench

import flexdyn as fd

DATA = Path(__file__).parents[3] / "shared" / "data" / "arts_damper"
MEASURED = pytest.mark.skipif(
    not (DATA / f"brfd_{SLOW}.csv").is_file(), reason=f"{DATA} is absent: the damper's records are read there"
)
SLOPE, LEVEL, GAP, MASS = 5e6, 6000.0, 2e-3, 900.0


def record() -> fd.Recording:
    """Five cycles of 25 mm against a spring, a gap and a sliding brake without mass, on a bench that rings at 40 Hz."""
    t = np.arange(0.0, 5.0, 1.0 / 1024.0)
    x = 0.025 * np.sin(2.0 * np.pi * t) + 2e-5 * np.sin(2.0 * np.pi * 40.0 * t)
    most, wound, force = GAP + LEVEL / SLOPE, 0.0, np.empty(t.size)
    for k, dx in enumerate(np.diff(0.025 * np.sin(2.0 * np.pi * t), prepend=0.0).tolist()):
        wound = min(max(wound + dx, -most), most)
        force[k] = SLOPE * (wound - min(max(wound, -GAP), GAP))
    ringing = -2e-5 * (2.0 * np.pi * 40.0) ** 2 * np.sin(2.0 * np.pi * 40.0 * t)
    units = {"theta.damper": "m", "tau.damper": "N"}
    channels = {"theta.damper": x, "tau.damper": force + MASS * ringing}
    return fd.Recording(t, channels, meta={"prescribed": ["damper"], "units": units}, name="made")


def test_the_bench_and_what_is_read_off() -> None:
    """The mass that the ringing acts on; the slope after a reversal and the level, once that force is gone."""
    made = record()
    mass = bench_mass([made])
    assert mass == pytest.approx(MASS, rel=0.25)  # the corners of the force ring as well
    slope, level = read_off(without_bench(made, MASS))
    assert slope == pytest.approx(SLOPE, rel=0.1)
    assert level == pytest.approx(LEVEL, rel=0.02)


def test_the_force_of_the_right_model() -> None:
    """The drum is light: the force is that of a brake without mass, and the bench's; without the gap it is not."""
    made = record()
    plain = plain_model(without_bench(made, MASS))
    light = plain.replace(joints={"damper": {"stiffness": SLOPE, "damping": 5e3}}, tolerance=0.1)
    worn = light.replace(effects=[*light.effects, fd.effects.Backlash("damper", half_gap=GAP)])
    right, wrong = (error(made, computed_force(each, made, MASS), (2.0, 4.9)) for each in (worn, light))
    assert right < 0.06
    assert wrong > 3.0 * right


@MEASURED
def test_what_is_read_off_the_records() -> None:
    """The force that slides rises with the tension; the bench's mass is one of a rig, not of the drum."""
    records = read_records(DATA)
    fast = [records[f"1Hz_{each}lb"] for each in (20, 35, 80)]
    mass = bench_mass(fast)
    assert 1000.0 < mass < 1500.0
    levels = [read_off(without_bench(each, mass))[1] for each in fast]
    assert levels == pytest.approx([4160.0, 10280.0, 11750.0], rel=0.02)
