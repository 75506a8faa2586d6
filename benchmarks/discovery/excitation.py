"""Motions of a whole arm as laboratories choose them: mixed, sums of sines, point to point, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from layout import Array
from motions import Style, moves, reference, smooth, sweep_to_and_fro
from two_link_run import PERIOD

KINDS = ("mixed", "fourier", "points", "single")


def wanted_of(
    kind: str, rng: np.random.Generator, styles: Sequence[Style], middle: Sequence[float], duration: float
) -> Array:
    """References of all joints (samples, n) [rad]."""
    if kind == "mixed":
        return np.stack([reference(rng, s, m, duration) for s, m in zip(styles, middle, strict=True)], axis=1)
    if kind == "single":
        paths = _one_by_one(rng, styles, duration)
    else:
        paths = [(_fourier if kind == "fourier" else _points)(rng, style, duration) for style in styles]
    return np.stack([m + smooth(path) for m, path in zip(middle, paths, strict=True)], axis=1)


def _fourier(rng: np.random.Generator, style: Style, duration: float) -> Array:
    """A periodic sum of sines within reach, speed and acceleration, faded in over a second from rest."""
    t = np.arange(round(duration / PERIOD)) * PERIOD
    base = 2.0 * np.pi * rng.uniform(0.05, 0.12)
    rates = base * np.arange(1, 1 + rng.integers(5, 13))
    sizes = rng.normal(size=len(rates)) / np.sqrt(np.arange(1, 1 + len(rates)))
    phases = rng.uniform(-np.pi, np.pi, len(rates))
    angle = np.outer(t, rates) + phases
    x, v, a = (np.abs((sizes * rates**k * np.sin(angle + 0.5 * np.pi * k)).sum(axis=1)).max() for k in range(3))
    share = min(style.reach / x, style.speed / v, style.acceleration / a)
    fade = np.clip(t, 0.0, 1.0)
    return np.asarray(share * (sizes * np.sin(angle)).sum(axis=1) * fade**3 * (10.0 - 15.0 * fade + 6.0 * fade**2))


def _points(rng: np.random.Generator, style: Style, duration: float) -> Array:
    """Point-to-point moves from first to last."""
    rest = np.zeros(round(0.3 / PERIOD))
    return np.concatenate([rest, moves(rng, style, 0.0, duration)])[: round(duration / PERIOD)]


def _one_by_one(rng: np.random.Generator, styles: Sequence[Style], duration: float) -> list[Array]:
    """Sweeps at constant speeds; of many joints every third moves at once, else a short recording has too few."""
    n, samples = len(styles), round(duration / PERIOD)
    groups = min(n, 3)
    bounds = np.linspace(0, samples, groups + 1).astype(int)
    paths = [np.zeros(samples) for _ in styles]
    for place, group in enumerate(rng.permutation(groups)):
        begin, end = bounds[place], bounds[place + 1]
        for j in range(int(group), n, groups):
            piece = sweep_to_and_fro(rng, styles[j], (end - begin) * PERIOD)[: end - begin]
            paths[j][begin:end], paths[j][end:] = piece, piece[-1]
    return paths
