"""Possible mistakes in a recording, and how well the equations of motion explain the torque with each."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.data.sensors import corrected
from flexdyn.diagnose.equations.motion import Smoothed, SmoothedMotion, motion, smoothed
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.plant import LinkSide

SMOOTHING = 0.012
"""Standard deviation of the filter [s]: wide enough for the acceleration from a coarse encoder."""
INSTANT_SPACING = 0.006
"""Time between the samples that are used [s]."""
DEGREE = 180.0 / np.pi
"""Degrees in a radian."""
SMALLEST_CHECKED_RATIO = 5.0
"""A smaller gear ratio cannot be distinguished from a wrong mass and is not tested [1]."""
UNIT_GAIN_FACTOR, CHANNEL_GAIN_FACTOR = 3.0, 2.0
"""A torque fits a unit, or another assignment of channels, if its gain is 1 within these factors [1]."""
WOUND_SPRING_RATIO = 3.0
"""An elastic joint with one encoder is tested only if it moves by more than this multiple of its deflection [1]."""
EXPLAINED_SHARE = 0.8
"""Share of a torque's variance that must be explained after a mistake is corrected [1]."""
FAR, COURSE = 10.0, 0.3
"""A torque has a wrong unit if its gain exceeds this factor and it explains this share of the needed torque [1]."""
WRONG_SIGN_SHARE = 0.4
"""A torque opposite to the needed one has a wrong sign if it explains this share of it [1]."""


