"""Paths of one joint that tell effects apart: sweeps, stairs, reversals, sines and pushes, within its bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.report.words import joined

PASS_DURATION = 8.0
"""Approximate duration of one pass of a motion [s]."""
NARROWEST_SMOOTHING = 0.02
"""Smallest width of the smoothing of a path's corners [s]."""
FADED_SINE_SHARE = 0.7
"""Share of speed and acceleration for a sine, which fades in and out [1]."""
Made = tuple[str, Array, Array | None]


def two_digits(value: float) -> str:
    """A number with two digits, as text."""
    text = f"{value:.2g}"
    return text if "e" not in text else f"{value:.0f}" if abs(value) >= 100.0 else text


@dataclass(frozen=True, eq=False)
class MovedJoint:
    """One joint: its place, its name, its unit, the time between samples [s], and the bounds of its motion."""

    j: int
    name: str
    unit: str
    dt: float
    low: float
    high: float
    speed: float
    acceleration: float
    torque: float

    @property
    def middle(self) -> float:
        """Middle of its range [rad or m]."""
        return 0.5 * (self.low + self.high)

    @property
    def half(self) -> float:
        """Half of its range [rad or m]."""
        return 0.5 * (self.high - self.low)

    def times(self, seconds: float) -> Array:
        """Times of samples (samples,) [s]."""
        return np.asarray(np.arange(round(seconds / self.dt)) * self.dt)

    def line(self, points: Sequence[float], speeds: Sequence[float], rest: float = 0.0) -> Array:
        """From point to point at these speeds, resting at each, corners rounded (samples,)."""
        t, x = [0.0], [points[0]]
        for goal, speed in zip(points[1:], speeds, strict=True):
            t.append(t[-1] + abs(goal - x[-1]) / speed)
            x.append(goal)
            if rest:
                t.append(t[-1] + rest)
                x.append(goal)
        path = np.interp(self.times(t[-1]), t, x)
        width = max(NARROWEST_SMOOTHING, 2.0 * max(speeds) / self.acceleration)
        for each in (width, 0.5 * width):
            count = max(1, round(each / self.dt))
            held = np.concatenate([np.full(count - 1, path[0]), path, np.full(count, path[-1])])
            path = np.convolve(held, np.full(count, 1.0 / count), "valid")
        return path

    def ends(self, half: float) -> str:
        """In words, positions that are so far on either side of the middle."""
        return f"between {two_digits(self.middle - half)} and {two_digits(self.middle + half)} {self.unit}"


def _sweeps(joint: MovedJoint, shares: Sequence[float]) -> Made:
    """There and back at constant speeds, one after another, the time shared evenly."""
    speeds = [share * joint.speed for share in shares]
    each = PASS_DURATION / (2.0 * len(speeds))
    half = min(joint.half, 0.5 * max(speeds) * each)
    points, paced = [joint.middle - half], []
    for speed in speeds:
        way, count = min(2.0 * half, speed * each), max(1, round(each * speed / (2.0 * half)))
        for _ in range(count):
            points += [points[0] + way, points[0]]
            paced += [speed, speed]
    listed = joined([two_digits(speed) for speed in speeds])
    return f"move {joint.name} at {listed} {joint.unit}/s both ways {joint.ends(half)}", joint.line(points, paced), None


def _stairs(joint: MovedJoint) -> Made:
    """Rests over the whole range, approached from both sides."""
    steps = np.linspace(joint.low, joint.high, 7)
    points = [*steps, *steps[-2::-1]]
    path = joint.line(points, [0.5 * joint.speed] * (len(points) - 1), rest=0.35)
    return f"step {joint.name} through 7 rests of 0.35 s {joint.ends(joint.half)} and back", path, None


