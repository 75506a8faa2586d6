"""The friction damper: its records, and what the bench adds to their force."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

import flexdyn as fd

Array = NDArray[np.float64]
HERE = Path(__file__).parent
TENSIONS = (20, 35, 80)
"""Of the band [lb]."""
SLOW = "0.5Hz_20lb"
"""The file at half the frequency; it takes no part in any fit."""
FIT, LATER, SLOW_SPAN = (2.0, 5.0), (5.0, 8.0), (3.0, 13.0)
"""Times of the full cycles, which are fitted, of the later ones, and of those of the slow file [s]; the errors of LuGre
are for the same spans."""
CUTOFF = 80.0
"""Of the filter of the position, fourth order, forwards and backwards [Hz]: 1.5 um are 1.5 m/s^2 at 1 kHz."""
RING = 15.0
"""Above it the accelerations act on the mass of the bench [Hz]; see `bench_mass`."""


def read_records(folder: Path) -> dict[str, fd.Recording]:
    """All four files by name."""
    names = [*(f"1Hz_{each}lb" for each in TENSIONS), SLOW]
    return {name: fd.read_recording(folder / f"brfd_{name}.csv", map=HERE / "map.yaml", name=name) for name in names}


def ringing(record: fd.Recording) -> Array:
    """Acceleration of the actuator above `RING` (samples,) [m/s^2]."""
    rate = record.rate
    x = signal.filtfilt(*signal.butter(4, CUTOFF, fs=rate), record["theta.damper"])
    a = np.gradient(np.gradient(x, record.t), record.t)
    return np.asarray(signal.filtfilt(*signal.butter(2, RING, "high", fs=rate), a))


def bench_mass(records: Iterable[fd.Recording]) -> float:
    """Force per acceleration above `RING` [kg], one for all files, by least squares over their cycles of `FIT`.

    It is no inertia of the damper: there is no such force at 0.5 and 1 Hz. The published force seems to be corrected
    for the inertia that the rig's moving parts have in the sine that was commanded, and not for that of their ringing.
    """
    up = down = 0.0
    for record in records:
        rows = (record.t >= FIT[0]) & (record.t < FIT[1])
        high = signal.filtfilt(*signal.butter(2, RING, "high", fs=record.rate), record["tau.damper"])
        a = ringing(record)
        up, down = up + float(high[rows] @ a[rows]), down + float(a[rows] @ a[rows])
    return up / down


def without_bench(record: fd.Recording, mass: float) -> fd.Recording:
    """The record with the force of the bench's mass taken off."""
    force = record["tau.damper"] - mass * ringing(record)
    return fd.Recording(
        record.t, {"theta.damper": record["theta.damper"], "tau.damper": force}, meta=record.meta, name=record.name
    )


def distance(record: fd.Recording) -> tuple[Array, NDArray[np.intp]]:
    """Distance since the last reversal (samples,) [m], and the samples of the reversals beyond 15 mm within `FIT`."""
    x = signal.filtfilt(*signal.butter(4, CUTOFF, fs=record.rate), record["theta.damper"])
    u = np.gradient(x)
    turns = np.concatenate([[True], u[1:] * u[:-1] < 0.0])
    last = np.maximum.accumulate(np.where(turns, np.arange(len(x)), 0))
    wide = turns & (np.abs(x) > 0.015) & (record.t >= FIT[0]) & (record.t < FIT[1])
    return np.abs(x - x[last]), np.flatnonzero(wide)


def read_off(record: fd.Recording) -> tuple[float, float]:
    """What one reads off the force: the slope after a reversal [N/m], and its size while it slides [N].

    The slope is the mean of straight lines through the force between 80 and 30 % of what it was at the reversal; the
    other is the median size of the force more than 25 mm behind one.
    """
    since, turns = distance(record)
    force = record["tau.damper"]
    slopes = []
    for k in turns:
        share = force[k:] / force[k]
        first, end = (int(np.argmax(share < level)) for level in (0.8, 0.3))
        rows = slice(k + first, k + end)
        slopes.append(abs(np.polyfit(since[rows], force[rows], 1)[0]))
    slides = (record.t >= FIT[0]) & (record.t < FIT[1]) & (since > 0.025)
    return float(np.mean(slopes)), float(np.median(np.abs(force[slides])))


def plain_model(record: fd.Recording) -> fd.FlexibleJointModel:
    """The damper as one would describe it before its diagnosis, with the two numbers that one reads off."""
    slope, level = read_off(record)
    model = fd.load_model(HERE / "plain.yaml")
    (friction,) = model.effects
    levels = friction.replace(level_positive=level, level_negative=level)
    return model.replace(joints={"damper": {"stiffness": slope}}, effects=[levels])


def computed_force(model: fd.FlexibleJointModel, record: fd.Recording, mass: float) -> Array:
    """Force of a model and of the bench's mass at the record's times (samples,) [N]; NaN at its ends."""
    found = fd.prescribed_forces(model, record)
    force = np.interp(record.t, found.t, found["tau.damper"], left=np.nan, right=np.nan)
    return np.asarray(force + mass * ringing(record))


def error(record: fd.Recording, force: Array, span: tuple[float, float]) -> float:
    """Norm of computed less recorded force over that of the recorded one, in a span of time [1]."""
    rows = (record.t >= span[0]) & (record.t < span[1]) & np.isfinite(force)
    measured = record["tau.damper"]
    return float(np.linalg.norm((measured - force)[rows]) / np.linalg.norm(measured[rows]))


def errors(models: Mapping[str, fd.FlexibleJointModel], records: Mapping[str, fd.Recording], mass: float) -> Errors:
    """Of the models by name of their 1 Hz file: full cycles of the fit, later ones, the slow file if there is one."""
    found: Errors = {}
    for name, model in models.items():
        force = computed_force(model, records[name], mass)
        found[name] = {key: error(records[name], force, span) for key, span in (("fit", FIT), ("later cycles", LATER))}
        if name.endswith(SLOW.rpartition("_")[2]):
            slow = records[SLOW]
            found[name]["0.5 Hz"] = error(slow, computed_force(model, slow, mass), SLOW_SPAN)
    return found


Errors = dict[str, dict[str, float]]
"""Force errors [1] by file and cycles."""