@dataclass(frozen=True)
class Mistake:
    """A possible mistake in the positions and torques of a recording, which can be corrected.

    Attributes:
        problem: in words.
        remedy: what the user can do.
        joints: joints with the mistake.
        order: index of the column with the positions of joint j (n,).
        scale: divisor of its positions (n,).
        torque_order: index of the column with the torques of joint j (n,).
        torque_scale: divisor of its torques (n,).
    """

    problem: str
    remedy: str
    joints: tuple[int, ...]
    order: tuple[int, ...]
    scale: tuple[float, ...]
    torque_order: tuple[int, ...]
    torque_scale: tuple[float, ...]

    @property
    def of_torques(self) -> bool:
        """Whether it changes only factors of torques."""
        straight = tuple(range(len(self.order)))
        return self.order == self.torque_order == straight and all(factor == 1.0 for factor in self.scale)

    @property
    def of_units(self) -> bool:
        """Whether the error of positions is larger than any missing effect could cause."""
        return any(far(factor) for factor in self.scale)

    def undone(self, data: Measured) -> Measured:
        """The recording without the mistake."""
        q, theta = (getattr(data, name)[:, self.order] / np.array(self.scale) for name in ("q", "theta"))
        tau = data.tau[:, self.torque_order] / np.array(self.torque_scale)
        has_q, has_theta = data.has_q[list(self.order)], data.has_theta[list(self.order)]
        return replace(data, q=q, theta=theta, tau=tau, has_q=has_q, has_theta=has_theta)


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
    along = motion(links, _thinned(smoothed(model, links, _both(corrected(data, model)), _kernel(data.dt))))
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
    q = np.where(data.has_q, data.q, data.theta)
    theta = np.where(data.has_theta, data.theta, data.q)
    there = np.ones_like(data.has_q)
    return replace(data, q=q, theta=theta, has_q=there, has_theta=there)


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
    x = np.where(data.has_q, data.q, data.theta)
    way = np.abs(x[step::step] - x[:-step:step])
    steps = np.concatenate([[0.0], np.cumsum((way / np.maximum(way.mean(axis=0), 1e-300)).sum(axis=1))])
    width = min(rows // step, len(steps) - 1)
    first = int(np.argmax(steps[width:] - steps[: len(steps) - width])) * step
    return data.part(first, first + rows)


def _thinned(signals: Smoothed) -> Smoothed:
    every = max(1, round(INSTANT_SPACING / signals.dt))
    columns: dict[str, Any] = {k: x[::every] for k, x in vars(signals).items() if isinstance(x, np.ndarray)}
    return replace(signals, **columns, dt=signals.dt * every)


def far(gain: Array | float) -> Flags:
    """Whether a gain is larger or smaller than missing effects and wrong masses can explain."""
    return np.asarray((np.abs(gain) > FAR) | (np.abs(gain) < 1.0 / FAR))


def needed_share(gain: Array | float) -> Array:
    """Share of the needed torque that must be explained before a wrong unit or sign is assumed."""
    return np.where(far(gain), COURSE, np.where(np.asarray(gain) < 0.0, WRONG_SIGN_SHARE, EXPLAINED_SHARE))


def fits(mistake: Mistake, undone: Match) -> Flags:
    """Whether every torque has the size that the model needs after a mistake is corrected (n,)."""
    within = UNIT_GAIN_FACTOR if mistake.of_torques or mistake.of_units else CHANNEL_GAIN_FACTOR
    return np.asarray((undone.gain > 1.0 / within) & (undone.gain < within))


def wanted_share(mistake: Mistake, gain: Array) -> Array:
    """Share of every torque's variance (n,) to be explained after a mistake is corrected; `gain` is the present one."""
    if mistake.of_torques:
        return needed_share(gain)
    return np.where(far(gain) & mistake.of_units, COURSE, EXPLAINED_SHARE)


def mistakes(model: FlexibleJointModel, seen: Match) -> Iterator[Mistake]:
    """Mistakes to be tested; those of torques have the measured factors."""
    n = model.n
    convincing = [j for j in range(n) if seen.share[j] >= needed_share(seen.gain[j])]
    units = {j: unit for j in convincing if (unit := torque_unit(model, j, float(seen.gain[j])))}
    if units:
        yield _of_torques(model, units)
    for i, k in itertools.combinations(range(n), 2):
        yield from _swaps(model, i, k)
    groups = [(j,) for j in range(n)] + ([tuple(range(n))] if n > 1 else [])
    for joints in groups:
        yield from _of_positions(model, joints)


def torque_unit(model: FlexibleJointModel, j: int, gain: float) -> tuple[float, str, str] | None:
    """The error factor of a torque, its probable cause and the remedy; None if it seems right."""
    name, ratio = model.joint_names[j], list(model.joints.values())[j].gear_ratio
    unit = "N" if model.robot.kinds[j] == "prismatic" else "N m"
    known = [
        (-1.0, "its sign, or that of the joint's positions, is flipped", f"change the sign of tau.{name}"),
        (1e3, f"it looks like m{unit}", f"divide tau.{name} by 1000 ({unit} are wanted)"),
        (1e-3, f"it looks like k{unit}", f"multiply tau.{name} by 1000 ({unit} are wanted)"),
    ]
    if abs(ratio) > SMALLEST_CHECKED_RATIO:
        motor = f"multiply tau.{name} by the gear ratio {ratio:g} (torques are reflected to the link side)"
        twice = f"divide tau.{name} by the gear ratio {ratio:g}"
        known += [(1.0 / ratio, "it looks like the motor shaft's", motor), (ratio, "it looks reflected twice", twice)]
    if gain == 0.0 or not np.isfinite(gain) or 1.0 / UNIT_GAIN_FACTOR < gain < UNIT_GAIN_FACTOR:
        return None
    near = [entry for entry in known if 1.0 / _width(entry[0]) < gain / entry[0] < _width(entry[0])]
    return min(near, key=lambda entry: abs(np.log(gain / entry[0]))) if near else None


def _width(factor: float) -> float:
    """Tolerance for a gain to match a factor; a sign does not change the size."""
    return CHANNEL_GAIN_FACTOR if factor == -1.0 else UNIT_GAIN_FACTOR


def _blank(model: FlexibleJointModel, problem: str, remedy: str, joints: tuple[int, ...]) -> Mistake:
    straight, ones = tuple(range(model.n)), (1.0,) * model.n
    return Mistake(problem, remedy, joints, straight, ones, straight, ones)


def _of_torques(model: FlexibleJointModel, units: dict[int, tuple[float, str, str]]) -> Mistake:
    first = min(units)
    also = "".join(f", tau.{model.joint_names[j]} too" for j in sorted(units) if j != first)
    problem = f"the torque is not the one that the model needs: {units[first][1]}{also}"
    scale = tuple(units[j][0] if j in units else 1.0 for j in range(model.n))
    return replace(_blank(model, problem, units[first][2], tuple(sorted(units))), torque_scale=scale)


def _swaps(model: FlexibleJointModel, i: int, k: int) -> Iterator[Mistake]:
    one, two = model.joint_names[i], model.joint_names[k]
    order = list(range(model.n))
    order[i], order[k] = k, i
    swapped, joints = tuple(order), (i, k)
    torques = _blank(model, f"the torques of {one} and {two} look swapped", f"exchange tau.{one} and tau.{two}", joints)
    positions = _blank(
        model, f"the positions of {one} and {two} look swapped", f"exchange the positions of {one} and {two}", joints
    )
    whole = _blank(model, f"the joints {one} and {two} look swapped", f"exchange the names {one} and {two}", joints)
    if model.robot.kinds[i] == model.robot.kinds[k]:
        yield replace(torques, torque_order=swapped)
        yield replace(positions, order=swapped)
        yield replace(whole, order=swapped, torque_order=swapped)


def _of_positions(model: FlexibleJointModel, joints: tuple[int, ...]) -> Iterator[Mistake]:
    names = ", ".join(model.joint_names[j] for j in joints)
    them = f"the positions of {names}"

    def made(problem: str, remedy: str, factors: list[float]) -> Mistake:
        scale = [1.0] * model.n
        for j, factor in zip(joints, factors, strict=True):
            scale[j] = factor
        return replace(_blank(model, f"{them} {problem}", remedy, joints), scale=tuple(scale))

    turns = [model.robot.kinds[j] != "prismatic" for j in joints]
    ratios = [list(model.joints.values())[j].gear_ratio for j in joints]
    wide = [ratio if abs(ratio) > SMALLEST_CHECKED_RATIO else 1.0 for ratio in ratios]
    unit = "degrees" if all(turns) else "mm" if not any(turns) else "degrees and mm"
    right = "rad" if all(turns) else "m" if not any(turns) else "rad and m"
    near = ", or divide them by the gear ratio if they are the motor shaft's"
    doubtful = any(turn and 0.8 < abs(r) / DEGREE < 1.25 for turn, r in zip(turns, ratios, strict=True))
    yield made(
        f"look like {unit}",
        f"give them in {right}{near if doubtful else ''}",
        [DEGREE if turn else 1e3 for turn in turns],
    )
    yield made("have a flipped sign", "change their sign", [-1.0] * len(joints))
    flipped = made("and its torque have a flipped sign", "change both signs", [-1.0] * len(joints))
    yield replace(flipped, torque_scale=flipped.scale)
    if any(factor != 1.0 for factor in wide):
        remedy = f"divide them by the gear ratio {', '.join(f'{ratio:g}' for ratio in ratios)}"
        on_motor = made("look like the motor shaft's", remedy, wide)
        yield on_motor
        both = made("and its torque look like the motor shaft's", f"{remedy} and multiply the torque by it", wide)
        yield replace(both, torque_scale=tuple(1.0 / factor for factor in both.scale))
