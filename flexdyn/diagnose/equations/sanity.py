"""Checks of the recordings before the diagnosis: one line says what is wrong or missing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.channel_noise import encoder_noise
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.mistakes import (
    DEGREE,
    EXPLAINED_SHARE,
    SMALLEST_CHECKED_RATIO,
    WOUND_SPRING_RATIO,
    Match,
    Mistake,
    far,
    fits,
    liveliest,
    match,
    mistakes,
    reach,
    wanted_share,
)
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import file_numbers
from flexdyn.simulation.plant import LinkSide

LEAST_MOVING_TIME = 1.5
"""Smallest time of motion in all recordings of the fit together [s]: three windows of 0.5 s."""
SHORTEST_RECORDING = 0.5
"""Smallest length of one recording [s]: a window."""
REMEDY = (
    f"at least {LEAST_MOVING_TIME:g} s of motion to fit are needed, three windows of 0.5 s; several short recordings"
    " add up; without test data of their own (check), the last fifth is kept as test data, and at least 1 s"
)
LEAST_RATE = 20.0
"""Smallest rate [Hz]: below it accelerations of an arm cannot be seen, and the clock is probably in ms."""
MOVING_SIGMAS = 10.0
"""A joint moves if the range of its positions exceeds this number of standard deviations of the encoder's noise [1]."""
ENCODERS_ALIKE_SHARE = 0.9
"""Smallest common share of the variance of the two encoders of a joint [1]."""
DEAD_ENCODER_SHARE = 1e-3
"""An encoder does not work if its range is below this share of the range of the joint's other one [1]."""
POOR_VARIANCE_SHARE = 0.7
"""Mistakes are searched if a model explains less of a torque's variance [1]."""
LIVELIEST_LENGTH = 12.0
"""Length of the part of a recording with the most motion, in which mistakes are searched [s]."""
BETTER_BY_SHARE = 0.2
"""The correction of a mistake of several joints must explain this additional share of each torque, or all of it [1]."""
NOTED_VARIANCE_SHARE = 0.5
"""If less than this share of a torque's variance is explained, there is a note [1]."""
SIZE_WEIGHT = 0.1
"""Penalty in explained share for torques of the wrong size, for a factor of e [1]."""
UNCHECKED = "Units and signs of the torques were not checked, as numbers of the model are not known."
BELIEVED_RATIO = 5.0
"""A mistake is accepted only if its correction reduces the unexplained share by this factor [1]."""


def check_recordings(model: FlexibleJointModel, data: tuple[Measured, ...]) -> tuple[str, ...]:
    """Refuse data that cannot be diagnosed.

    A missing effect changes a torque partly; a wrong unit, sign, joint or clock changes it completely. So a recording
    is refused only if the correction of one such mistake explains the torque and the given recording does not.

    Args:
        model: as given.
        data: the recordings, on uniform clocks.

    Returns:
        Notes, one sentence each, about suspicious properties without a clear cause.

    Raises:
        InputError: it names the recording, the channel, the value and the remedy.
    """
    true = model.resolved()
    for each in data:
        _check_clock(each)
        _check_encoders(true, each)
    _check_torques(true, data)
    _check_motion(true, data)
    if any(number.is_open for number in file_numbers(model)):
        return (UNCHECKED, *_passive(true, data))
    links = LinkSide(true)
    notes = [note for each in data for note in _check_equations(true, links, each)]
    return (*notes, *_passive(true, data))


def _check_clock(data: Measured) -> None:
    if data.dt > 1.0 / LEAST_RATE:
        remedy = "times are in s: divide them by 1000 if they are in ms; else record at 100 Hz or more"
        problem = f"samples {data.dt:g} s apart are too far apart to show an arm's accelerations"
        raise InputError(problem, file=data.name, key="t", remedy=remedy)
    length = data.dt * (len(data.t) - 1)
    if length < SHORTEST_RECORDING - data.dt or len(data.t) <= 2 * reach(data.dt):
        raise InputError("the recording is too short", file=data.name, key="t", value=f"{length:.3g} s", remedy=REMEDY)


def _check_torques(model: FlexibleJointModel, data: Sequence[Measured]) -> None:
    """Refuse a torque that never changes, unless it is zero, as for a passive joint."""
    for j, joint in enumerate(model.joint_names):
        held = [float(each.tau[0, j]) for each in data]
        constant = all((each.tau[:, j] == each.tau[0, j]).all() for each in data)
        if constant and (any(held) or all((each.tau == each.tau[:1]).all() for each in data)):
            remedy = "record the commanded torque while it changes: a motion with accelerations and reversals"
            value = f"{held[0]:g} throughout"
            problem = "the torque is constant"
            raise InputError(problem, file=data[0].name, key=f"tau.{joint}", value=value, remedy=remedy)


