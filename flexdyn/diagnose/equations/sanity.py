"""Checks of the recordings before the diagnosis: one line says what is wrong or missing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import REST_SIGMAS
from flexdyn.diagnose.data.channel_noise import encoder_noise
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.both_encoders import check_encoders
from flexdyn.diagnose.equations.match import reach
from flexdyn.diagnose.equations.units_and_signs import check_equations
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.uncertain_parameters import file_numbers
from flexdyn.simulation.link_side import LinkSide

LEAST_MOVING_TIME = 1.5
"""Smallest time of motion in all recordings of the fit together [s]: three windows of 0.5 s."""
SHORTEST_RECORDING = 0.5
"""Smallest length of one recording [s]: a window."""
REMEDY = (
    f"at least {LEAST_MOVING_TIME:g} s of motion to fit are needed, three windows of 0.5 s; several short recordings"
    " add up"
)
LEAST_RATE = 20.0
"""Smallest rate [Hz]: below it accelerations of an arm cannot be seen, and the clock is probably in ms."""
UNCHECKED = "Units and signs of the torques were not checked, as numbers of the model are not known."


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
        check_encoders(true, each)
    _check_torques(true, data)
    _check_motion(true, data)
    if any(number.is_open for number in file_numbers(model)):
        return (UNCHECKED, *_passive(true, data))
    links = LinkSide(true)
    notes = [note for each in data for note in check_equations(true, links, each)]
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
    signals, noise = _positions(data)
    for j, (joint, signal) in enumerate(zip(model.joint_names, signals, strict=True)):
        sigma = float(noise[signal == "theta"][j])
        wide = max(_range_of_motion(getattr(each, signal)[:, j], each.dt) for each in data)
        if wide <= REST_SIGMAS * sigma:
            remedy = f"move it, or lock it in the model (robot.lock: {{{joint}: ...}})"
            problem = "the joint does not move beyond its encoder's noise"
            value = f"a range of {wide:.2g} at a noise of {sigma:.2g}"
            raise InputError(problem, file=data[0].name, key=f"{signal}.{joint}", value=value, remedy=remedy)
    moving = _moving_time(data, signals, noise)
    if moving < LEAST_MOVING_TIME:
        problem = f"too little motion in the recording{'s' if len(data) > 1 else ''}"
        raise InputError(problem, file=data[0].name, key="t", value=f"{moving:.2g} s of motion", remedy=REMEDY)


def _range_of_motion(x: Array, dt: float) -> float:
    """Range of a position (samples,), averaged over 20 ms to reduce noise."""
    width = min(max(1, round(0.02 / dt)), len(x))
    means = x[: len(x) // width * width].reshape(-1, width).mean(axis=1)
    return float(np.ptp(means))


def moves_long_enough(data: Sequence[Measured]) -> bool:
    """Whether recordings move for as long as a fit needs."""
    return _moving_time(data, *_positions(data)) >= LEAST_MOVING_TIME


def _positions(data: Sequence[Measured]) -> tuple[list[str], list[Array]]:
    """The encoder by which each joint is judged, and the noise of link and motor encoders (joints,)."""
    signals = [("theta" if has else "q") for has in data[0].has_theta]
    return signals, [encoder_noise(tuple(data), signal) for signal in ("q", "theta")]


def _moving_time(data: Sequence[Measured], signals: Sequence[str], noise: Sequence[Array]) -> float:
    """Time in which some joint of the recordings moves by more than its noise, in blocks of 0.1 s [s]."""
    seconds = 0.0
    for each in data:
        width = max(1, round(0.1 / each.dt))
        blocks = len(each.t) // width
        moves = np.zeros(blocks, dtype=bool)
        for j, signal in enumerate(signals):
            x = getattr(each, signal)[: blocks * width, j].reshape(blocks, width)
            moves |= np.ptp(x, axis=1) > REST_SIGMAS * float(noise[signal == "theta"][j])
        seconds += float(moves.sum()) * width * each.dt
    return seconds


def _passive(model: FlexibleJointModel, data: Sequence[Measured]) -> Iterator[str]:
    for j, joint in enumerate(model.joint_names):
        if all((each.tau[:, j] == 0.0).all() for each in data):
            yield f"No torque is ever asked of {joint}: what scales its torque cannot be told."
