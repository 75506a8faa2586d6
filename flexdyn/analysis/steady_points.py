"""Runs at constant speed as points of a friction curve, with the accuracy of their means."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.given import as_recordings

INDEPENDENT_AUTOCORRELATION = 0.05
"""Below this autocorrelation samples count as independent [1]."""


@dataclass(frozen=True)
class SteadyPoint:
    """One run at constant speed.

    Attributes:
        speed: mean [rad/s or m/s].
        torque: mean of the motor, reflected [N m or N].
        std: standard deviation of that mean, correlations of the samples included.
        name: of the run.

    Example:
        >>> fd.SteadyPoint(speed=0.5, torque=1.25, std=0.01).torque
        1.25
    """

    speed: float
    torque: float
    std: float
    name: str = ""

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: numbers that are not finite, or a standard deviation that is not above 0.
        """
        for key in ("speed", "torque", "std"):
            value = getattr(self, key)
            if not np.isfinite(value) or (key == "std" and value <= 0.0):
                raise InputError("a finite number is needed, above 0 for std", key=key, value=value, file=self.name)


def steady_points(recordings: Any, joint: str) -> tuple[SteadyPoint, ...]:
    """The mean speed and torque of each run, with the standard deviation of the mean torque.

    Args:
        recordings: one or several (or runs, paths, data frames), each at one constant speed, with ``tau.JOINT`` and
            ``omega.JOINT`` or ``v.JOINT``.
        joint: name of the joint.

    Returns:
        One point for each run, in order of speed.

    Raises:
        InputError: a run without torque or velocity, or one whose torque never changes.

    Example:
        >>> t, noise = np.arange(500) / 100, np.random.default_rng(0)
        >>> runs = [fd.Recording(t, {"omega.elbow": 0 * t + u, "tau.elbow": 1 + u + noise.normal(0.0, 0.1, t.size)})
        ...         for u in (0.5, 1.0)]
        >>> [point.speed for point in fd.steady_points(runs, "elbow")]
        [0.5, 1.0]
    """
    points = []
    for each in as_recordings(recordings):
        signal = "omega" if each.has("omega", joint) else "v"
        if not each.has(signal, joint):
            remedy = f"record omega.{joint}, or differentiate the position"
            raise InputError("no velocity of the joint was recorded", file=each.name, key=joint, remedy=remedy)
        speed, torque = each[f"{signal}.{joint}"], each[f"tau.{joint}"]
        points.append(SteadyPoint(float(speed.mean()), float(torque.mean()), std_of_mean(torque), each.name))
    return tuple(sorted(points, key=lambda point: point.speed))


def std_of_mean(x: Array) -> float:
    """Standard deviation of the mean of correlated samples: ``s sqrt((1 + 2 sum rho)/n)``."""
    off = x - x.mean()
    power = float(off @ off)
    if power == 0.0:
        return 0.0
    rho = np.correlate(off, off, "full")[len(x) - 1 :] / power
    faded = np.flatnonzero(rho < INDEPENDENT_AUTOCORRELATION)
    within = rho[1 : faded[0]] if len(faded) else rho[1:]
    return float(x.std(ddof=1) * np.sqrt((1.0 + 2.0 * within.sum()) / len(x)))