def _check_motion(model: FlexibleJointModel, data: Sequence[Measured]) -> None:
    signals = [("theta" if each.has_theta[j] else "q") for each in data[:1] for j in range(model.n)]
    noise = [encoder_noise(tuple(data), signal) for signal in ("q", "theta")]
    for j, (joint, signal) in enumerate(zip(model.joint_names, signals, strict=True)):
        sigma = float(noise[signal == "theta"][j])
        wide = max(_range(getattr(each, signal)[:, j], each.dt) for each in data)
        if wide <= MOVING_SIGMAS * sigma:
            remedy = f"move it, or lock it in the model (robot.lock: {{{joint}: ...}})"
            problem = "the joint does not move beyond its encoder's noise"
            value = f"a range of {wide:.2g} at a noise of {sigma:.2g}"
            raise InputError(problem, file=data[0].name, key=f"{signal}.{joint}", value=value, remedy=remedy)
    moving = sum(_moving_time(each, signals, noise) for each in data)
    if moving < LEAST_MOVING_TIME:
        problem = "hardly anything moves in the recording"
        if len(data) > 1:
            problem = "hardly anything moves in the recordings"
        raise InputError(problem, file=data[0].name, key="t", value=f"{moving:.2g} s of motion", remedy=REMEDY)


def _range(x: Array, dt: float) -> float:
    """Range of a position (samples,), averaged over 20 ms to reduce noise."""
    width = min(max(1, round(0.02 / dt)), len(x))
    means = x[: len(x) // width * width].reshape(-1, width).mean(axis=1)
    return float(means.max() - means.min())


def _moving_time(data: Measured, signals: Sequence[str], noise: Sequence[Array]) -> float:
    """Time in which some joint moves by more than its noise, in blocks of 0.1 s [s]."""
    width = max(1, round(0.1 / data.dt))
    blocks = len(data.t) // width
    moves = np.zeros(blocks, dtype=bool)
    for j, signal in enumerate(signals):
        x = getattr(data, signal)[: blocks * width, j].reshape(blocks, width)
        spread = x.max(axis=1) - x.min(axis=1)
        moves |= spread > MOVING_SIGMAS * float(noise[signal == "theta"][j])
    return float(moves.sum()) * width * data.dt


def _check_encoders(model: FlexibleJointModel, data: Measured) -> None:
    """Check that both positions of a joint are nearly the same: deflections are small.

    If friction or the motor holds one side of a joint, the other side may move by the deflection alone.
    """
    both = np.flatnonzero(data.both)
    for j in both:
        joint = model.joint_names[j]
        wound = WOUND_SPRING_RATIO * float(np.abs(data.tau[:, j]).max()) / float(model.stiffness[j])
        if max(np.ptp(data.q[:, j]), np.ptp(data.theta[:, j])) <= wound:
            continue
        for dead, alive in (("q", "theta"), ("theta", "q")):
            x, y = getattr(data, dead)[:, j], getattr(data, alive)[:, j]
            if np.ptp(x) < DEAD_ENCODER_SHARE * np.ptp(y):
                problem, remedy = f"it rests while {alive}.{joint} moves", f"leave out {dead}.{joint}"
                value = f"a range of {np.ptp(x):.2g} against {np.ptp(y):.2g}"
                raise InputError(problem, file=data.name, key=f"{dead}.{joint}", value=value, remedy=remedy)
        slope, share = _line(data.q[:, j], data.theta[:, j])
        if share > ENCODERS_ALIKE_SHARE and 0.5 < slope < 2.0:
            continue
        for factor, problem, remedy in sorted(_looks(model, int(j)), key=lambda look: abs(slope / look[0] - 1.0)):
            if share > EXPLAINED_SHARE and 0.8 < slope / factor < 1.25:
                value = f"theta = {slope:.4g} q"
                raise InputError(problem, file=data.name, key=f"theta.{joint}", value=value, remedy=remedy)
        for i in both:
            other, alike = _line(data.q[:, i], data.theta[:, j])
            if i != j and share < ENCODERS_ALIKE_SHARE and alike > 0.99 and 0.8 < abs(other) < 1.25:
                there = model.joint_names[i]
                problem = f"theta follows the q of {there}, and not that of its own joint"
                remedy = f"exchange theta.{joint} and theta.{there}, or their q"
                value = f"correlation {np.sqrt(alike):.3f} against {np.sqrt(share):.3f}"
                raise InputError(problem, file=data.name, key=f"theta.{joint}", value=value, remedy=remedy)


def _looks(model: FlexibleJointModel, j: int) -> list[tuple[float, str, str]]:
    """Slopes of theta over q for possible mistakes, with the mistake and the remedy."""
    joint, ratio = model.joint_names[j], list(model.joints.values())[j].gear_ratio
    small, unit = ("mm", 1e3) if model.robot.kinds[j] == "prismatic" else ("degrees", DEGREE)
    looks = [
        (-1.0, "theta and q have opposite signs", f"change the sign of theta.{joint} or q.{joint}"),
        (unit, f"theta is in {small} and q is not", f"convert theta.{joint}"),
        (1.0 / unit, f"q is in {small} and theta is not", f"convert q.{joint}"),
    ]
    if abs(ratio) <= SMALLEST_CHECKED_RATIO:
        return looks
    remedy = f"divide theta.{joint} by the gear ratio {ratio:g} (side: motor)"
    turned = f"divide theta.{joint} by {-ratio:g}"
    return [
        (ratio, "theta is the motor's angle", remedy),
        (-ratio, "theta is the motor's angle, flipped", turned),
        *looks,
    ]


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope of y over x, and their common share of variance."""
    dx, dy = x - x.mean(), y - y.mean()
    xx, yy, xy = float(dx @ dx), float(dy @ dy), float(dx @ dy)
    if xx == 0.0 or yy == 0.0:
        return 0.0, 0.0
    return xy / xx, xy * xy / (xx * yy)


def _check_equations(model: FlexibleJointModel, links: LinkSide, data: Measured) -> Iterator[str]:
    """Refuse the recording if the correction of one mistake explains the torques far better."""
    seen = match(model, links, data)
    poor = seen.says & (seen.plain < POOR_VARIANCE_SHARE)
    if poor.any():
        _check_mistakes(model, links, liveliest(data, LIVELIEST_LENGTH))
    for j in np.flatnonzero(poor):
        joint, gain, share = model.joint_names[j], float(seen.gain[j]), float(seen.share[j])
        if share > EXPLAINED_SHARE and far(gain):
            remedy = f"check the unit of tau.{joint} and the masses of the model"
            problem = "the torque has the right shape and the wrong size"
            value = f"{gain:.3g} times what the model needs"
            raise InputError(problem, file=data.name, key=f"tau.{joint}", value=value, remedy=remedy)
        if (share > NOTED_VARIANCE_SHARE and 0.5 < gain < 2.0) or data.forced[j]:  # a rig tests what models lack
            continue
        yield (
            f"In {data.name or 'the recording'} the torque of {joint} follows what the model needs only loosely: at "
            f"{gain:.2g} times it, with {100.0 * share:.0f} % of its variance."
        )


def _check_mistakes(model: FlexibleJointModel, links: LinkSide, data: Measured) -> None:
    seen = match(model, links, data)
    poor = seen.says & (seen.plain < POOR_VARIANCE_SHARE)
    best: tuple[float, Mistake, Match] | None = None
    for mistake in mistakes(model, seen) if poor.any() else ():
        undone = match(model, links, mistake.undone(data))
        merit = _merit(seen, undone, mistake, poor)
        if merit is not None and mistake.of_units and not _beyond_springs(model, links, data, mistake):
            continue
        if merit is not None and (best is None or merit > best[0] + 0.02):
            best = (merit, mistake, undone)
    if best is not None:
        raise _refused(data, model.joint_names, seen, *best[1:])


def _beyond_springs(model: FlexibleJointModel, links: LinkSide, data: Measured, mistake: Mistake) -> bool:
    """Whether another unit of the positions explains more than a missing spring would."""
    sprung, undone = (match(model, links, each, springs=True) for each in (data, mistake.undone(data)))
    return all(undone.says[j] and undone.share[j] > sprung.plain[j] + BETTER_BY_SHARE for j in mistake.joints)


def _merit(seen: Match, undone: Match, mistake: Mistake, poor: Flags) -> float | None:
    """Mean explained share after correcting a mistake, minus the penalty for the size; None if it is too small."""
    known = seen.says | undone.says
    now = np.where(fits(mistake, undone), undone.share, 0.0)
    before = np.clip(seen.plain, 0.0, 1.0)
    wanted = wanted_share(mistake, seen.gain)
    healed = poor & (now >= wanted) & ((1.0 - now < (1.0 - before) / BELIEVED_RATIO) | (wanted < EXPLAINED_SHARE))
    named = [j for j in mistake.joints if known[j]]
    better = (now >= wanted) | (now > before + BETTER_BY_SHARE)
    if not named or not healed[known].any() or not better[named].all() or (now < before - 0.1)[known].any():
        return None
    off = np.abs(np.log(np.maximum(np.abs(undone.gain[named]), 1e-9))).mean()
    return float(now[known].mean() - SIZE_WEIGHT * off)


def _refused(data: Measured, joints: Sequence[str], seen: Match, mistake: Mistake, undone: Match) -> InputError:
    """The error for an accepted mistake; it names the joint for which the correction explains most."""
    j = max(mistake.joints, key=lambda i: float(undone.share[i]) - max(float(seen.plain[i]), 0.0))
    if mistake.of_torques:
        j, value = mistake.joints[0], f"{seen.gain[mistake.joints[0]]:.3g} times what the model needs"
    else:
        before, after = 100.0 * max(float(seen.plain[j]), 0.0), 100.0 * float(undone.share[j])
        value = f"{before:.0f} % of the torque explained as given, {after:.0f} % without the mistake"
    moved = mistake.order != tuple(range(len(joints))) or any(factor != 1.0 for factor in mistake.scale)
    signal = "tau" if not moved else "q" if data.has_q[j] else "theta"
    return InputError(mistake.problem, file=data.name, key=f"{signal}.{joints[j]}", value=value, remedy=mistake.remedy)


def _passive(model: FlexibleJointModel, data: Sequence[Measured]) -> Iterator[str]:
    for j, joint in enumerate(model.joint_names):
        if all((each.tau[:, j] == 0.0).all() for each in data):
            yield f"No torque is ever asked of {joint}: what scales its torque cannot be told."
