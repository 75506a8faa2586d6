"""Unmeasured positions, computed from the equations of their joints."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.rest import Rests
from flexdyn.diagnose.equations.shared import SharedResults
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.effects import DeflectionEffect, JointEffect, MemoryEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide

STEEP_SPRING_ROUNDS, STEEP_SPRING_STEP, STEEPEST_SPRING = 8, 1e-4, 10.0
"""Newton's method: steps, relative difference for slopes, and largest ratio of slopes to the spring's stiffness."""
BENT_ROUNDS = 3
"""Rounds by which the rotor's position is found where its own wave bends the spring; each is better by amplitude times
harmonic."""
LEAST_TRANSMITTED = 0.1
"""Share of its load that a gear turned by it must transmit for the motor's torque to tell the load [1]."""


def computed_positions(
    model: FlexibleJointModel,
    links: LinkSide,
    q: Array,
    theta: Array,
    tau: Array,
    data: Measured,
    kernel: GaussianSmoother,
    rests: Rests | None,
    shared: SharedResults,
) -> tuple[Array, Array]:
    """Link and rotor positions; missing ones are computed from the law of the transmission.

    The deflection is the one at which the transmission carries ``tau - J alpha - f_motor`` or ``M a + h + f_link``. In
    f_motor are all laws of the velocity, and those that take a share of this load.
    While a motor rests, its friction is unknown: then it is the second one, with the link as fast as the rotor.
    Other effects of the model, and missing ones, are taken into account to first order.

    Args:
        model: resolved.
        links: its link side.
        q: measured positions of the links, else those of the rotors (samples, n).
        theta: measured positions of the rotors, else those of the links (samples, n).
        tau: commanded torques (samples, n).
        data: the recording.
        kernel: the first filter.
        rests: where motors rest whose links are not measured; None: nowhere.
        shared: what other models may have asked for.

    Returns:
        Positions of links and of rotors after the filter, (samples, n) each [rad or m].
    """
    only_motor, only_link = model.elastic & ~data.has_q, model.elastic & ~data.has_theta
    smooth_q, smooth_theta = (shared.filtered(kernel, each, 0).copy() for each in (q, theta))
    t = data.t[kernel.half : len(data.t) - kernel.half]
    total = np.zeros_like(smooth_q)
    if only_link.any() or rests:  # a joint without link encoder moves nearly like its rotor: q is theta there
        v, a = (shared.filtered(kernel, q, order) for order in (1, 2))
    if rests:
        total = shared.torques(links, smooth_q.copy(), v, a)
    if only_motor.any():
        omega, alpha = (shared.filtered(kernel, theta, order) for order in (1, 2))
        smooth_tau = shared.filtered(kernel, tau, 0)
    for j in np.flatnonzero(only_motor).tolist():
        rubbing = friction_of(model, j, "motor", smooth_theta[:, j], omega[:, j], t)
        given = smooth_tau[:, j] - model.rotor_inertia[j] * alpha[:, j] - rubbing
        carried = _carried(model, j, given, smooth_theta[:, j], omega[:, j], t)
        bent, slope = _bent_by_rotor(model, j, theta[:, j], kernel)
        carried = rests.instead(j, total[:, j], carried / slope) if rests else carried / slope
        smooth_q[:, j] += bent - wound_by_torque(model, j, carried)
    if only_link.any():
        total = shared.torques(links, smooth_q, v, a)
        for j in np.flatnonzero(only_link).tolist():
            rubbing = friction_of(model, j, "link", smooth_q[:, j], v[:, j], t)
            straight = smooth_q[:, j] + wound_by_torque(model, j, total[:, j] + rubbing)
            smooth_theta[:, j], rotor = straight, theta[:, j].copy()
            for _ in range(BENT_ROUNDS):
                rotor[kernel.half : len(rotor) - kernel.half] += smooth_theta[:, j] - kernel.apply(rotor, 0)
                smooth_theta[:, j] = straight - _bent_by_rotor(model, j, rotor, kernel)[0]
    return smooth_q, smooth_theta


def acting_on(model: FlexibleJointModel, j: int) -> list[JointEffect]:
    """Effects with a law along the motion that act on a joint."""
    return [e for e in model.all_effects if isinstance(e, JointEffect) and e.joint == model.joint_names[j]]


def _carried(model: FlexibleJointModel, j: int, given: Array, theta: Array, omega: Array, t: Array) -> Array:
    """Transmission torque (samples,) where friction takes a share of it: ``carried + f(carried) = given``.

    Such friction is proportional to the load, with one share for each direction of power. So ``carried = given/(1 +
    share)``. Of a gear that nearly locks itself, the motor's torque tells no load: it is left as it is.
    """
    kept = 1.0 + lost_share(model, j, given, theta, omega, t)
    return np.where(kept > LEAST_TRANSMITTED, given / np.maximum(kept, LEAST_TRANSMITTED), given)


