"""The double pendulum: its records, windows of open-loop simulation, published models."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

Array = NDArray[np.float64]
HERE = Path(__file__).parent
JOINTS = ("joint1", "joint2")
DAY = "20230629"
FIT, CHECK = ("143601", "154220"), ("143524", "154548")
RATE = 500.0
"""Of the records [Hz]; their clocks jitter, so windows are cut from resampled ones."""
SECONDS = 0.5
"""Length of a window [s]."""
REACH = 10
"""Samples to either side of a window's start from which its first state is taken."""
PUBLISHED_FRICTION: Mapping[str, tuple[float, float]] = {"joint1": (0.001, 0.16), "joint2": (0.001, 0.12)}
"""b [N m s/rad] and cf [N m] of model 1.0; cf atan(100 v) saturates at cf pi/2."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of one record, simulated open loop under the torque asked for.

    Attributes:
        t: times of the windows' samples in the record (windows, samples) [s].
        measured: positions (windows, samples, 2) [rad].
        simulated: likewise.
    """

    t: Array
    measured: Array
    simulated: Array

    @property
    def rms(self) -> Array:
        """Root mean square of the difference, joint by joint (2,) [rad]."""
        return np.asarray(np.sqrt(((self.simulated - self.measured) ** 2).mean(axis=(0, 1))))


def read_records(folder: Path) -> dict[str, fd.Recording]:
    """All four, by the time of day they were made."""
    return {
        stamp: fd.read_recording(folder / f"{DAY}-{stamp}.csv", map=HERE / "map.yaml", name=stamp)
        for stamp in sorted({*FIT, *CHECK})
    }


def published(frictionless: fd.FlexibleJointModel) -> fd.FlexibleJointModel:
    """Model 1.0 with its own friction; atan(100 v) as dry friction of the level that it saturates at."""
    effects: list[fd.effects.Effect] = []
    for joint, (b, cf) in PUBLISHED_FRICTION.items():
        effects.append(fd.effects.ViscousFriction(joint, side="motor", coefficient=b))
        effects.append(fd.effects.CoulombFriction(joint, side="motor", level=0.5 * math.pi * cf))
    return frictionless.replace(effects=effects)


@dataclass(frozen=True)
class Current:
    """How the torque that the motor's current tells follows the one asked for.

    Attributes:
        gain: slope of the one over the other [1].
        lag: at which the two agree best [s].
        left: root mean square of what the line leaves [N m].
    """

    gain: float
    lag: float
    left: float


def current(record: fd.Recording, joint: str) -> Current:
    """Of one joint, by least squares at the best of twenty lags."""
    even = record.resample(rate=RATE)
    asked, told = even[f"tau.{joint}"], even[f"tau_applied.{joint}"]
    found = []
    for late in range(20):
        columns = np.column_stack([asked[: len(asked) - late], np.ones(len(asked) - late)])
        line = np.linalg.lstsq(columns, told[late:], rcond=None)[0]
        found.append(Current(float(line[0]), late / RATE, float((told[late:] - columns @ line).std())))
    return min(found, key=lambda each: each.left)


def windows(model: fd.FlexibleJointModel, record: fd.Recording) -> Windows:
    """Cut a record into windows and simulate each from the state that was measured at its start.

    Raises:
        FlexdynError: a window could not be simulated.
    """
    even = record.resample(rate=RATE)
    q, tau = even.signal("theta", JOINTS), even.signal("tau", JOINTS)
    rows = round(SECONDS * RATE)
    firsts = range(0, len(even) - rows + 1, rows)
    states = [_first_state(q, first) for first in firsts]
    # The torque of the last sample is held to the window's end.
    t = np.arange(rows + 1) / RATE
    commands = [fd.Samples(t, np.vstack([tau[first : first + rows], tau[first + rows - 1]])) for first in firsts]
    runs = fd.simulate_many(
        [model] * len(commands), commands, q0=[q0 for q0, _ in states], v0=[v0 for _, v0 in states], rate=RATE
    )
    simulated = []
    for run in runs:
        if isinstance(run, fd.FlexdynError):
            raise run
        simulated.append(run.theta[:rows])
    measured = np.array([q[first : first + rows] for first in firsts])
    return Windows(np.array([even.t[first : first + rows] for first in firsts]), measured, np.array(simulated))


def _first_state(q: Array, row: int) -> tuple[Array, Array]:
    """Position and velocity at a row, from a cubic over the samples around it."""
    near = np.arange(max(0, row - REACH), min(len(q), row + REACH + 1))
    cubic = np.polynomial.polynomial.polyfit((near - row) / RATE, q[near], 3)
    return cubic[0], cubic[1]
