"""The motion of an arm for the viewer: link positions and deflections over time, from a run or a recording."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.run import Run


@dataclass(frozen=True)
class PlayedMotion:
    """Positions of an arm over time.

    Attributes:
        label: its name in the page.
        t: times (samples,) [s]; one sample: the arm does not move.
        q: link positions (samples, n) [rad or m].
        deflection: theta - q (samples, n) [rad or m]; NaN where the rotor is rigid with its link or not known.
        notes: what was assumed, one sentence each.
    """

    label: str
    t: Array
    q: Array
    deflection: Array
    notes: tuple[str, ...] = ()

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""
        return float(self.t[0]), float(self.t[-1])

    def at(self, times: Array) -> PlayedMotion:
        """The motion at other times, interpolated linearly, constant before the first and after the last sample."""
        q, deflection = (
            np.column_stack([np.interp(times, self.t, column) for column in table.T])
            for table in (self.q, self.deflection)
        )
        return replace(self, t=times, q=q, deflection=deflection)


def of_run(run: Run) -> PlayedMotion:
    """A simulated motion; the rotors of elastic joints are shown."""
    deflection = np.where(run.model.elastic, run.deflection, np.nan)
    label = run.model.name if run.model.elastic.any() else f"{run.model.name}, rigid"
    return PlayedMotion(label, run.t, run.q, deflection)


def at_rest(model: FlexibleJointModel) -> PlayedMotion:
    """The arm at its initial position."""
    q = np.array([[model.initial.get("q", {}).get(joint, 0.0) for joint in model.joint_names]])
    notes = ("the arm stands at the model's initial position",)
    return PlayedMotion(model.name, np.zeros(1), q, np.full_like(q, np.nan), notes)


def of_recording(
    recording: Recording, model: FlexibleJointModel, missing: PlayedMotion, label: str = ""
) -> PlayedMotion:
    """A recorded motion of the joints of a model.

    Args:
        recording: with q or theta of at least one joint; a joint that has theta alone is shown at theta.
        model: of the arm.
        missing: positions of joints that the recording does not have.
        label: default: the recording's name.

    Raises:
        InputError: no position of any joint of the model.
    """
    joints = model.joint_names
    linked = [joint for joint in joints if recording.has("q", joint)]
    driven = [joint for joint in joints if joint not in linked and recording.has("theta", joint)]
    absent = [joint for joint in joints if joint not in linked and joint not in driven]
    if len(absent) == len(joints):
        has = ", ".join(list(recording.channels)[:6]) or "none"
        remedy = f"channels named {' or '.join(f'{signal}.{joints[0]}' for signal in ('q', 'theta'))} are needed"
        raise InputError("no position of any joint of the arm", key="channels", value=has, remedy=remedy)
    q = missing.at(recording.t).q
    deflection = np.full_like(q, np.nan)
    for j, joint in enumerate(joints):
        if joint in absent:
            continue
        q[:, j] = recording[f"q.{joint}" if joint in linked else f"theta.{joint}"]
        if joint in linked and recording.has("theta", joint):
            measured = recording[f"theta.{joint}"] - q[:, j]
            # The rotor of a rigid joint is not shown, unless it was measured.
            if model.elastic[j] or measured.any():
                deflection[:, j] = measured
    said = {
        "only theta was measured: the link is shown at its rotor's angle": driven,
        "not in the recording, held or as in the arm it is compared with": absent,
    }
    notes = tuple(f"{text}: {', '.join(names)}" for text, names in said.items() if names)
    return PlayedMotion(label or recording.name or model.name, recording.t, q, deflection, notes)
