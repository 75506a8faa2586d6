"""Where a test rig prescribes the motion: the force that a model needs for it, instead of positions over windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.model_rows import ModelRows, rms
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.diagnose.report.measures import Gap
from flexdyn.diagnose.report.trace import MOST_LOOP_POINTS, ForceLoop
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.electrical import with_asked_torque


@dataclass(frozen=True, eq=False)
class Forces:
    """How far equations and forces are off by the model as given, calibrated and corrected.

    Attributes:
        gap: root mean square of the rows, in units of noise.
        errors: of the forces of all prescribed joints, root mean square, of the three models.
    """

    gap: Gap
    errors: tuple[float, ...]

    @classmethod
    def of(cls, rows: ModelRows) -> Forces:
        """Of the equations of the three models."""
        before, calibrated, after = map(rows.size, rows.models)
        return cls(Gap(before, calibrated, after, 1.0), errors_of(rows.models))

    @property
    def closer(self) -> bool:
        """Whether the corrected model's forces are as near as the given one's."""
        return self.errors[2] <= self.errors[0] * (1.0 + 1e-9)

    def alone(self) -> Forces:
        """The same where the corrected model is the calibrated one."""
        gap = replace(self.gap, after=self.gap.calibrated)
        return Forces(gap, (*self.errors[:2], self.errors[1]))


def are_prescribed(parts: Sequence[DataPart]) -> bool:
    """Whether a rig prescribes the motion of any joint: then positions are not simulated."""
    return any(bool(each.data.forced.any()) for each in parts)


def errors_of(models: Sequence[Equations], joint: int | None = None) -> tuple[float, ...]:
    """Error of the force, root mean square over all samples, of each model [N m or N].

    Args:
        models: equations over the same recordings.
        joint: its place; None: all whose motion is prescribed, together.
    """
    joints = [j for j, _ in _prescribed(models[0])] if joint is None else [joint]
    return tuple(
        rms(np.concatenate([remaining_force(at, along, j) for along in at.motions for j in joints])) for at in models
    )


def recorded_force(at: Equations, joint: int) -> float:
    """The recorded force of a joint, root mean square over all samples [N m or N]."""
    return rms(np.concatenate([along.tau[:, joint] for along in at.motions]))


def remaining_force(at: Equations, along: SmoothedMotion, j: int) -> Array:
    """Recorded less simulated force of a joint (samples,), behind the first filter alone."""
    true = at.true
    terms = joint_terms(true, true.all_effects, along, j)
    found = terms.motor - true.rotor_inertia[j] * (along.alpha[:, j] - (0.0 if true.elastic[j] else along.a[:, j]))
    if not true.elastic[j]:
        found = found + terms.link - along.inverse_dynamics[:, j]
    return np.asarray(found / at.gains[j])


def loops(models: Sequence[Equations], parts: Sequence[DataPart]) -> tuple[ForceLoop, ...]:
    """Recorded and simulated force of every prescribed joint over its position and speed, a picture a span.

    Args:
        models: equations over the spans of the model as given, calibrated and corrected.
        parts: the spans.
    """
    at, found = models[0], []
    robot = at.true.robot
    for j, joint in _prescribed(at):
        for k, part in enumerate(parts):
            along = [each.motions[k] for each in models]
            simulated = [a.tau[:, j] - remaining_force(each, a, j) for each, a in zip(models, along, strict=True)]
            columns = (along[0].theta[:, j], along[0].omega[:, j], along[0].tau[:, j], simulated[0], simulated[-1])
            every = max(1, -(-len(columns[0]) // MOST_LOOP_POINTS))
            units = (robot.angle_unit(joint), robot.torque_unit(joint))
            drawn = np.stack([column[::every] for column in columns])
            found.append(ForceLoop(joint, part.recording.name, part.role, units, drawn))
    return tuple(found)


def prescribed_forces(model: FlexibleJointModel, recording: Recording) -> Recording:
    """The force or torque that a model needs where a test rig prescribes the motion, along the recorded motion.

    Laws with a state, and links behind a spring, are simulated from the start of the recording on; only the first
    recorded force is read; it gives the deflection of a spring there.

    Args:
        model: with any effects.
        recording: with the names of prescribed joints: ``prescribed`` in its channel map, or in its meta.

    Returns:
        ``tau`` of these joints [N m or N] at the recording's times, some 20 ms at either end left out, which the
        filter of the positions needs.

    Raises:
        InputError: no joint is prescribed, or the recording does not fit the model.

    Example:
        >>> t = np.linspace(0.0, 2.0, 2001)
        >>> swept = {"q.shoulder": 0.3 * np.sin(3.0 * t), "q.elbow": 0 * t, "tau.shoulder": 0 * t, "tau.elbow": 0 * t}
        >>> rig = fd.Recording(t, swept, meta={"prescribed": ["shoulder"]})
        >>> rubbing = fd.effects.CoulombFriction("shoulder", side="link", level=2.0)
        >>> arm = fd.load_model("scara_two_link").replace(joints={"*": {"stiffness": np.inf}}, effects=[])
        >>> without, with_it = (fd.prescribed_forces(arm.replace(effects=e), rig) for e in ([], [rubbing]))
        >>> round(float(np.abs(with_it["tau.shoulder"] - without["tau.shoulder"]).max()), 6)
        2.0
    """
    if not recording.prescribed:
        remedy = "give prescribed: [JOINT] in its channel map, or meta={'prescribed': ['JOINT']}"
        raise InputError(
            "no joint's motion is prescribed", file=recording.name or None, key="prescribed", remedy=remedy
        )
    data = measured(model, with_asked_torque(model, recording))
    at = Equations(model, (data,), Filters.of_rate(data.dt))
    along = at.motions[0]
    columns = {f"tau.{name}": along.tau[:, j] - remaining_force(at, along, j) for j, name in _prescribed(at)}
    meta = {"prescribed": list(recording.prescribed)}
    return Recording(recording.t[0] + along.t, columns, meta=meta, name=recording.name)


def _prescribed(at: Equations) -> list[tuple[int, str]]:
    """Places and names of the joints whose motion is prescribed."""
    names = at.true.joint_names
    return [(int(j), names[j]) for j in np.flatnonzero(at.data[0].forced)]
