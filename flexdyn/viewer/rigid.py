"""The arm without elasticity beside the motion that is shown: what the springs make of the same torques."""

from __future__ import annotations

from dataclasses import replace

from flexdyn.control.commands import Samples
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.viewer.motion import Motion, of_run

RIGID = "rigid"
"""In place of what a motion is compared with: the same arm without elasticity."""


def without_elasticity(
    source: Run | Recording | FlexibleJointModel, model: FlexibleJointModel, shown: Motion
) -> Motion:
    """What the arm does with rigid joints under the torques asked for, each held to the next sample.

    It starts where the motion starts, as fast where that is known.

    Args:
        source: a run or a recording.
        model: of its arm.
        shown: its motion.

    Raises:
        InputError: no torque of any joint, a single sample, or a model, which does not move.
        SimulationError: the rigid arm could not be simulated.
    """
    if isinstance(source, FlexibleJointModel):
        remedy = "give a run or a recording"
        raise InputError("a model alone has no torques for a rigid arm", key="compare", remedy=remedy)
    times, rigid = shown.t - shown.t[0], model.rigid()
    if len(times) < 2:
        raise InputError("one sample is no motion for a rigid arm", key="t", value=float(shown.t[0]))
    if isinstance(source, Run):
        run = simulate(rigid, Samples(source.t, source.tau), q0=source.q[0], v0=source.v[0], times=times)
        notes: tuple[str, ...] = (
            ("forces at frames are not applied to the rigid arm",) if source.inputs.external else ()
        )
    else:
        _check_torques(source, model)
        run = simulate(rigid, source, q0=shown.q[0], times=times)
        notes = _notes(source, model)
    return replace(of_run(run), t=shown.t, notes=notes)


def _check_torques(recording: Recording, model: FlexibleJointModel) -> None:
    """Whether there are torques to play."""
    if not any(recording.has("tau", joint) for joint in model.joint_names):
        has = ", ".join(list(recording.channels)[:6])
        remedy = f"the rigid arm needs the torques asked for, as tau.{model.joint_names[0]}"
        raise InputError("no tau of any joint of the arm", key="channels", value=has, remedy=remedy)


def _notes(recording: Recording, model: FlexibleJointModel) -> tuple[str, ...]:
    notes = []
    idle = [joint for joint in model.joint_names if not recording.has("tau", joint)]
    if idle:
        notes.append(f"no tau in the recording, none on the rigid arm: {', '.join(idle)}")
    unknown = [j for j in model.joint_names if not (recording.has("v", j) or recording.has("omega", j))]
    if unknown:
        notes.append(f"no velocity in the recording, the rigid arm starts with the model's: {', '.join(unknown)}")
    return tuple(notes)
