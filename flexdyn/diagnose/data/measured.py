"""Recordings for the diagnosis: on a uniform clock, joint by joint, with flags for missing channels."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.checks import check_known
from flexdyn.effects.sensor import POSITIONS
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.signals.between_steps import between_steps
from flexdyn.records.signals.decimate import CLOCK_JITTER
from flexdyn.records.signals.reading_noise import reading_noise

SIGNALS = ("q", "theta", "tau", "tau_s")


@dataclass(frozen=True, eq=False)
class Measured:
    """One recording, one column for each joint of the model; unmeasured columns are zero.

    Attributes:
        name: of the recording.
        t: uniform times since the start of the run (samples,) [s].
        dt: between samples [s].
        q: link positions (samples, n) [rad or m].
        theta: rotor positions, reflected (samples, n).
        tau: commanded torques, held (samples, n) [N m or N].
        tau_s: torques measured in the transmission (samples, n).
        has_q: joints with a link encoder (n,).
        has_theta: joints with a motor encoder (n,).
        has_tau_s: joints with a torque sensor (n,).
        forced: joints whose motion a test rig prescribes (n,).
        q_noise, theta_noise: standard deviations of one reading of the encoders (n,) [rad or m].
        q_stays, theta_stays: of errors of positions that stay for longer than filters reach (samples, n) [rad or m].
    """

    name: str
    t: Array
    dt: float
    q: Array
    theta: Array
    tau: Array
    tau_s: Array
    has_q: Flags
    has_theta: Flags
    has_tau_s: Flags
    forced: Flags
    q_noise: Array
    theta_noise: Array
    q_stays: Array | float = 0.0
    theta_stays: Array | float = 0.0

    @property
    def both(self) -> Flags:
        """Joints with both encoders (n,)."""
        return np.asarray(self.has_q & self.has_theta)

    @property
    def moved(self) -> Array:
        """Positions of the links, without an encoder there those of the rotors (samples, n)."""
        return np.where(self.has_q, self.q, self.theta)

    def encoders(self, joints: Sequence[str]) -> tuple[str, ...]:
        """Channels of the encoders, joint by joint: ``q.<joint>`` and ``theta.<joint>``."""
        there = {"q": self.has_q, "theta": self.has_theta}
        return tuple(f"{signal}.{joint}" for j, joint in enumerate(joints) for signal in there if there[signal][j])

    def part(self, first: int, last: int) -> Measured:
        """Samples from `first` up to, but without, `last`; times are still those since the start of the run."""
        signals: dict[str, Any] = {name: getattr(self, name)[first:last] for name in ("t", *SIGNALS)}
        return dataclasses.replace(self, **signals, **_noise(signals))

    def between_steps(self, least: int) -> Measured:
        """The same with positions that are more exact than the readings; the noise stays that of a reading.

        Args:
            least: see `between_steps`.
        """
        finer: dict[str, Any] = {}
        for signal in POSITIONS:
            each = [between_steps(x, least) for x in getattr(self, signal).T]
            finer[signal], finer[f"{signal}_stays"] = (np.stack(some, axis=1) for some in zip(*each, strict=True))
        return dataclasses.replace(self, **finer)


def measured(model: FlexibleJointModel, recording: Recording) -> Measured:
    """Prepare a recording.

    Raises:
        InputError: a joint that the model does not have, or a joint without torque or without any position.
    """
    _check_joints(model, recording)
    recording = uniform(recording)
    names = model.joint_names
    found: dict[str, Any] = {}
    for signal in SIGNALS:
        there = np.array([recording.has(signal, joint) for joint in names])
        column = np.zeros((len(recording), len(names)))
        for j in np.flatnonzero(there):
            column[:, j] = recording[f"{signal}.{names[j]}"]
        found |= {signal: column, f"has_{signal}": there}
    del found["has_tau"]  # of every joint
    t = recording.t - recording.t[0]
    dt = float(t[-1]) / (len(t) - 1)
    forced = np.array([joint in recording.prescribed for joint in names])
    return Measured(name=recording.name, t=t, dt=dt, forced=forced, **found, **_noise(found))


def _noise(signals: Mapping[str, Any]) -> dict[str, Any]:
    """Standard deviations of one reading of each joint's encoders (n,)."""
    return {f"{name}_noise": np.array([reading_noise(x) for x in signals[name].T]) for name in POSITIONS}


def _check_joints(model: FlexibleJointModel, recording: Recording) -> None:
    """Refuse a recording that lacks the torque or the position of a joint, or has joints of another arm."""
    for joint in recording.joints:
        check_known(joint, model.joint_names, "the recording has a joint that the model lacks", key=joint)
    for joint in model.joint_names:
        if not recording.has("tau", joint):
            remedy = f"record the commanded torque as tau.{joint}, or lock the joint in the model"
            raise InputError("no torque of the joint was recorded", key=f"tau.{joint}", remedy=remedy)
        if not recording.has("q", joint) and not recording.has("theta", joint):
            remedy = f"record q.{joint} or theta.{joint}"
            raise InputError("no position of the joint was recorded", key=joint, remedy=remedy)
        elastic = model.resolved().elastic[model.index(joint)]
        if joint in recording.prescribed and elastic and not recording.has("theta", joint):
            remedy = f"record its position as theta.{joint}, or give the joint a stiffness of .inf in the model"
            raise InputError("the rig moves the motor's side of an elastic joint", key=f"q.{joint}", remedy=remedy)


def uniform(recording: Recording) -> Recording:
    """The recording on a uniform clock; unchanged if its own clock is uniform."""
    steps = np.diff(recording.t)
    dt = float(recording.t[-1] - recording.t[0]) / len(steps)
    grid = recording.t[0] + dt * np.arange(len(recording.t))
    if float(np.abs(recording.t - grid).max()) <= CLOCK_JITTER * dt:
        return recording
    return recording.resample(rate=1.0 / float(np.median(steps)))
