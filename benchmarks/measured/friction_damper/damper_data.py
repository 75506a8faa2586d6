"""The friction damper: its records, and the force that a model needs for a prescribed motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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
"""Times of the cycles that are fitted, of the later ones, and of those of the slow file [s]."""
CUTOFF = 80.0
"""Of the filter of the position, fourth order, forwards and backwards [Hz]: 1.5 um are 1.5 m/s^2 at 1 kHz."""
RING = 15.0
"""Above it the accelerations act on the mass of the bench [Hz]; see `Bench.mass`."""
HEAVY = 1e10
"""Of the rotor that a force of 15 kN does not disturb [kg]."""
FOLLOWS = 60.0
"""Of the controller that keeps the rotor on the record [rad/s]."""


@dataclass(frozen=True)
class Bench:
    """What stands between the damper and the sensors.

    Attributes:
        mass: force per acceleration above `RING` [kg]. It is no inertia: there is no such force at 1 Hz. A hydraulic
            actuator that yields under the force makes the same.
        offset: of the force [N].
        lead: by how much the recorded force is ahead of the recorded position [s].
    """

    mass: float
    offset: float
    lead: float


def read_records(folder: Path) -> dict[str, fd.Recording]:
    """All four files by name."""
    names = [*(f"1Hz_{each}lb" for each in TENSIONS), SLOW]
    return {name: fd.read_recording(folder / f"brfd_{name}.csv", map=HERE / "map.yaml", name=name) for name in names}


def needed_force(model: fd.FlexibleJointModel, bench: Bench, t: Array, position: Array) -> Array:
    """Force of the damper under a prescribed motion of its motor side; no measured force is read.

    The motion is given, so nothing is left to integrate there: the model gets a rotor so heavy that no force of the
    damper changes its motion, and a controller takes it along the record. What the transmission carries is the force.

    Args:
        model: elastic, with its effects.
        bench: that it is measured on.
        t: times (samples,) [s].
        position: of the actuator (samples,) [m].

    Returns:
        forces (samples,) [N].
    """
    rate = 1.0 / float(np.diff(t).mean())
    q = signal.filtfilt(*signal.butter(4, CUTOFF, fs=rate), position)
    v = np.gradient(q, t)
    a = np.gradient(v, t)
    joint = {"rotor_inertia": HEAVY}
    pushed = fd.PD(
        fd.Samples(t, q[:, None], "cubic"),
        kp=HEAVY * FOLLOWS**2,
        kd=2.0 * HEAVY * FOLLOWS,
        rate=rate,
        feedforward=fd.Samples(t, HEAVY * a[:, None], "hold"),
    )
    inside = [each for each in model.effects if each.name != "presliding_friction"]
    heavy = model.replace(joints={"damper": joint}, effects=inside)
    run = fd.simulate(heavy, pushed, q0=[float(q[0])], v0=[float(v[0])], duration=float(t[-1] - t[0]), rate=rate)
    force = run.tau_s[: len(t), 0]
    for each in model.effects:
        if isinstance(each, fd.effects.PreslidingFriction):
            force = force + each.along(q, v)
    ring = signal.filtfilt(*signal.butter(2, RING, "high", fs=rate), a)
    measured: Array = np.interp(t + bench.lead, t, force + bench.mass * ring + bench.offset)
    return measured


def error(measured: Array, force: Array, t: Array, span: tuple[float, float]) -> float:
    """Norm of the difference over that of the measured force, in a span of time [1]."""
    rows = (t >= span[0]) & (t < span[1])
    return float(np.linalg.norm((measured - force)[rows]) / np.linalg.norm(measured[rows]))


def errors(models: Mapping[str, tuple[fd.FlexibleJointModel, Bench]], records: Mapping[str, fd.Recording]) -> Errors:
    """Of the models by name of their 1 Hz file: fitted cycles, later ones, and the slow file where there is one."""
    found: Errors = {}
    for name, (model, bench) in models.items():
        record = records[name]
        force = needed_force(model, bench, record.t, record["q.damper"])
        found[name] = {
            "fitted cycles": error(record["tau.damper"], force, record.t, FIT),
            "later cycles": error(record["tau.damper"], force, record.t, LATER),
        }
        if name.endswith(SLOW.rpartition("_")[2]):
            slow = records[SLOW]
            force = needed_force(model, bench, slow.t, slow["q.damper"])
            found[name]["0.5 Hz"] = error(slow["tau.damper"], force, slow.t, SLOW_SPAN)
    return found


Errors = dict[str, dict[str, float]]
"""Force errors [1] by file and cycles."""
