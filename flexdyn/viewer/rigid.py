"""The arm without elasticity under the same command, shown together with the motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flexdyn.control.commands import PD, Controller
from flexdyn.control.samples import Samples
from flexdyn.control.servo import Servo
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.given_command import measured_state, resolve_command
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.viewer.motion import PlayedMotion, of_run

RIGID = "rigid"
"""The word for the same arm without elasticity, instead of a motion to compare with."""
OPEN_LOOP = "the rigid arm replays the recorded torques in open loop: no controller holds it on its path"
LAW_AGAIN = "the controller's law is called a second time, for the rigid arm: one that remembers goes on from there"


def without_elasticity(
    source: Run | Recording | FlexibleJointModel, model: FlexibleJointModel, shown: PlayedMotion, command: Any = None
) -> PlayedMotion:
    """The motion of the arm with rigid joints, from the same first positions and, if known, velocities.

    A run's controller drives the rigid arm as well. Without a controller, or for a recording, the commanded torques
    drive it, each held to the next sample.

    Args:
        source: a run or a recording.
        model: of its arm.
        shown: its motion.
        command: that drives the rigid arm instead, such as the controller with which a recording was made.

    Raises:
        InputError: no torque of any joint, a single sample, or a model, which does not move.
        SimulationError: the rigid arm could not be simulated.
    """
    if isinstance(source, FlexibleJointModel):
        remedy = "give a run or a recording"
        raise InputError("a model alone has no torques for a rigid arm", key="compare", remedy=remedy)
    if len(shown.t) < 2:
        raise InputError("one sample is no motion for a rigid arm", key="t", value=float(shown.t[0]))
    given = resolve_command(command)
    if isinstance(source, Run):
        ghost, notes = _beside_run(source, given)
    else:
        ghost, notes = _beside_recording(source, model, shown, given)
    return replace(ghost, t=shown.t, notes=notes)


def _beside_run(source: Run, given: Any) -> tuple[PlayedMotion, tuple[str, ...]]:
    """The rigid arm's motion under a run's command or another one, and notes on it."""
    inputs, rigid = source.inputs, source.model.rigid()
    command = inputs.controller if given is None else given
    notes = ("forces at frames are not applied to the rigid arm",) if inputs.external else ()
    if command is None:
        # Torques are held from sample to sample, as in a recording of the run.
        held, times = Samples(source.t, source.tau), source.t - source.t[0]
        return of_run(simulate(rigid, held, q0=source.q[0], v0=source.v[0], times=times)), notes
    n, x0 = source.model.n, inputs.x0  # the start of the run, which may be before its first sample
    first = n + int(source.model.elastic.sum())
    run = simulate(rigid, command, inputs.duration, q0=x0[:n], v0=x0[first : first + n], times=source.t)
    return _labelled(run, command), (*notes, *((LAW_AGAIN,) if isinstance(command, Controller) else ()))


def _beside_recording(
    source: Recording, model: FlexibleJointModel, shown: PlayedMotion, command: Any
) -> tuple[PlayedMotion, tuple[str, ...]]:
    """The rigid arm's motion under a recording's torques or a command, and notes on it."""
    rigid, times = model.rigid(), shown.t - shown.t[0]
    if command is None:
        idle = _idle(source, model)
        ghost = of_run(simulate(rigid, source, q0=shown.q[0], times=times))
        notes = (OPEN_LOOP, *idle, *_slow(source, model))
        return replace(ghost, label=f"{ghost.label}, in open loop"), notes
    start = measured_state(source, rigid)["v"] or None
    run = simulate(rigid, command, float(times[-1]), q0=shown.q[0], v0=start, times=times)
    return _labelled(run, command), _slow(source, model)


def _labelled(run: Run, command: Any) -> PlayedMotion:
    """The rigid arm's motion; its label names the command."""
    ghost = of_run(run)
    closed = isinstance(command, PD | Servo | Controller)
    return replace(ghost, label=f"{ghost.label}, under the controller") if closed else ghost


def _idle(recording: Recording, model: FlexibleJointModel) -> tuple[str, ...]:
    """Joints that nothing drives.

    Raises:
        InputError: there is no torque of any joint.
    """
    idle = [joint for joint in model.joint_names if not recording.has("tau", joint)]
    if len(idle) == model.n:
        has = ", ".join(list(recording.channels)[:6])
        remedy = f"the rigid arm needs the torques asked for, as tau.{model.joint_names[0]}"
        raise InputError("no tau of any joint of the arm", key="channels", value=has, remedy=remedy)
    return (f"no tau in the recording, none on the rigid arm: {', '.join(idle)}",) if idle else ()


def _slow(recording: Recording, model: FlexibleJointModel) -> tuple[str, ...]:
    """Joints whose first velocity nobody recorded."""
    unknown = [j for j in model.joint_names if not (recording.has("v", j) or recording.has("omega", j))]
    start = "no velocity in the recording, the rigid arm starts with the model's"
    return (f"{start}: {', '.join(unknown)}",) if unknown else ()
