"""The goal of a command: the path to be tracked, and the time at which the command comes to rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.control.samples import Samples
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.run import Run

AIM_END = 1e-9
"""A change of the command later than this share of the run before its end is ignored: it has no time to act [1]."""
LATEST = 0.95
"""A command that still changes after this share of the run does not come to rest within the run [1]."""


@dataclass(frozen=True, eq=False)
class Aim:
    """Properties of a command that metrics need; the same for all runs of a study.

    Attributes:
        rest: time from which on the torque or the reference of the command no longer changes [s from the start of the
            run]; None: it does not come to rest within the run.
        reference: positions to be tracked, one column for each joint; None if the command is torques over time.
    """

    rest: float | None
    reference: Samples | None = None

    def wanted(self, t: Array) -> Array:
        """The reference at times of a run (samples, n) [rad or m]; after its end it keeps its last value.

        Raises:
            ValueError: there is no reference.
        """
        if self.reference is None:
            raise ValueError("there is no reference to track")
        return self.reference.at(t, self.reference.values)


def aim_of(command: Any, model: FlexibleJointModel, duration: float) -> Aim:
    """Determine the properties of a command.

    Args:
        command: as for `flexdyn.simulate`.
        model: the arm.
        duration: of the run [s].

    Raises:
        InputError: a recording or reference that does not fit the model.
    """
    drive = make_drive(model, command, duration)
    if drive.reference is not None:
        held = drive.reference.interpolation == "hold"
        return Aim(_still(drive.reference.t, drive.reference.values, duration, held), drive.reference)
    return Aim(_played_out(drive.samples, duration) if drive.controller is None else None)


def aim_of_run(run: Run) -> Aim:
    """The properties that a run alone determines: from its torques, or a controller's ticks; there is no reference."""
    return Aim(_played_out(run.inputs.samples, run.inputs.duration))


def _played_out(torques: Samples | None, duration: float) -> float | None:
    """Time of the last change of the torques; at their end they fall to zero."""
    if torques is None:
        return 0.0
    held = torques.interpolation == "hold"
    rows = torques.values.copy()
    if held:
        rows[-1] = 0.0  # the last row of held torques never acts
    rest = _still(torques.t, rows, duration, held)
    end = torques.duration
    return max(rest, end) if rest is not None and rows[-1].any() and end < LATEST * duration else rest


def _still(t: Array, rows: Array, duration: float, held: bool) -> float | None:
    """Time from which on rows no longer change; held rows change at a sample, interpolated ones until the sample."""
    changed = np.append(False, (rows[1:] != rows[:-1]).any(axis=1))
    end = duration * (1.0 - AIM_END)
    t = t - t[0]
    if not held and (changed & (t >= end) & (np.append(0.0, t[:-1]) < end)).any():
        return None
    times = t[changed & (t < end)]
    rest = float(times[-1]) if len(times) else 0.0
    return rest if rest <= LATEST * duration else None
