"""The frames of a page, and the magnification of deflections."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.viewer.motion import PlayedMotion

FASTEST = 240.0
"""Largest frame rate [Hz]: at a tenth of the speed there are still 24 frames in a second."""
MOST_FRAMES = 3600
"""Largest number of frames in a page."""
MOST_MAGNIFIED = 1e9
"""Largest magnification of a deflection [1]."""


@dataclass(frozen=True)
class Frames:
    """Motions at equally spaced times.

    Attributes:
        arm: motion of the arm.
        ghost: motion of the second arm, if there is one.
        rate: frames in a second [Hz].
    """

    arm: PlayedMotion
    ghost: PlayedMotion | None
    rate: float

    @property
    def everywhere(self) -> Array:
        """All positions of all arms (frames of all, n) [rad or m]."""
        return self.arm.q if self.ghost is None else np.vstack([self.arm.q, self.ghost.q])


def frames_of(motion: PlayedMotion, ghost: PlayedMotion | None) -> Frames:
    """Motions at the times of the page, which are those of the first motion that is not at rest.

    Raises:
        InputError: the two motions have no time in common.
    """
    times = frame_times(motion if ghost is None or len(motion.t) > 1 else ghost)
    if ghost is not None:
        (first, last), (start, end) = motion.span, ghost.span
        if last > first and end > start and (start >= last or end <= first):
            own, other = f"{start:.10g} to {end:.10g} s", f"{first:.10g} to {last:.10g} s"
            problem = f"it spans {own}, and what it is compared with {other}"
            raise InputError(problem, key="compare", remedy="shift the clock of one of them")
    rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else 1.0
    return Frames(motion.at(times), None if ghost is None else ghost.at(times), float(rate))


def frame_times(motion: PlayedMotion) -> Array:
    """Equally spaced times from first to last; one time if the arm does not move.

    There are not more than the samples of the motion, `MOST_FRAMES`, or `FASTEST` in a second.
    """
    first, last = motion.span
    if last == first:
        return np.array([first])
    count = min(len(motion.t), MOST_FRAMES, math.ceil((last - first) * FASTEST) + 1)
    return np.linspace(first, last, count)


def checked_factor(magnify: float) -> float:
    """Check a magnification from the user.

    Raises:
        InputError: it is none.
    """
    if not 0.0 < magnify <= MOST_MAGNIFIED:
        remedy = f"above 0, and up to {MOST_MAGNIFIED:g}"
        raise InputError("no such factor", key="magnify", value=magnify, remedy=remedy)
    return float(magnify)


def magnification(deflection: Array, shown: float) -> float:
    """The factor 1, 2, 5, 10, ... with which the largest deflection is nearest to `shown`; 1 if there is no deflection.

    Args:
        deflection: any shape; NaN where there is none.
        shown: size that the largest deflection should have.
    """
    known = np.abs(deflection[np.isfinite(deflection)])
    largest = float(known.max()) if known.size else 0.0
    if largest * MOST_MAGNIFIED <= shown:
        return 1.0
    wanted = max(shown / largest, 1.0)
    power = 10.0 ** math.floor(math.log10(wanted))
    return min((step * power for step in (1, 2, 5, 10)), key=lambda factor: abs(math.log(factor / wanted)))
