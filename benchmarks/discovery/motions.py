"""References that a careful experimenter would choose, at random: slow sweeps, reversals, dwells, fast motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from layout import Array
from two_link_run import PERIOD

SMOOTHING = (0.06, 0.04)  # s, two moving averages: bounded jerk


@dataclass(frozen=True)
class Style:
    """How a joint is moved.

    Attributes:
        reach: greatest distance from the middle [rad].
        speed: of fast moves [rad/s].
        acceleration: of fast moves [rad/s^2].
        slow: speed of slow sweeps [rad/s].
    """

    reach: float
    speed: float
    acceleration: float
    slow: float


def draw_style(rng: np.random.Generator) -> Style:
    """A brisk industrial arm."""
    return Style(rng.uniform(0.7, 1.1), rng.uniform(1.2, 2.2), rng.uniform(6.0, 12.0), rng.uniform(0.03, 0.12))


def reference(rng: np.random.Generator, style: Style, middle: float, duration: float) -> Array:
    """Positions wanted at every control period (samples,) [rad]: pieces one after the other, ending where they may."""
    samples = round(duration / PERIOD)
    kinds = [_tones, moves, _sweep, _tones, moves, _dwell]
    order: list[int] = []
    pieces, have, here = [np.zeros(round(0.3 / PERIOD))], round(0.3 / PERIOD), 0.0
    while have < samples:
        order = order or [int(k) for k in rng.permutation(len(kinds))]
        share = rng.uniform(0.08, 0.14) * duration if duration > 20 else rng.uniform(0.12, 0.2) * duration
        piece = kinds[order.pop()](rng, style, here, share)
        pieces.append(piece)
        have, here = have + len(piece), float(piece[-1])
    return np.asarray(middle + smooth(np.concatenate(pieces)[:samples]))


def smooth(path: Array) -> Array:
    """The path, from rest at zero, with bounded jerk."""
    for window in SMOOTHING:
        width = round(window / PERIOD)
        path = np.convolve(np.concatenate([np.zeros(width - 1), path]), np.full(width, 1.0 / width), "valid")
    return path


def _times(duration: float) -> Array:
    return np.asarray(np.arange(round(duration / PERIOD)) * PERIOD)


def _tones(rng: np.random.Generator, style: Style, here: float, duration: float) -> Array:
    """A sum of sines between 0.2 and 2.5 Hz that fades in and out."""
    t = _times(duration)
    rate = 2.0 * np.pi * np.exp(rng.uniform(np.log(0.2), np.log(2.5), 5))
    size = np.minimum(0.5 * style.reach, 0.6 * style.acceleration / rate**2) * rng.uniform(0.3, 1.0, 5)
    sines = (size * np.sin(np.outer(t, rate) + rng.uniform(0, 2 * np.pi, 5))).sum(axis=1)
    fade = np.clip(np.minimum(t, duration - t) / min(1.0, duration / 4), 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    wide = np.abs(here + fade * sines).max()
    shrink = min(1.0, max(0.2, (style.reach - abs(here)) / max(wide - abs(here), 1e-9)))
    return np.asarray(here + shrink * fade * sines)


def moves(rng: np.random.Generator, style: Style, here: float, duration: float) -> Array:
    """Fast point-to-point moves with trapezoids of velocity, short rests between them."""
    path = [np.array([here])]
    while sum(map(len, path)) < duration / PERIOD:
        goal = rng.uniform(-style.reach, style.reach)
        path.append(_trapezoid(here, goal, style.speed * rng.uniform(0.4, 1.0), style.acceleration))
        path.append(np.full(round(rng.uniform(0.05, 0.4) / PERIOD), goal))
        here = goal
    return np.concatenate(path)[1:]


def _sweep(rng: np.random.Generator, style: Style, here: float, duration: float) -> Array:
    """Constant slow speeds with reversals."""
    path = [np.array([here])]
    way = -1.0 if here > 0 else 1.0
    while sum(map(len, path)) < duration / PERIOD:
        goal = here + way * style.slow * rng.uniform(0.6, 1.4) * duration * rng.uniform(0.2, 0.45)
        path.append(_trapezoid(here, goal, style.slow * rng.uniform(0.4, 1.6), style.acceleration))
        here, way = goal, -way
    return np.concatenate(path)[1:]


def sweep_to_and_fro(rng: np.random.Generator, style: Style, duration: float) -> Array:
    """From rest at zero to both sides and back, every way at a constant speed of its own, slow to fast."""
    path, here, way = [np.zeros(round(0.1 / PERIOD))], 0.0, float(rng.choice([-1.0, 1.0]))
    while sum(map(len, path)) < duration / PERIOD:
        speed = float(np.exp(rng.uniform(np.log(2.0 * style.slow), np.log(style.speed))))
        # A slow way is a short one: at least eight ways fit into the time.
        goal = here + way * min(abs(way * style.reach - here), speed * duration / 8.0)
        path.append(_trapezoid(here, goal, speed, style.acceleration))
        here, way = goal, -way
    return np.concatenate(path)


def _dwell(rng: np.random.Generator, style: Style, here: float, duration: float) -> Array:
    """Rests, with small steps between them."""
    path: list[Array] = []
    while sum(map(len, path)) < 0.6 * duration / PERIOD:
        path.append(np.full(round(rng.uniform(0.3, 0.8) / PERIOD), here))
        goal = here + rng.uniform(-0.05, 0.05)
        path.append(_trapezoid(here, goal, 0.3, style.acceleration))
        here = goal
    return np.concatenate(path)


def _trapezoid(here: float, goal: float, speed: float, acceleration: float) -> Array:
    way = abs(goal - here)
    speed = min(speed, np.sqrt(way * acceleration))
    if way < 1e-9:
        return np.full(2, goal)
    ramp, total = speed / acceleration, way / speed + speed / acceleration
    t = np.append(np.arange(PERIOD, total, PERIOD), total)
    rising = 0.5 * acceleration * np.minimum(t, ramp) ** 2 + speed * np.clip(t - ramp, 0.0, total - 2.0 * ramp)
    falling = 0.5 * acceleration * np.clip(total - t, 0.0, ramp) ** 2
    s = rising + np.where(t > total - ramp, 0.5 * speed * ramp - falling, 0.0)
    return np.asarray(here + np.sign(goal - here) * s)
