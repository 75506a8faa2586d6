"""Positions that are more exact than the readings of an encoder whose only noise is its resolution."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.records.signals.reading_noise import quantisation_step, reading_noise

MOST_DITHER = 1.5
"""Noise over that of the resolution, step/sqrt(12), up to which readings have no other noise [1]: others dither."""
AS_LONG = 2.0
"""Largest ratio of two runs of equal increments between which a joint is taken to keep its speed [1]."""


def between_steps(x: Array, least: int) -> tuple[Array, Array]:
    """Positions of an encoder, more exact than its readings where these change regularly, and errors that stay.

    Errors of readings are no white noise where their increments stay equal, as of a joint that holds its position, that
    creeps by a step now and then, or moves by nearly a whole number of steps per sample. At an instant at which one
    increment differs by a step, the position is at the border between two steps. A joint that goes from border to
    border, and takes about as long for the next step, is on a straight line between them. Elsewhere the error stays as
    long as the increments do.

    Args:
        x: readings (samples,).
        least: equal increments, one after the other, from which this counts: after fewer, the errors of a filter's span
            are many, and like noise.

    Returns:
        Positions (samples,), within half a step of the readings; these themselves, where they are on no grid or have
        other noise. And standard deviations of errors that stay (samples,): step/sqrt(12), or 0 where there are none.
    """
    step = quantisation_step(x)
    if step is None or reading_noise(x) > MOST_DITHER * step / math.sqrt(12.0):
        return x, np.zeros(len(x))
    increments = np.round(np.diff(x) / step)
    begins = np.concatenate([[0], np.flatnonzero(np.diff(increments)) + 1])
    value, long = increments[begins], np.diff(begins, append=len(increments))
    regular = long >= least
    steady = np.flatnonzero(regular & _steady(value, long))
    stays = np.zeros(len(x), dtype=bool)
    stays[:-1] = np.repeat(regular, long)
    count = long[steady] + 1
    after = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    at = np.repeat(begins[steady], count) + after
    stays[at] = False
    way, error = np.sign(value[np.minimum(steady + 1, len(value) - 1)] - value[steady]), np.zeros(len(x))
    error[at] = np.repeat(way, count) * ((after + 0.5) / np.repeat(count, count) - 0.5)
    return np.asarray(x + step * error), step / math.sqrt(12.0) * stays


def _steady(value: Array, long: Array) -> Flags:
    """Runs of equal increments in which a joint goes from border to border, and on at about the same speed (runs,).

    Args:
        value: increments of the runs (runs,).
        long: how many there are in each (runs,).
    """
    ways, alike = np.zeros((2, len(value))), np.zeros((2, len(value)), dtype=bool)
    for k, (way, here) in enumerate(((-1, slice(2, None)), (1, slice(None, -2)))):
        beside, beyond = (np.roll(np.arange(len(value)), -far * way)[here] for far in (1, 2))
        goes_on = (long[beside] == 1) & (value[beyond] == value[here])
        ways[k, here] = np.where(goes_on, np.sign(value[beside] - value[here]), 0.0)
        alike[k, here] = goes_on & (
            np.maximum(long[beyond], long[here]) <= AS_LONG * np.minimum(long[beyond], long[here])
        )
    return np.asarray((ways[0] == ways[1]) & (ways[0] != 0.0) & alike.any(axis=0))
