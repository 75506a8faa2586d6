"""How well the torques of a recording agree with those that a model needs for its motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.data.sensors import true_channels
from flexdyn.diagnose.equations.motion import SmoothedMotion, motion
from flexdyn.diagnose.equations.smoothed import Smoothed, smoothed
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide

SMOOTHING = 0.012
"""Standard deviation of the filter [s]: wide enough for the acceleration from a coarse encoder."""
INSTANT_SPACING = 0.006
"""Time between the samples that are used [s]."""
WOUND_SPRING_RATIO = 3.0
"""An elastic joint with one encoder is tested only if it moves by more than this multiple of its deflection [1]."""


@dataclass(frozen=True, eq=False)
class Match:
    """The agreement of the commanded torques with those that the model needs, joint by joint (n,).

    Offset, viscous and dry friction are removed from both, because a model often lacks them.

    Attributes:
        gain: commanded torque over needed torque [1].
        share: of the variance that the needed torque explains with that gain, 0 to 1.
        plain: the same with a gain of 1; below 0 if the residual is larger than the torque.
        says: whether the rest without friction and noise is large enough for a test.
    """

    gain: Array
    share: Array
    plain: Array
    says: Flags


def match(model: FlexibleJointModel, links: LinkSide, data: Measured, *, springs: bool = False) -> Match:
    """Compare the torques of a recording with those that the model needs for the motion.

    The springs cancel in the sum of a joint's two equations, ``tau = J alpha + M a + h + friction``. Therefore either
    encoder can be used, if the joint moves by more than its deflection.

    Args:
        model: resolved.
        links: its link side.
        data: the recording, on a uniform clock.
        springs: whether to remove the torque of a spring at the link from both as well.
    """
    along = motion(links, _every_few(smoothed(model, links, _both(true_channels(data, model)), _kernel(data.dt))))
    torques = [_needed_and_friction(model, along, j, springs) for j in range(model.n)]
    gain, share, plain, says = np.array([_matched(*each) for each in torques]).T
    wound = np.array([np.ptp(needed) for _, needed, _ in torques]) / model.stiffness
    held = ~data.both & (np.ptp(along.q, axis=0) < WOUND_SPRING_RATIO * wound)
    return Match(gain, share, plain, (says > 0.5) & ~held)


def _needed_and_friction(
    model: FlexibleJointModel, along: SmoothedMotion, j: int, springs: bool
) -> tuple[Array, Array, Array]:
    terms = joint_terms(model, model.all_effects, along, j)
    load = along.inverse_dynamics[:, j]
    if model.elastic[j]:
        load = load + model.rotor_inertia[j] * along.alpha[:, j]
    needed = along.tau[:, j] - terms.motor - terms.link + load
    speed = along.v[:, j]
    turning = speed / (np.abs(speed) + 0.02 * float(np.abs(speed).max()) + 1e-300)
    missing = [np.ones_like(speed), speed, turning, *([along.q[:, j]] if springs else [])]
    return along.tau[:, j], needed, np.stack(missing, axis=1)


def _matched(asked: Array, needed: Array, friction: Array) -> tuple[float, float, float, float]:
    scale = np.abs(friction).max(axis=0)
    basis = np.linalg.qr(friction / np.where(scale > 0.0, scale, 1.0))[0]
    size = float(np.linalg.norm(asked - asked.mean()))
    y, x = (each - basis @ (basis.T @ each) for each in (asked, needed))
    yy, xx, xy = float(y @ y), float(x @ x), float(x @ y)
    tiny = float(np.linalg.norm(needed)) * 1e-9
    if not (yy > (0.05 * size) ** 2 and xx > tiny * tiny) or not np.isfinite(xx):
        return 1.0, 0.0, 0.0, 0.0
    return xy / xx, xy * xy / (xx * yy), 1.0 - (yy - 2.0 * xy + xx) / yy, 1.0


def _both(data: Measured) -> Measured:
    """Replace a missing position by that of the joint's other encoder: deflections are small."""
    theta = np.where(data.has_theta, data.theta, data.q)
    there = np.ones_like(data.has_q)
    return replace(data, q=data.moved, theta=theta, has_q=there, has_theta=there)


def _kernel(dt: float) -> GaussianSmoother:
    return GaussianSmoother.of_width(max(SMOOTHING, 1.25 * dt), dt)


def reach(dt: float) -> int:
    """Number of samples that the filter removes at each end of a recording."""
    return 2 * _kernel(dt).half


def liveliest(data: Measured, seconds: float) -> Measured:
    """The part of a recording of a given length in which its joints move most, relative to their ranges."""
    rows, step = round(seconds / data.dt), max(1, round(0.5 / data.dt))
    if len(data.t) <= rows:
        return data
    x = data.moved
    way = np.abs(x[step::step] - x[:-step:step])
    steps = np.concatenate([[0.0], np.cumsum((way / np.maximum(way.mean(axis=0), 1e-300)).sum(axis=1))])
    width = min(rows // step, len(steps) - 1)
    first = int(np.argmax(steps[width:] - steps[: len(steps) - width])) * step
    return data.part(first, first + rows)


def _every_few(signals: Smoothed) -> Smoothed:
    """Every few samples; laws then act on the smoothed torque, since one that is held has every sample."""
    every = max(1, round(INSTANT_SPACING / signals.dt))
    columns: dict[str, Any] = {k: x[::every] for k, x in vars(signals).items() if isinstance(x, np.ndarray)}
    return replace(signals, **columns, dt=signals.dt * every, held=None, kernel=None, wound=None)
