"""Numbers of cycles per turn in a residual, from its spectrum over position."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, SENSOR
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.inference.autoregression import Autoregression
from flexdyn.effects import registered
from flexdyn.effects.waves import WaveEffect

HIGHEST_HARMONIC = 200.0
"""Harmonics that are looked for, at most [cycles per turn]."""
SPECTRUM_PEAKS = 4
"""Peaks of a spectrum that become grid points."""
HARMONICS_AT_ONCE = 64
"""Harmonics whose waves are held at once."""
HARMONIC_SPACING = 0.125
"""Between harmonics that are tried around a peak, as a share of the spectrum's resolution."""


def peaks(
    equations: Equations, left: Array, runs: Indices, row: int, signal: str, *, with_direction: bool = False
) -> list[float]:
    """The harmonics at the highest peaks of one equation's residual over its joint's position.

    The filters weaken a wave of h cycles that passes at speed u by ``exp(-(h u s)^2/2)``, s their standard deviation.

    Args:
        equations: whose residual it is.
        left: residual of the equation (rows,).
        runs: of its rows that say something (rows,).
        row: place of the equation.
        signal: ``q`` or ``theta``.
        with_direction: whether the waves change their sign with the velocity. Over a motion to and fro they have
            no peak at their own harmonic in the spectrum of waves that do not.
    """
    j, _ = equations.kinds[row]
    x, u = _motion(equations, j, signal)
    span = float(np.ptp(x))
    if span <= 0.0 or not (runs >= 0).any():
        return []
    resolution = np.pi / span
    grid = np.arange(max(1.0, resolution), HIGHEST_HARMONIC, 0.5 * resolution)
    scale = float(np.sqrt((left[runs >= 0] ** 2).mean())) or 1.0
    process = Autoregression.of(left / scale * 1e3, runs)  # the scale only keeps the innovations above 1
    y = process.innovations((left / scale * 1e3)[:, None], runs)[:, 0]
    first, second = equations.filters.first, equations.filters.second
    width = math.sqrt(equations.motions[0].passes * first.variance + second.variance) * equations.data[0].dt
    sign = np.sign(u)[:, None] if with_direction else 1.0

    def power(h: Array) -> Array:
        """Squares of the rows that waves of these harmonics explain."""
        fade = np.exp(-0.5 * (h * u[:, None] * width) ** 2)
        parts = [sign * fade * wave(h * x[:, None]) for wave in (np.cos, np.sin)]
        C, S = (process.innovations(part, runs) for part in parts)
        cc, ss, cs = (C * C).sum(0), (S * S).sum(0), (C * S).sum(0)
        yc, ys = y @ C, y @ S
        det = np.maximum(cc * ss - cs * cs, 1e-12 * np.maximum(cc * ss, 1e-300))
        return np.asarray((yc**2 * ss - 2.0 * yc * ys * cs + ys**2 * cc) / det)

    size = np.concatenate([power(block) for block in np.array_split(grid, max(1, len(grid) // HARMONICS_AT_ONCE))])
    inner = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    chosen = inner[np.argsort(-size[inner])][:SPECTRUM_PEAKS]
    around = np.arange(-4, 5) * HARMONIC_SPACING * resolution
    found = []
    for k in chosen:
        near = grid[k] + around
        near = near[near >= 1.0]
        found.append(float(near[int(np.argmax(power(near)))]))
    return found


def _motion(equations: Equations, j: int, signal: str) -> tuple[Array, Array]:
    """Position and speed of a joint at the rows."""
    rate = {"q": "v", "theta": "omega"}[signal]
    return equations.at_rows(signal)[:, j].copy(), equations.at_rows(rate)[:, j].copy()


def with_harmonics(equations: Equations, left: Array, known: list[Proposal], runs: Indices) -> list[Proposal]:
    """Proposals of waves at the harmonics that a residual holds.

    Args:
        equations: of a hypothesis.
        left: their residual, without a vibration from the first states of simulated links (rows,).
        known: proposals of effects.
        runs: of each equation's rows that say something (rows of an equation, equations).
    """
    found: dict[tuple[str, bool], list[float]] = {}
    for row, (j, kind) in enumerate(equations.kinds):
        joint = equations.true.joint_names[j]
        if kind == SENSOR:
            continue
        signal, own = "q" if kind == LINK else "theta", left.reshape(-1, len(equations.kinds))[:, row]
        for turns in (False, True):
            made = peaks(equations, own, runs[:, row], row, signal, with_direction=turns)
            found.setdefault((joint, turns), []).extend(made)
    return [_at(each, found) for each in known]


def _at(proposal: Proposal, harmonics: Mapping[tuple[str, bool], list[float]]) -> Proposal:
    law = registered()[proposal.place["effect"]]
    if not law.cycles:
        return proposal
    turns = issubclass(law, WaveEffect) and law.with_direction
    more = {(h,) for h in harmonics.get((proposal.joint, turns), ())}
    return dataclasses.replace(proposal, grid=tuple(sorted({*proposal.grid, *more})))