def lost_share(model: FlexibleJointModel, j: int, load: Array, theta: Array, omega: Array, t: Array) -> Array:
    """Friction of a motor over a load (samples,) [1], of laws that take a share of it; zero without a load.

    Args:
        model: resolved.
        j: the joint.
        load: a torque of the sign of that in the transmission (samples,) [N m].
        theta: position of the rotor (samples,) [rad].
        omega: its velocity (samples,) [rad/s].
        t: times (samples,) [s].
    """
    loaded = [each for each in acting_on(model, j) if each.takes_load and each.side == "motor"]
    lost = sum((torque_of(each, theta, omega, t=t, tau=load) for each in loaded), np.zeros_like(load))
    return np.divide(lost, load, out=np.zeros_like(load), where=load != 0.0)


def _bent_by_rotor(model: FlexibleJointModel, j: int, theta: Array, kernel: GaussianSmoother) -> tuple[Array, Array]:
    """What the rotor's position adds to the deflection of the spring, and 1 plus its slope, after the filter.

    A fast wave of the filtered position would be larger than the filtered wave.

    Args:
        model: resolved.
        j: the joint.
        theta: position of the rotor before the filter (samples,).
        kernel: the first filter.
    """
    bends = [e for e in acting_on(model, j) if isinstance(e, DeflectionEffect) and e.of_rotor]
    still = np.zeros_like(theta)
    bent = sum((each.deflection(still, theta) for each in bends), still)
    slope = 1.0 + sum((each.slope(theta) for each in bends), still)
    return kernel.apply(bent, 0), kernel.apply(slope, 0)


def wound_by_torque(model: FlexibleJointModel, j: int, carried: Array) -> Array:
    """Deflection (samples,) for a transmission torque (samples,), by Newton's method."""
    seen = carried / model.stiffness[j]
    for _ in range(STEEP_SPRING_ROUNDS if _springs(model, j) else 0):
        torque, slope = _spring(model, j, seen)
        seen = seen + (carried - torque) / slope
    # The inverse of `deflection_after` in laws.hpp.
    gap = sum(effect.gap for effect in acting_on(model, j) if isinstance(effect, DeflectionEffect))
    return np.asarray(seen + gap * np.sign(carried))


def steepness(model: FlexibleJointModel, j: int, seen: Array) -> Array:
    """Slope of the spring's torque (samples,) at deflections (samples,) [N m/rad or N/m], as a response takes it.

    Without gaps, and within the limits that Newton's method needs; `terms.spring_slope` has the gaps and no limits.
    """
    return _spring(model, j, seen)[1] if _springs(model, j) else np.full(len(seen), model.stiffness[j])


def _springs(model: FlexibleJointModel, j: int) -> list[JointEffect]:
    """Laws in addition to the linear spring that make it another one."""
    return [effect for effect in acting_on(model, j) if effect.bends_spring and effect.stage == "spring"]


def _spring(model: FlexibleJointModel, j: int, seen: Array) -> tuple[Array, Array]:
    """Torque of the spring (samples,) at deflections (samples,), and its slope."""
    K, springs = model.stiffness[j], _springs(model, j)
    with np.errstate(over="ignore", invalid="ignore"):  # a law far from any spring: what is not finite is refused
        torque, ahead = (K * x + _more(springs, x) for x in (seen, (1.0 + STEEP_SPRING_STEP) * seen))
        slope = (ahead - torque) / np.where(seen == 0.0, np.inf, STEEP_SPRING_STEP * seen)
        return torque, np.clip(slope, K, STEEPEST_SPRING * K)


def _more(springs: list[JointEffect], seen: Array) -> Array:
    """Torque (samples,) of the laws in addition to the linear spring."""
    still = np.zeros_like(seen)
    parts = (
        e.along(seen) if isinstance(e, MemoryEffect) else torque_of(e, seen, still, t=still, tau=still) for e in springs
    )
    return np.asarray(sum(parts, still))


def friction_of(model: FlexibleJointModel, j: int, side: str, x: Array, u: Array, t: Array) -> Array:
    """Friction torque (samples,) on one side of a joint."""
    known = [e for e in acting_on(model, j) if e.side == side and e.of_velocity]
    return np.asarray(sum((torque_of(e, x, u, t=t, tau=np.zeros_like(x)) for e in known), np.zeros_like(x)))
