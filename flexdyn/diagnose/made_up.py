"""Positions that no encoder saw, made up from their joints' own equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.kernel import Kernel
from flexdyn.diagnose.measured import Measured
from flexdyn.diagnose.users_laws import torque_of
from flexdyn.effects import Backlash, JointEffect
from flexdyn.model import FlexibleJointModel
from flexdyn.plant import LinkSide

Array = NDArray[np.float64]
KNOWN = ("viscous_friction", "coulomb_friction", "quadratic_drag", "stribeck_friction", "asymmetric_friction")
"""Friction that a velocity alone decides."""


@dataclass(frozen=True, eq=False)
class MadeUp:
    """Positions behind the first filter, all there.

    Attributes:
        q, theta: of links and rotors (samples, n) [rad or m].
    """

    q: Array
    theta: Array


def made_up(
    model: FlexibleJointModel, links: LinkSide, q: Array, theta: Array, tau: Array, data: Measured, kernel: Kernel
) -> MadeUp:
    """Link and rotor positions, the missing ones behind the spring and the gap of their joint.

    ``q = theta - (tau - J alpha)/K`` or ``theta = q + (M a + h)/K``, and half a gap more on the side to which
    ``tau - J alpha - f_motor`` or ``M a + h + f_link`` winds the spring. What friction does to the winding itself is
    allowed for to first order, as it is for laws that are not in the model yet.

    Args:
        model: resolved.
        links: its link side.
        q: measured positions of the links, where there are none those of the rotors (samples, n).
        theta: the reverse.
        tau: asked for (samples, n).
        data: the recording.
        kernel: the first filter.
    """
    only_motor, only_link = model.elastic & ~data.has_q, model.elastic & ~data.has_theta
    smooth_q, smooth_theta, smooth_tau = (kernel.apply(x, 0) for x in (q, theta, tau))
    omega, alpha = kernel.apply(theta, 1), kernel.apply(theta, 2)
    t = data.t[kernel.half : len(data.t) - kernel.half]
    for j in np.flatnonzero(only_motor).tolist():
        carried = smooth_tau[:, j] - model.rotor_inertia[j] * alpha[:, j]
        rubbing = _friction(model, j, "motor", smooth_theta[:, j], omega[:, j], t)
        smooth_q[:, j] = smooth_theta[:, j] - carried / model.stiffness[j] - _gap(model, j) * np.sign(carried - rubbing)
    if only_link.any():
        v, a = kernel.apply(q, 1), kernel.apply(q, 2)
        for j in np.flatnonzero(only_motor).tolist():  # a joint without link encoder moves nearly as its rotor does
            v[:, j], a[:, j] = omega[:, j], alpha[:, j]
        total = np.einsum("tij,tj->ti", links.mass_matrix(smooth_q), a) + links.bias(smooth_q, v)
        for j in np.flatnonzero(only_link).tolist():
            rubbing = _friction(model, j, "link", smooth_q[:, j], v[:, j], t)
            gap = _gap(model, j) * np.sign(total[:, j] + rubbing)
            smooth_theta[:, j] = smooth_q[:, j] + total[:, j] / model.stiffness[j] + gap
    return MadeUp(smooth_q, smooth_theta)


def _acting(model: FlexibleJointModel, j: int) -> list[JointEffect]:
    return [e for e in model.all_effects if isinstance(e, JointEffect) and e.joint == model.joint_names[j]]


def _gap(model: FlexibleJointModel, j: int) -> float:
    """Half of the play of a joint [rad or m]."""
    return float(sum(effect.half_gap for effect in _acting(model, j) if isinstance(effect, Backlash)))


def _friction(model: FlexibleJointModel, j: int, side: str, x: Array, u: Array, t: Array) -> Array:
    """Friction torque (samples,) on one side of a joint."""
    known = [e for e in _acting(model, j) if e.side == side and e.name in KNOWN]
    return np.asarray(sum((torque_of(e, x, u, t=t, tau=np.zeros_like(x)) for e in known), np.zeros_like(x)))
