"""The torques of a model's effects along a measured motion, equation by equation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import later
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.springs import slope_of, spring_torque
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.effects import CouplingEffect, Effect, JointEffect, MemoryEffect
from flexdyn.effects.waves import WaveEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.robot.axes import joint_row


def applied_torque(effects: Sequence[JointEffect], model: FlexibleJointModel, motion: SmoothedMotion, j: int) -> Array:
    """tau_applied (samples,): the actuator effects act on the commanded torque one after the other.

    What bends the torque acts before the filters, where it was recorded; after them where the command comes late.
    """
    acting = _in_order(effects)
    late = any(each.late_by for each in acting)
    if motion.held is None or late or not any(each.of_recorded_torque for each in acting):
        waves = {each: wave for each in acting if (wave := _recorded_wave(each, model, motion, j)) is not None}
        others = [each for each in acting if each not in waves]
        tau = _through_actuator(others, motion.t, motion.theta[:, j], motion.omega[:, j], motion.tau[:, j])
        return tau + sum(waves.values(), np.zeros_like(tau))
    theta, omega = (np.pad(x[:, j], motion.lost, mode="edge") for x in (motion.theta, motion.omega))
    recorded = motion.recorded(j, "motor", bool(model.elastic[j]))
    theta = theta if recorded is None else recorded
    return motion.held.through(
        lambda tau: _through_actuator(acting, motion.data.t, theta, omega, tau), j, len(motion.t)
    )


def _recorded_wave(effect: JointEffect, model: FlexibleJointModel, motion: SmoothedMotion, j: int) -> Array | None:
    """Torque (samples,) of a wave over a recorded position, as the filters weaken it; None: the law is no such wave.

    A fast wave over the filtered position would be larger than the filtered wave.
    """
    side = "link" if effect.side == "link" else "motor"
    x = motion.recorded(j, side, bool(model.elastic[j])) if isinstance(effect, WaveEffect) else None
    if x is None:
        return None
    u = np.pad((motion.v if side == "link" else motion.omega)[:, j], motion.lost, mode="edge")
    return motion.filtered(effect.torque(x, u, t=motion.data.t, tau=np.zeros_like(x)))


def torque_slope(effects: Sequence[JointEffect], motion: SmoothedMotion, j: int) -> Array | None:
    """Slope of tau_applied over tau (samples,) [1], by differences; None: no effect bends the torque."""
    acting = _in_order(effects)
    if not any(each.of_recorded_torque for each in acting):
        return None
    theta, omega = motion.theta[:, j], motion.omega[:, j]
    return slope_of(lambda tau: _through_actuator(acting, motion.t, theta, omega, tau), motion.tau[:, j])


def _in_order(effects: Sequence[JointEffect]) -> list[JointEffect]:
    """The effects on the motor's torque, the first to act first."""
    return sorted((e for e in effects if e.stage == "actuator"), key=lambda e: e.order)


def _through_actuator(acting: Sequence[JointEffect], t: Array, theta: Array, omega: Array, tau: Array) -> Array:
    """A torque after some effects, one after the other (samples,)."""
    for effect in acting:
        late = bool(effect.late_by)
        tau = later(t, tau, effect.lateness) if late else torque_of(effect, theta, omega, t=t, tau=tau)
    return tau


def friction_torque(
    effects: Sequence[JointEffect], model: FlexibleJointModel, motion: SmoothedMotion, j: int, side: str, carried: Array
) -> Array:
    """f_motor or f_link (samples,) of a joint; `carried` is tau_s, on which some laws depend."""
    x, u = (motion.q, motion.v) if side == "link" else (motion.theta, motion.omega)
    total = np.zeros(len(motion.t))
    for effect in effects:
        if effect.side != side or effect.stage not in ("friction", "dry"):
            continue
        if effect.takes_load:
            total += effect.torque(x[:, j], u[:, j], tau=carried)
        else:
            total += -own_torque(effect, model, motion)[1]
    return total


