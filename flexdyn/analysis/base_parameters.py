"""base_parameters: the combinations of a model's numbers that a motion determines, and how well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.analysis.analysed_model import checked_model
from flexdyn.analysis.regressor import FRICTION, Along, along_recording, along_samples, body_numbers, regressor
from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import OF_LINK
from flexdyn.model.uncertain_parameters import file_numbers

OWN = 1e-7
"""A column is independent if this share of its length is outside the span of the columns before it [1]."""


@dataclass(frozen=True)
class Combination(Locked):
    """One number that the motion tells: a sum of numbers of the model.

    Attributes:
        terms: coefficient by number; the first one is 1.
        value: of the model, in the unit of the first number.
        std: standard deviation of its least-squares estimate with all combinations free, in the same unit.
    """

    terms: Mapping[str, float]
    value: float
    std: float

    def __str__(self) -> str:
        """The sum."""
        parts = [f"{'-' if k < 0 else '+'} {_factor(abs(k))}{name}" for name, k in self.terms.items()]
        return " ".join(parts).removeprefix("+ ")


@dataclass(frozen=True)
class Told:
    """A number of the model file or URDF, and whether the motion determines it.

    Attributes:
        of: joint or link that it belongs to.
        parameter: ``link_mass``, ``link_com``, ``link_inertia`` or ``rotor_inertia``.
        verdict: ``told``: determined better than its tolerance, with all others unknown. ``weak``: worse than that.
            ``combined``: only together with others, even without noise. ``silent``: it has no influence.
        std: of its factor, with all other numbers unknown [1]; inf where it is combined or silent.
        tolerance: of the file, relative [1].
    """

    of: str
    parameter: str
    verdict: str
    std: float
    tolerance: float


@dataclass(frozen=True)
class BaseParameters:
    """The numbers of a model that a motion determines.

    Attributes:
        combinations: the base parameters: independent sums, with their first numbers in the order of the arm.
        silent: numbers that have no influence in this motion.
        condition: condition number of the columns of the combinations, each scaled to unit length [1]. Below 100 the
            motion is good; above 1000 some combination can hardly be separated from others.
        samples: number of samples of the motion that were used.
        numbers: of the model file and URDF.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> told = fd.base_parameters(run.model, run.to_recording(), noise=0.02)
        >>> sorted({number.verdict for number in told.numbers} - {"told", "weak", "combined", "silent"})
        []
    """

    combinations: tuple[Combination, ...]
    silent: tuple[str, ...]
    condition: float
    samples: int
    numbers: tuple[Told, ...]

    @property
    def rank(self) -> int:
        """Number of combinations."""
        return len(self.combinations)

    @property
    def alone(self) -> tuple[str, ...]:
        """Numbers that the motion determines individually."""
        return tuple(next(iter(each.terms)) for each in self.combinations if len(each.terms) == 1)

    @property
    def combined(self) -> tuple[str, ...]:
        """Numbers that it determines only in sums."""
        sums = (each.terms for each in self.combinations if len(each.terms) > 1)
        return tuple(dict.fromkeys(name for terms in sums for name in terms))

    def __str__(self) -> str:
        """One line for each combination: value, standard deviation, sum."""
        head = f"{self.rank} combinations from {self.samples} samples, condition {self.condition:.3g}"
        lines = [f"{each.value:>12.4g} +- {each.std:<10.2g} {each}" for each in self.combinations]
        return "\n".join([head, *lines, f"silent: {', '.join(self.silent) or 'none'}"])


def _factor(k: float) -> str:
    return "" if abs(k - 1.0) < 1e-9 else f"{k:.4g} "


def base_parameters(
    model: FlexibleJointModel,
    motion: Any = None,
    *,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    a: ArrayLike | None = None,
    noise: ArrayLike = 1.0,
    friction: bool = False,
) -> BaseParameters:
    """The independent combinations of an arm's numbers that the torques of a motion determine, and how well.

    Torques are linear in masses, first moments, inertias, rotor inertias and friction, ``tau = W p``. A column of W
    that depends linearly on columns before it is added to these (Gautier and Khalil, IEEE Trans. Robotics and
    Automation 6, 1990; Gautier, J. Robotic Systems 8, 1991). Springs do not enter, because the sum of the equations of
    link and motor is used.

    Args:
        model: the arm; its numbers are used only for `value` and tolerances.
        motion: a recording (or a run, a path, a pandas.DataFrame) with q or theta of every joint, smoothed and
            differentiated here; its torque is not read.
        q: or samples of a motion: positions (samples, n) [rad]; random samples show what the best motion can determine.
        v: velocities, likewise [rad/s].
        a: accelerations, likewise [rad/s^2].
        noise: standard deviation of the torques, white from sample to sample, one number or n of them [N m or N].
        friction: whether viscous friction, Coulomb friction and a constant torque of every joint are unknown too.

    Returns:
        Combinations with standard deviations, conditioning, and a verdict on every number of file and URDF.

    Raises:
        InputError: neither a recording nor q, v and a; wrong shapes; a joint without position; a noise not above 0.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> told = fd.base_parameters(run.model, run.to_recording(), noise=0.02)
        >>> told.rank <= len(told.numbers)
        True
    """
    true = checked_model(model)
    along = _motion(true, motion, q, v, a)
    sigma = np.asarray(noise, dtype=float)
    if sigma.shape not in ((), (true.n,)) or not (np.isfinite(sigma) & (sigma > 0.0)).all():
        raise InputError("one level above 0 is needed, or one for each joint", key="noise", value=noise)
    whole = regressor(true, along.q, along.v, along.a, along.omega, along.alpha)
    wanted = np.array([friction or name.rpartition(".")[2] not in FRICTION for name in whole.names])
    weights = np.tile(np.sqrt(along.every) / np.broadcast_to(sigma, (true.n,)), len(along.q))
    W, p = whole.columns[:, wanted] * weights[:, None], whole.values[wanted]
    names = tuple(name for name, kept in zip(whole.names, wanted, strict=True) if kept)
    combinations, silent, condition = _combinations(names, W, p)
    numbers = _numbers(model, names, W, friction)
    return BaseParameters(combinations, silent, condition, len(along.q), numbers)


def _motion(model: FlexibleJointModel, motion: Any, *samples: ArrayLike | None) -> Along:
    given = [each for each in samples if each is not None]
    if (motion is None) == (not given) or (given and len(given) < len(samples)):
        raise InputError("a motion is needed", key="motion", remedy="give a recording, or q, v and a")
    if motion is not None:
        return along_recording(model, motion)
    return along_samples(model, *(np.asarray(each, dtype=float) for each in given))


def _combinations(names: tuple[str, ...], W: Array, p: Array) -> tuple[tuple[Combination, ...], tuple[str, ...], float]:
    """Independent columns with the columns that they absorb, names without a column, and the conditioning."""
    length = np.linalg.norm(W, axis=0)
    seen = length > OWN * length.max()
    scaled = W[:, seen] / length[seen]
    R: Array = np.asarray(np.linalg.qr(scaled, mode="r"))
    own = np.zeros(scaled.shape[1], dtype=bool)
    own[: len(R)] = np.abs(np.diag(R)) > OWN
    B, rest = R[:, own], R[:, ~own]
    share = np.linalg.lstsq(B, rest, rcond=None)[0]
    share[np.abs(share) < np.sqrt(OWN)] = 0.0
    names_, length_, p_ = np.array(names)[seen], length[seen], p[seen]
    std = np.sqrt(np.diag(np.linalg.inv(B.T @ B))) / length_[own]
    coefficients = share * length_[~own] / length_[own][:, None]
    found = []
    for k, name in enumerate(names_[own]):
        terms = {str(name): 1.0}
        terms |= {str(n): float(c) for n, c in zip(names_[~own], coefficients[k], strict=True) if c}
        value = p_[own][k] + coefficients[k] @ p_[~own]
        found.append(Combination(terms, float(value), float(std[k])))
    return tuple(found), tuple(np.array(names)[~seen].tolist()), float(np.linalg.cond(B))


def _numbers(model: FlexibleJointModel, names: tuple[str, ...], W: Array, friction: bool) -> tuple[Told, ...]:
    """A verdict on every number of links and rotors; friction may be unknown in addition."""
    wanted = [each for each in file_numbers(model) if each.parameter in ("rotor_inertia", *OF_LINK)]
    place = {name: k for k, name in enumerate(names)}
    columns = []
    for number in wanted:
        if number.parameter == "rotor_inertia":
            at = place[f"{number.of}.J"]
            columns.append(W[:, at] * float(model.rotor_inertia[model.index(number.of)]))
        else:
            change = _of_link(model, number.of, OF_LINK[number.parameter])
            columns.append(W[:, : len(change)] @ change)
    others = [k for name, k in place.items() if friction and name.rpartition(".")[2] in FRICTION]
    if not columns:
        return ()
    whole: Array = np.asarray(np.linalg.qr(np.stack([*columns, *W[:, others].T], axis=1), mode="r"))
    length = np.linalg.norm(whole, axis=0)
    told = []
    for k, number in enumerate(wanted):
        std, verdict = np.inf, "silent"
        if length[k] > OWN * length.max():
            rest = [i for i in range(whole.shape[1]) if i != k and length[i] > 0.0]
            unit, base = whole[:, k] / length[k], whole[:, rest] / length[rest]
            left = float(np.linalg.norm(unit - base @ np.linalg.lstsq(base, unit, rcond=OWN)[0]))
            std = 1.0 / (left * length[k]) if left > OWN else np.inf
            verdict = "combined" if np.isinf(std) else "told" if std < number.tolerance else "weak"
        told.append(Told(number.of, number.parameter, verdict, float(std), number.tolerance))
    return tuple(told)


def _of_link(model: FlexibleJointModel, link: str, word: str) -> Array:
    """Derivative of the bodies' numbers by the factor of a link's number (10 m,): they are at most quadratic in it."""
    step = 0.125
    low, high = (body_numbers(model.robot.with_link_scaled(link, **{word: f}).tree) for f in (1 - step, 1 + step))
    return (high - low) / (2.0 * step)
