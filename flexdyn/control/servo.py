"""Servo: the cascade controller of a real drive, sample by sample: position loop, velocity loop, limit."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array, whole
from flexdyn.control.commands import State
from flexdyn.control.firmware import Firmware
from flexdyn.control.samples import Samples
from flexdyn.control.setting_checks import check_feedback, checked_rate, per_joint
from flexdyn.errors import InputError

Gains = float | ArrayLike | Mapping[str, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Servo:
    """A position loop around a velocity loop at a control rate; the torque is held between the ticks.

    ``u = velocity_gain (position_gain (reference - y) + speed_feedforward reference' - dy)``, delayed by `delay`
    samples and limited to ``[-limit, limit]``; then ``tau = u + added``. y is theta or q at the sample, dy its
    difference over the last `span` samples, as in a drive without a velocity sensor. With the recorded reference of a
    robot and the gains of its drives, the simulation contains the robot's controller; then the torque of the model can
    be compared with the recorded torque. After its end, the reference keeps its last value.

    With `firmware` it is the position controller of a smart servo instead. Its duty is applied to the joints' motors,
    which need an `Actuator` with a supply.

    Args:
        reference: positions [rad or m]: `Samples`, or a recording with ``goal``, ``reference``, ``theta`` or ``q``
            columns (the first of these that exists; it also gives the first state), or its path.
        position_gain: [1/s], one for all, one per joint, or a mapping by joint; not with firmware.
        velocity_gain: [N m s/rad], likewise.
        firmware: one `Firmware` for all joints, or a mapping by joint; it does not use span, speed_feedforward and
            limit.
        rate: of the controller [Hz]; with firmware the firmware's own rate is used.
        feedback: ``theta`` (motor side) or ``q`` (link side).
        span: samples over which the velocity is computed; 2: the difference of means of two samples; 0: the true
            velocity.
        speed_feedforward: share of the reference's velocity that is added to the input of the velocity loop [1].
        limit: of the torque [N m], one for all, one per joint, or a mapping by joint.
        delay: samples by which the controller's torque or duty is delayed.
        added: torques that are added after the limit (`Samples`), such as a test signal at the amplifier's input.

    Raises:
        InputError: a number that is not allowed.

    Example:
        >>> reference = fd.Samples([0, 1], {"shoulder": [0.0, 0.2], "elbow": [0.0, 0.2]}, "linear")
        >>> servo = fd.Servo(reference=reference, position_gain=5.0, velocity_gain=2.0, limit=0.5)
        >>> run = fd.simulate(fd.load_model("scara_two_link"), servo, duration=1.0)
        >>> bool(abs(run.tau).max() <= 0.5)
        True
    """

    reference: Any
    position_gain: Gains | None = None
    velocity_gain: Gains | None = None
    firmware: Firmware | Mapping[str, Firmware] | None = None
    rate: float = 1000.0
    feedback: Literal["theta", "q"] = "theta"
    span: int = 1
    speed_feedforward: float = 0.0
    limit: Gains = math.inf
    delay: int = 0
    added: Samples | None = None

    def __post_init__(self) -> None:
        """Check everything that needs no robot."""
        check_feedback("servo.feedback", self.feedback)
        for key in ("span", "delay"):
            whole(f"servo.{key}", getattr(self, key), 0, problem="a number of samples is needed")
        if self.added is not None and not isinstance(self.added, Samples):
            raise InputError("Samples are needed", key="servo.added", value=self.added)
        object.__setattr__(self, "rate", checked_rate("servo.rate", self.rate))
        gains = [key for key in ("position_gain", "velocity_gain") if getattr(self, key) is not None]
        if self.firmware is None and len(gains) < 2:
            remedy = "give position_gain and velocity_gain, or firmware"
            raise InputError("a servo needs its gains", key="servo", remedy=remedy)
        if self.firmware is not None:
            if gains:
                raise InputError("firmware has gains of its own", key=f"servo.{gains[0]}", remedy="leave it out")
            object.__setattr__(self, "rate", _one_rate(self.firmware))

    def law(self, reference: Samples, joint_names: Sequence[str]) -> Callable[[float, State], Array]:
        """Make a controller for the start of a run; it has a state, so every run needs its own.

        Args:
            reference: positions over time.
            joint_names: of the model.

        Raises:
            InputError: gains, limits or columns that do not fit the joints.
        """
        names = tuple(joint_names)
        gains = [per_joint(f"servo.{key}", getattr(self, key), names) for key in ("position_gain", "velocity_gain")]
        limit = _limits(self.limit, names)
        wanted = _at_ticks(reference, names, self.rate)
        rates = self.speed_feedforward * np.gradient(wanted, axis=0) * self.rate if self.speed_feedforward else None
        added = None if self.added is None else _at_ticks(self.added, names, self.rate)
        seen: deque[Array] = deque(maxlen=self.span + 1)
        asked: deque[Array] = deque(maxlen=self.delay + 1)

        def torque(t: float, state: State) -> Array:
            """Torques (n,) at a tick of the controller [N m or N]; called once for each, in their order."""
            k = round(t * self.rate)
            now = min(k, len(wanted) - 1)
            y, dy = (state.theta, state.omega) if self.feedback == "theta" else (state.q, state.v)
            if not seen:  # before the run the joint is taken to move with its first velocity
                seen.extend(y - dy * age / self.rate for age in range(self.span, 0, -1))
            seen.append(y.copy())
            speed = (y - seen[0]) * (self.rate / self.span) if self.span else dy
            ahead = rates[now] if rates is not None and k < len(wanted) else 0.0
            u = gains[1] * (gains[0] * (wanted[now] - y) + ahead - speed)
            asked.append(u)
            tau = np.clip(asked[0] if len(asked) > self.delay else np.zeros_like(u), -limit, limit)
            return np.asarray(tau + added[k] if added is not None and k < len(added) else tau)

        return torque

    def goals(self, reference: Samples, joint_names: Sequence[str]) -> Array:
        """The reference at the controller's ticks (ticks, n)."""
        return _at_ticks(reference, tuple(joint_names), self.rate)


def _one_rate(firmware: Firmware | Mapping[str, Firmware]) -> float:
    """The rate of all firmware [Hz]."""
    each = tuple(firmware.values()) if isinstance(firmware, Mapping) else (firmware,)
    rates = {one.rate for one in each if isinstance(one, Firmware)}
    if len(rates) != 1:
        raise InputError("one rate for all joints is needed", key="servo.firmware.rate", value=sorted(rates))
    return rates.pop()


def _limits(given: Gains, names: tuple[str, ...]) -> Array:
    """Limits by joint (n,), above 0; infinite: none."""
    if isinstance(given, float | int) and math.isinf(given) and given > 0:
        return np.full(len(names), math.inf)
    limit = per_joint("servo.limit", given, names)
    if not (limit > 0.0).all():
        raise InputError("a limit above 0 is needed", key="servo.limit", value=given)
    return limit


def _at_ticks(samples: Samples, names: tuple[str, ...], rate: float) -> Array:
    """Values at the controller's ticks (ticks, n), from the first sample to the last."""
    ticks = np.arange(math.floor(samples.duration * rate + 1e-6) + 1) / rate
    slack = 1e-3 / rate if samples.interpolation == "hold" else 0.0  # a late clock moves no sample to the next tick
    return samples.at(ticks + slack, samples.columns(names))