def _dithers(joint: MovedJoint, share: float) -> Made:
    """Small reversals at the middle, slow and then faster."""
    half = share * joint.half
    speeds = [min(times * half, joint.speed) for times in (1.0, 4.0, 16.0)]
    points, paced = [joint.middle], []
    for speed in speeds:
        for _ in range(max(1, round(PASS_DURATION / 3.0 * speed / (4.0 * half)))):
            points += [joint.middle + half, joint.middle - half]
            paced += [speed, speed]
    low, high = two_digits(min(speeds)), two_digits(max(speeds))
    words = f"reverse {joint.name} over {two_digits(2 * half)} {joint.unit} at {low} to {high} {joint.unit}/s"
    return words, joint.line(points, paced), None


def _sines(joint: MovedJoint, share: float, hertz: float) -> Made:
    """One sine with the largest allowed speed."""
    amplitude = share * joint.half
    fastest = min(
        FADED_SINE_SHARE * joint.speed / amplitude, math.sqrt(FADED_SINE_SHARE * joint.acceleration / amplitude)
    )
    rate = min(2.0 * math.pi * hertz, fastest)
    t = joint.times(PASS_DURATION)
    x = joint.middle + amplitude * _fade(t, 2.0 * math.pi / rate) * np.sin(rate * t)
    rated = f"{two_digits(rate / (2.0 * math.pi))} Hz"
    return f"swing {joint.name} by {two_digits(amplitude)} {joint.unit} at {rated}", x, None


def _chirp(joint: MovedJoint) -> Made:
    """A sine with increasing frequency, within the limits of speed and acceleration."""
    t = joint.times(PASS_DURATION)
    first, last = 0.2, min(8.0, 0.1 / joint.dt)
    rate = 2.0 * math.pi * first * (last / first) ** (t / PASS_DURATION)
    bounds = np.stack(
        [
            0.5 * joint.half + 0.0 * t,
            FADED_SINE_SHARE * joint.speed / rate,
            FADED_SINE_SHARE * joint.acceleration / rate**2,
        ]
    )
    size = (bounds**-4).sum(axis=0) ** -0.25  # below all three bounds, without a corner
    x = joint.middle + size * _fade(t, 1.0) * np.sin(np.cumsum(rate) * joint.dt)
    words = f"swing {joint.name} with a sine that rises from {two_digits(first)} to {two_digits(last)} Hz"
    return f"{words}, {two_digits(size[0])} {joint.unit} and less", x, None


def _pushes(joint: MovedJoint, share: float) -> Made:
    """Torque steps of both signs with dwells, at rest."""
    t = joint.times(PASS_DURATION)
    size = share * joint.torque
    level = size * np.array([0.0, 1.0, 0.0, -1.0])[(t / 0.5).astype(int) % 4] * (1.0 - 0.5 * (t > 0.5 * PASS_DURATION))
    newton = "N m" if joint.unit == "rad" else "N"
    words = (
        f"hold {joint.name} at {two_digits(joint.middle)} {joint.unit} and add torque steps of {two_digits(size)} and"
    )
    words += f" {two_digits(0.5 * size)} {newton}, each way, for 0.5 s each"
    return words, np.full(len(t), joint.middle), level


def _fade(t: Array, seconds: float) -> Array:
    """From 0 to 1 at the beginning and back at the end."""
    share = np.clip(np.minimum(t, t[-1] - t) / min(seconds, 0.4 * t[-1]), 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


KINDS: tuple[Callable[[MovedJoint], Made], ...] = (
    lambda joint: _sweeps(joint, (0.04, 0.15, 0.6)),
    lambda joint: _dithers(joint, 0.02),
    _chirp,
    lambda joint: _sines(joint, 1.0, 0.3),
    _stairs,
    lambda joint: _dithers(joint, 0.2),
    lambda joint: _sweeps(joint, (1.0,)),
    lambda joint: _sweeps(joint, (0.02,)),
    lambda joint: _sines(joint, 0.15, 2.0),
    lambda joint: _pushes(joint, 0.3),
)
"""All paths, the most informative ones first: words, positions, and torque added to the controller's."""
