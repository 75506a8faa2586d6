"""Smoothed and differentiated recordings, with the remaining noise of every term."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError, retold
from flexdyn.io.locked import Locked
from flexdyn.records.signals.cut import made
from flexdyn.records.signals.decimate import uniform_rate
from flexdyn.records.signals.noise import Noise, estimate_noise
from flexdyn.records.signals.smooth import Smoother
from flexdyn.records.signals.width import best_smoother
from flexdyn.records.units import is_held, split_name

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

_POSITIONS = ("q", "theta")


@dataclass(frozen=True, eq=False)
class Derivatives(Locked):
    """One recording seen through one filter: every term of an equation of motion smoothed alike.

    Attributes:
        recording: that is filtered.
        smoother: the filter.
        noise: of the requested channels, estimated from their samples.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> view = fd.derivatives(run.to_recording(), ["q.elbow"])
        >>> view.first("q.elbow").size == view.t.size
        True
    """

    recording: Recording
    smoother: Smoother
    noise: Mapping[str, Noise]

    @property
    def t(self) -> Array:
        """Times of the outputs [s]."""
        return self.recording.t[self.smoother.valid]

    def value(self, channel: str) -> Array:
        """The smoothed channel; tau and tau_applied are taken as held from each sample to the next."""
        return (self.smoother.held if is_held(channel) else self.smoother.value)(self.recording[channel])

    def first(self, channel: str) -> Array:
        """First derivative [unit/s]: velocity from a position, acceleration from a velocity."""
        return self.smoother.first(self.recording[channel])

    def second(self, channel: str) -> Array:
        """Second derivative [unit/s^2]: acceleration from a position."""
        return self.smoother.second(self.recording[channel])

    def std(self, channel: str, order: str = "value") -> float:
        """Standard deviation of the remaining noise of an output, including correlations of the samples.

        Args:
            channel: one of those in `noise`.
            order: ``"value"``, ``"first"`` or ``"second"``.

        Raises:
            InputError: the noise of the channel was not requested.
        """
        if channel not in self.noise:
            raise InputError("the noise of the channel was not requested", key=channel, remedy="name it in channels=")
        held = order == "value" and is_held(channel)
        return self.smoother.noise_std("held" if held else order, self.noise[channel].autocovariance)


def derivatives(
    rec: Recording,
    channels: Sequence[str] | None = None,
    *,
    cutoff: float | None = None,
    smoother: Smoother | None = None,
) -> Derivatives:
    """Smooth a recording for its derivatives, all channels with one filter, and give the remaining noise.

    The width is given by `smoother` or by `cutoff`. By default, the best width for the second derivative of each
    position is found (`best_smoother`), and the narrowest of these is used: the remaining noise is known and
    propagated, bias is not.

    Args:
        rec: samples at a uniform rate.
        channels: whose noise is estimated; default: the positions.
        cutoff: frequency at which the filter's response is 1/sqrt(2) [Hz].
        smoother: or the filter itself.

    Raises:
        InputError: time that is not uniform, no such channel, no position that moves, or both `cutoff` and `smoother`.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> view = fd.derivatives(run.to_recording(), ["q.elbow"], cutoff=20.0)
        >>> acceleration = view.second("q.elbow")
    """
    rate = uniform_rate(rec)
    if cutoff is not None and smoother is not None:
        raise InputError("the width is given twice", key="cutoff", value=cutoff, remedy="give cutoff or smoother")
    positions = [channel for channel in rec.channels if (split_name(channel) or ("",))[0] in _POSITIONS]
    names = positions if channels is None else list(channels)
    noise = {channel: noise_of(rec, channel) for channel in names}
    if cutoff is not None:
        smoother = Smoother.at_cutoff(cutoff, rate)
    if smoother is None:
        moving = [channel for channel in positions if np.ptp(rec[channel]) > 0]
        if not moving:
            raise InputError("no position moves, so no width can be chosen", key="cutoff", remedy="give one [Hz]")
        found = {channel: noise[channel] if channel in noise else noise_of(rec, channel) for channel in moving}
        choices = [best_smoother(rec[channel], rate, found[channel]) for channel in moving]
        smoother = min(choices, key=lambda choice: choice.width)
    _check_rate(smoother, rate)
    return Derivatives(rec, smoother, noise)


def smoothed_channels(rec: Recording, smoother: Smoother) -> Recording:
    """Smooth every channel with one filter, at the times that it covers; torques are taken as held between samples.

    Args:
        rec: samples at a uniform rate.
        smoother: the filter, made for that rate.

    Raises:
        InputError: time that is not uniform, another rate, or too few samples.
    """
    _check_rate(smoother, uniform_rate(rec))
    view = Derivatives(rec, smoother, {})
    return made(rec, {"t": view.t, **{channel: view.value(channel) for channel in rec.channels}})


def noise_of(rec: Recording, channel: str) -> Noise:
    """The noise of one channel, estimated from its samples; a commanded torque with repeated values is exact."""
    with retold(key=channel, channel=channel):
        return estimate_noise(rec.t, rec[channel], unit=rec.unit(channel), held=is_held(channel))


def _check_rate(smoother: Smoother, rate: float) -> None:
    if abs(smoother.rate - rate) > 1e-3 * rate:
        problem = f"the filter is made for another rate than the recording's {rate:.6g} Hz"
        raise InputError(problem, key="smoother.rate", value=smoother.rate, remedy="make it for that rate")
