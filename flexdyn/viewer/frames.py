"""Which moments the page holds, and by how much it magnifies deflections."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.errors import InputError
from flexdyn.viewer.motion import PlayedMotion

Array = NDArray[np.float64]
FASTEST = 240.0
"""Frames in a second, at most: a tenth of the speed still shows 24 of them in a second."""
MOST_FRAMES = 3600
"""Frames in a page, at most."""
MOST_MAGNIFIED = 1e9
"""Largest factor of a deflection."""


@dataclass(frozen=True)
class Frames:
    """Motions at equally spaced times.

    Attributes:
        arm: what the arm does.
        ghost: what the second one does, if there is one.
        rate: frames in a second [Hz].
    """

    arm: PlayedMotion
    ghost: PlayedMotion | None
    rate: float

    @property
    def everywhere(self) -> Array:
        """Every position that any arm takes (frames of all, n) [rad or m]."""
        return self.arm.q if self.ghost is None else np.vstack([self.arm.q, self.ghost.q])


def frames_of(motion: PlayedMotion, ghost: PlayedMotion | None) -> Frames:
    """Motions at the times that the page shows: those of the first that moves.

    Raises:
        InputError: the second happened before or after the first.
    """
    times = frame_times(motion if ghost is None or len(motion.t) > 1 else ghost)
    if ghost is not None:
        (first, last), (start, end) = motion.span, ghost.span
        if last > first and end > start and (start >= last or end <= first):
            problem = (
                f"it spans {start:.10g} to {end:.10g} s, and what it is compared with {first:.10g} to {last:.10g} s"
            )
            raise InputError(problem, key="compare", remedy="shift the clock of one of them")
    rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else 1.0
    return Frames(motion.at(times), None if ghost is None else ghost.at(times), float(rate))


def frame_times(motion: PlayedMotion) -> Array:
    """Equally spaced times from first to last; one if the arm stands still.

    Never more than the samples of the motion, `MOST_FRAMES`, or `FASTEST` in a second.
    """
    first, last = motion.span
    if last == first:
        return np.array([first])
    count = min(len(motion.t), MOST_FRAMES, math.ceil((last - first) * FASTEST) + 1)
    return np.linspace(first, last, count)


def checked_factor(magnify: float) -> float:
    """A factor that the user gives.

    Raises:
        InputError: it is none.
    """
    if not 0.0 < magnify <= MOST_MAGNIFIED:
        raise InputError(
            "no such factor", key="magnify", value=magnify, remedy=f"above 0, and up to {MOST_MAGNIFIED:g}"
        )
    return float(magnify)


def magnification(deflection: Array, shown: float) -> float:
    """The factor 1, 2, 5, 10, ... with which the largest deflection comes nearest to `shown`; 1 if there is none.

    Args:
        deflection: any shape; NaN where there is none.
        shown: to what it is to be magnified, about.
    """
    known = np.abs(deflection[np.isfinite(deflection)])
    largest = float(known.max()) if known.size else 0.0
    if largest * MOST_MAGNIFIED <= shown:
        return 1.0
    wanted = max(shown / largest, 1.0)
    power = 10.0 ** math.floor(math.log10(wanted))
    return min((step * power for step in (1, 2, 5, 10)), key=lambda factor: abs(math.log(factor / wanted)))
