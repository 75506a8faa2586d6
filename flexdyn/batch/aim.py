"""What a command wants of the arm: a path to track, and when the command comes to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.control.commands import PD, Controller, Interpolation, Samples
from flexdyn.control.servo import Servo
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.asked_torque import is_of_goals, with_asked_torque
from flexdyn.simulation.command_input import followed, recorded, resolve_command
from flexdyn.simulation.run import Run

Array = NDArray[np.float64]
AIM_END = 1e-9
"""A change of the command this share of the run before its end has no time to act."""
LATEST = 0.95
"""A command that still changes after this share of the run does not come to rest within it."""


@dataclass(frozen=True, eq=False)
class Aim:
    """What metrics must know of a command; the same for all runs of a study.

    Attributes:
        rest: from when on the command no longer changes [s from the start of the run]: a torque that is played no
            longer changes, a reference stands still; None: it never comes to rest within the run.
        reference: positions to be tracked, one column for each joint; None: torques are played.
    """

    rest: float | None
    reference: Samples | None = None

    def wanted(self, t: Array) -> Array:
        """The reference at times of a run (samples, n) [rad or m]; after its end it stays where it ended.

        Raises:
            ValueError: there is no reference.
        """
        if self.reference is None:
            raise ValueError("there is no reference to track")
        breaks, coefficients, last = self.reference.pieces(self.reference.values)
        piece = np.clip(np.searchsorted(breaks, t, "right") - 1, 0, len(breaks) - 2)
        ahead = (t - breaks[piece])[:, None]
        values = np.zeros((len(t), coefficients.shape[2]))
        for power in reversed(range(coefficients.shape[1])):
            values = values * ahead + coefficients[piece, power]
        return np.where((t >= breaks[-1])[:, None], last, values)


def aim_of(command: Any, model: FlexibleJointModel, duration: float) -> Aim:
    """What a command wants of an arm.

    Args:
        command: as `flexdyn.simulate` takes it.
        model: the arm.
        duration: of the run [s].

    Raises:
        InputError: a recording or reference that does not fit the model.
    """
    command = resolve_command(command)
    if isinstance(command, PD | Servo):
        chosen = command.interpolation if isinstance(command, PD) else None
        reference = _reference(command.reference, chosen, model.joint_names)
        return Aim(_still(reference.t, reference.values, duration, reference.interpolation == "hold"), reference)
    if isinstance(command, Controller):
        return Aim(None)
    if isinstance(command, Recording):
        if is_of_goals(model, command):
            reference = recorded(command, "goal", model.joint_names)
            return Aim(_still(reference.t, reference.values, duration, True), reference)
        command = recorded(with_asked_torque(model, command), "tau", model.joint_names)
    return Aim(_played_out(command, duration))


def aim_of_run(run: Run) -> Aim:
    """What is known of a run alone: the torques that were played; of a controller its ticks, and no reference."""
    return Aim(_played_out(run.inputs.samples, run.inputs.duration))


def _reference(given: Any, interpolation: Interpolation | None, names: Sequence[str]) -> Samples:
    """A reference as it is tracked."""
    reference = resolve_command(given)
    if isinstance(reference, Recording):
        return followed(reference, interpolation, names)
    return Samples(reference.t, reference.columns(names), reference.interpolation)


def _played_out(torques: Any, duration: float) -> float | None:
    """When torques change for the last time; at their end they fall to zero."""
    if not isinstance(torques, Samples):
        return 0.0
    held = torques.interpolation == "hold"
    rows = torques.values.copy()
    if held:
        rows[-1] = 0.0  # the last row of held torques never acts
    rest = _still(torques.t, rows, duration, held)
    end = torques.duration
    return max(rest, end) if rest is not None and rows[-1].any() and end < LATEST * duration else rest


def _still(t: Array, rows: Array, duration: float, held: bool) -> float | None:
    """From when on rows no longer change; held ones change at a sample, others all the way to it."""
    changed = np.append(False, (rows[1:] != rows[:-1]).any(axis=1))
    end = duration * (1.0 - AIM_END)
    t = t - t[0]
    if not held and (changed & (t >= end) & (np.append(0.0, t[:-1]) < end)).any():
        return None
    times = t[changed & (t < end)]
    rest = float(times[-1]) if len(times) else 0.0
    return rest if rest <= LATEST * duration else None
