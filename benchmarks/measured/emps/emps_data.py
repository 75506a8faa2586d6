"""EMPS: its records, its controller around a model, and force errors as the authors take them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.motion import motion
from flexdyn.diagnose.equations.smoothed import Smoothed
from flexdyn.diagnose.equations.terms import joint_terms

Array = NDArray[np.float64]
HERE = Path(__file__).parent
NAMES = ("DATA_EMPS", "PULSES")
"""Of the records: the one to fit, the one to check."""
FORCE_CONSTANT = 35.15065188248547
"""Of the drive, gtau [N/V]."""
POSITION_GAIN = 160.18
"""kp [1/s]."""
VELOCITY_GAIN = 243.45 * FORCE_CONSTANT
"""kv [V s/m] as force [N s/m]."""
LIMIT = 10.0 * FORCE_CONSTANT
"""The controller's output is cut at 10 V [N]."""
RATE = 1000.0
"""Of controller and record [Hz]."""
CUTOFF, DECIMATION = 100.0, 10
"""Of the authors' filter: Butterworth, fourth order, forwards and backwards [Hz], and one row kept of so many."""
ENDS = 50
"""Samples at either end that the filter spoils."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A record and the model's answer to the same reference, the controller in the loop.

    Attributes:
        t: times [s].
        force: measured and simulated (samples, 2) [N].
        position: likewise [m].
    """

    t: Array
    force: Array
    position: Array

    @property
    def force_error(self) -> float:
        """Norm of the difference over that of the measured force [1]."""
        return relative(*self.force.T)

    @property
    def position_error(self) -> float:
        """The same of the positions [1]."""
        return relative(*self.position.T)


def relative(measured: Array, other: Array) -> float:
    """Norm of a difference over that of what was measured [1]."""
    return float(np.linalg.norm(measured - other) / np.linalg.norm(measured))


def read_records(folder: Path) -> dict[str, fd.Recording]:
    """The estimation record and the one with pulses, by name."""
    files = (("DATA_EMPS.mat", "map.yaml"), ("DATA_EMPS_PULSES.mat", "map_pulses.yaml"))
    both = zip(NAMES, files, strict=True)
    return {name: fd.read_recording(folder / file, map=HERE / ready, name=name) for name, (file, ready) in both}


def published(plain: fd.FlexibleJointModel) -> fd.FlexibleJointModel:
    """The report's first model: mass, viscous and dry friction, offset."""
    dry = fd.effects.CoulombFriction("carriage", side="motor", level=20.3935)
    return plain.replace(effects=[*plain.effects, dry, fd.effects.TorqueOffset("carriage", offset=3.1648)])


def servo(record: fd.Recording, delay: int = 0) -> fd.Servo:
    """The published controller with a record's reference; pulses come in behind its limit."""
    pulses = fd.Samples(record.t, record["pulses.carriage"]) if "pulses.carriage" in record else None
    return fd.Servo(
        reference=record,
        position_gain=POSITION_GAIN,
        velocity_gain=VELOCITY_GAIN,
        span=2,
        limit=LIMIT,
        delay=delay,
        added=pulses,
    )


def closed_loop(model: fd.FlexibleJointModel, record: fd.Recording, delay: int = 0) -> Loop:
    """The model under the published controller, from the record's first position and velocity."""
    first = slice(0, 8)
    slope = np.polyfit(record.t[first], record["theta.carriage"][first], 2)
    start = float(record["theta.carriage"][0])
    # The run is sampled at the controller's ticks; the record's clock strays from them by less than 1 us.
    run = fd.simulate(model, servo(record, delay), q0=[start], v0=[float(slope[1])], rate=RATE)
    rows = slice(0, len(record))
    force = np.column_stack([record["tau.carriage"], run.tau[rows, 0]])
    return Loop(record.t, force, np.column_stack([record["theta.carriage"], run.theta[rows, 0]]))


def replayed_controller(record: fd.Recording, delay: int = 0) -> float:
    """Error of the published controller's law along the measured positions against the recorded output [1].

    It says whether the recorded voltage is late against the positions in the same row.
    """
    q = record["theta.carriage"]
    speed = np.zeros_like(q)
    speed[2:] = (q[2:] - q[:-2]) / 2e-3
    asked = np.roll(VELOCITY_GAIN * (POSITION_GAIN * (record["reference.carriage"] - q) - speed), delay)
    added = record["pulses.carriage"] if "pulses.carriage" in record else np.zeros_like(q)
    rows = slice(ENDS, -ENDS)
    return relative(record["tau.carriage"][rows], (asked + added)[rows])


@dataclass(frozen=True, eq=False)
class Inverse:
    """Force that a model needs for the measured motion, in the authors' way.

    Attributes:
        q: position [m].
        v: velocity [m/s].
        force: measured (rows,) [N].
        missing: measured - needed (rows,) [N].
    """

    q: Array
    v: Array
    force: Array
    missing: Array

    @property
    def error(self) -> float:
        """Norm of what is missing over that of the force [1]."""
        return float(np.linalg.norm(self.missing) / np.linalg.norm(self.force))


def inverse(model: fd.FlexibleJointModel, record: fd.Recording) -> Inverse:
    """Butterworth on the position, central differences, the model's force, everything decimated."""
    true, data = model.resolved(), measured(model, record)
    q, v, a = _motion(data.theta, data.dt)
    rests = np.zeros(q.shape, dtype=np.bool_)
    still = np.zeros_like(q)
    seen = Smoothed(
        data.t, data.dt, q, v, a, q, v, a, data.tau, still, data, 0, rests, held=None, kernel=None, passes=0, wound=None
    )
    along = motion(fd.LinkSide(true), seen)
    terms = joint_terms(true, true.all_effects, along, 0)
    missing = terms.motor + terms.link - along.inverse_dynamics[:, 0]
    return Inverse(*(_decimated(each) for each in (q[:, 0], v[:, 0], data.tau[:, 0], missing)))


def least_squares(fit: fd.Recording, others: Sequence[fd.Recording]) -> list[float]:
    """Force errors of mass, viscous and dry friction of either direction, by numpy alone: what is within reach [1].

    Args:
        fit: record that they are fitted to.
        others: records whose errors are wanted.
    """

    def columns(record: fd.Recording) -> Array:
        _, v, a = _motion(record["theta.carriage"], 1.0 / RATE)
        up = (v > 0.0).astype(float)
        return np.column_stack([_decimated(each) for each in (a, v * up, up, v * (1.0 - up), up - 1.0)])

    def force(record: fd.Recording) -> Array:
        return _decimated(record["tau.carriage"])

    fitted = np.linalg.lstsq(columns(fit), force(fit), rcond=None)[0]
    return [relative(force(each), columns(each) @ fitted) for each in others]


def _motion(x: Array, dt: float) -> tuple[Array, Array, Array]:
    """Position behind the filter, velocity and acceleration, in the shape of x (samples, ...)."""
    q = signal.filtfilt(*signal.butter(4, CUTOFF, fs=1.0 / dt), x, axis=0)
    v = np.gradient(q, dt, axis=0)
    return q, v, np.gradient(v, dt, axis=0)


def _decimated(x: Array) -> Array:
    return np.asarray(signal.decimate(x[ENDS:-ENDS], DECIMATION))
