"""Possible mistakes in a recording: units, signs, sides of a gear, and channels that were exchanged."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.match import Match
from flexdyn.model.flexible_joint_model import FlexibleJointModel

DEGREE = 180.0 / np.pi
"""Degrees in a radian."""
SMALLEST_CHECKED_RATIO = 5.0
"""A smaller gear ratio cannot be distinguished from a wrong mass and is not tested [1]."""
UNIT_GAIN_FACTOR, CHANNEL_GAIN_FACTOR = 3.0, 2.0
"""A torque fits a unit, or another assignment of channels, if its gain is 1 within these factors [1]."""
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
        order: index of the column with the positions of joint j (n,); empty: its own.
        scale: divisor of its positions, by joint; 1 of others.
        torque_order: index of the column with the torques of joint j (n,); empty: its own.
        torque_scale: divisor of its torques, by joint; 1 of others.
    """

    problem: str
    remedy: str
    joints: tuple[int, ...]
    order: tuple[int, ...] = ()
    scale: Mapping[int, float] = field(default_factory=dict)
    torque_order: tuple[int, ...] = ()
    torque_scale: Mapping[int, float] = field(default_factory=dict)

    @property
    def of_positions(self) -> bool:
        """Whether it changes positions."""
        return bool(self.order or self.scale)

    @property
    def of_torques(self) -> bool:
        """Whether it changes only factors of torques."""
        return not (self.of_positions or self.torque_order)

    @property
    def of_units(self) -> bool:
        """Whether the error of positions is larger than any missing effect could cause."""
        return any(far(factor) for factor in self.scale.values())

    def undone(self, data: Measured) -> Measured:
        """The recording without the mistake."""
        straight = list(range(len(data.has_q)))
        order, torque_order = (list(each) or straight for each in (self.order, self.torque_order))
        scale, torque_scale = (np.array([f.get(j, 1.0) for j in straight]) for f in (self.scale, self.torque_scale))
        q, theta = data.q[:, order] / scale, data.theta[:, order] / scale
        tau = data.tau[:, torque_order] / torque_scale
        return replace(data, q=q, theta=theta, tau=tau, has_q=data.has_q[order], has_theta=data.has_theta[order])


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
        yield _torque_mistake(model, units)
    for i, k in itertools.combinations(range(n), 2):
        yield from _swaps(model, i, k)
    groups = [(j,) for j in range(n)] + ([tuple(range(n))] if n > 1 else [])
    for joints in groups:
        yield from _of_positions(model, joints)


def torque_unit(model: FlexibleJointModel, j: int, gain: float) -> tuple[float, str, str] | None:
    """The error factor of a torque, its probable cause and the remedy; None if it seems right."""
    name, unit = model.joint_names[j], model.robot.torque_unit(j)
    ratio = model.joints[name].gear_ratio
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


def _torque_mistake(model: FlexibleJointModel, units: dict[int, tuple[float, str, str]]) -> Mistake:
    first, *others = sorted(units)
    also = "".join(f", tau.{model.joint_names[j]} too" for j in others)
    problem = f"the torque is not the one that the model needs: {units[first][1]}{also}"
    scale = {j: factor for j, (factor, _, _) in units.items()}
    return Mistake(problem, units[first][2], (first, *others), torque_scale=scale)


def _swaps(model: FlexibleJointModel, i: int, k: int) -> Iterator[Mistake]:
    if model.robot.kinds[i] != model.robot.kinds[k]:
        return
    one, two = model.joint_names[i], model.joint_names[k]
    order = tuple({i: k, k: i}.get(j, j) for j in range(model.n))
    for what, remedy, positions, torques in (
        ("torques of", f"exchange tau.{one} and tau.{two}", (), order),
        ("positions of", f"exchange the positions of {one} and {two}", order, ()),
        ("joints", f"exchange the names {one} and {two}", order, order),
    ):
        problem = f"the {what} {one} and {two} look swapped"
        yield Mistake(problem, remedy, (i, k), order=positions, torque_order=torques)


def _of_positions(model: FlexibleJointModel, joints: tuple[int, ...]) -> Iterator[Mistake]:
    names = ", ".join(model.joint_names[j] for j in joints)

    def made(problem: str, remedy: str, factors: list[float], torques: list[float] | None = None) -> Mistake:
        """What is wrong with the positions, and their factors."""
        scale, torque_scale = (dict(zip(joints, each, strict=False)) for each in (factors, torques or []))
        return Mistake(f"the positions of {names} {problem}", remedy, joints, scale=scale, torque_scale=torque_scale)

    turns = [model.robot.kinds[j] != "prismatic" for j in joints]
    ratios = [model.joints[model.joint_names[j]].gear_ratio for j in joints]
    wide = [ratio if abs(ratio) > SMALLEST_CHECKED_RATIO else 1.0 for ratio in ratios]
    unit, right = ("degrees", "rad") if all(turns) else ("degrees and mm", "rad and m") if any(turns) else ("mm", "m")
    doubtful = any(turn and 0.8 < abs(r) / DEGREE < 1.25 for turn, r in zip(turns, ratios, strict=True))
    near = ", or divide them by the gear ratio if they are the motor shaft's" if doubtful else ""
    yield made(f"look like {unit}", f"give them in {right}{near}", [DEGREE if turn else 1e3 for turn in turns])
    back = [-1.0] * len(joints)
    yield made("have a flipped sign", "change their sign", back)
    yield made("and its torque have a flipped sign", "change both signs", back, back)
    if any(factor != 1.0 for factor in wide):
        remedy = f"divide them by the gear ratio {', '.join(f'{ratio:g}' for ratio in ratios)}"
        yield made("look like the motor shaft's", remedy, wide)
        both, inverse = f"{remedy} and multiply the torque by it", [1.0 / factor for factor in wide]
        yield made("and its torque look like the motor shaft's", both, wide, inverse)