def spreads(effect: Effect, model: FlexibleJointModel) -> bool:
    """Whether an effect acts on several axes: dry friction between two motors, a law of a joint that several move."""
    if isinstance(effect, CouplingEffect) and effect.rubbing_ratio is not None:
        return True
    return isinstance(effect, JointEffect) and joint_row(model.robot, effect.joint) is not None


def spread_torques(effect: JointEffect, model: FlexibleJointModel, motion: SmoothedMotion) -> tuple[str, Array]:
    """Side of an effect that acts on several axes, and its torques (samples, n) on the right side of its equations."""
    torques, row = np.zeros_like(motion.q), joint_row(model.robot, effect.joint)
    if row is not None:
        own = effect.torque(motion.q @ row, motion.v @ row, t=motion.t)
        return "link", torques + own[:, None] * row
    assert isinstance(effect, CouplingEffect)  # noqa: S101 - see `spreads`
    one, other = model.index(effect.joint), model.index(effect.partner)
    torques[:, one], torques[:, other] = effect.on_rotors(motion.omega[:, one], motion.omega[:, other])
    return "motor", torques


def _not_friction(
    effects: Sequence[Effect], model: FlexibleJointModel, motion: SmoothedMotion, j: int
) -> dict[str, Array]:
    """Torques of a joint that are no friction, by side (samples,): on its link, and of effects on several axes."""
    found = {side: np.zeros(len(motion.t)) for side in ("motor", "link")}
    for effect in effects:
        if isinstance(effect, JointEffect) and spreads(effect, model):
            side, torques = spread_torques(effect, model, motion)
            found[side] += torques[:, j]
        elif isinstance(effect, JointEffect) and effect.stage == "link" and model.index(effect.joint) == j:
            found["link"] += own_torque(effect, model, motion)[1]
    return found


def own_torque(effect: JointEffect, model: FlexibleJointModel, motion: SmoothedMotion) -> tuple[str, Array]:
    """Side of an additive effect, and its torque (samples,) on the right side of that side's equation."""
    j, side = model.index(effect.joint), "link" if effect.stage == "link" else str(effect.side)
    x, u = (motion.q[:, j], motion.v[:, j]) if side == "link" else (motion.theta[:, j], motion.omega[:, j])
    if effect.stage == "link":
        return side, effect.torque(x, u, t=motion.t)
    if isinstance(effect, MemoryEffect):
        return side, -effect.along(x, u)
    if isinstance(effect, CouplingEffect):
        return side, effect.on_rotors(u, motion.omega[:, model.index(effect.partner)])[0]
    wave = _recorded_wave(effect, model, motion, j)
    return side, -(torque_of(effect, x, u, t=motion.t, tau=motion.tau[:, j]) if wave is None else wave)


@dataclass(frozen=True, eq=False)
class Terms:
    """Terms of a joint's equations except inertia, M a and h, (samples,) each [N m or N].

    Attributes:
        motor: tau_applied - tau_s - f_motor; for a rigid joint without tau_s.
        link: tau_s - f_link + torques on the link; for a rigid joint without tau_s.
        tau_s: torque in the transmission: that of its springs, also at a deflection that was computed from the torque;
            if it is rigid, the torque that the link needs.
    """

    motor: Array
    link: Array
    tau_s: Array


def joint_terms(model: FlexibleJointModel, effects: Sequence[Effect], motion: SmoothedMotion, j: int) -> Terms:
    """The torques on a joint's rotor and link along a motion."""
    own = (each for each in effects if isinstance(each, JointEffect) and each.joint == model.joint_names[j])
    acting = [each for each in own if not spreads(each, model)]
    given = _not_friction(effects, model, motion, j)
    motor = applied_torque(acting, model, motion, j) + given["motor"]
    link = given["link"] - friction_torque(acting, model, motion, j, "link", np.zeros(len(motion.t)))
    carried = motion.inverse_dynamics[:, j] - link
    if model.elastic[j]:
        both = spring_torque(model, acting, motion, j)
        carried = both[:, 0]
        motor, link = motor - both[:, 1], link + both[:, 0]
    motor = motor - friction_torque(acting, model, motion, j, "motor", carried)
    return Terms(motor, link, carried)
