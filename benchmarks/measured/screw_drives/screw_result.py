"""What the study of screw drives gives: a drive's friction curves and how they predict motion that took no part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import flexdyn as fd


@dataclass(frozen=True)
class Drive:
    """One drive.

    Attributes:
        name: its folder.
        words: what it is.
        map: channel map.
        joint: that it moves.
        ratio: gear ratio [1 or rad/m].
        said: what the authors' parameters say of Stribeck friction.
    """

    name: str
    words: str
    map: str
    joint: str
    ratio: float
    said: str


@dataclass(frozen=True)
class Stretch:
    """Motion in one direction in a start-stop file, which took no part.

    Attributes:
        file: and speed and direction.
        speed: mean of the motor [rpm].
        torque: mean of the motor, once it is under way [mN m].
        std: of that mean.
        predicted: by the curve with all laws that were named [mN m].
        plain: by the best curve of Coulomb and viscous friction [mN m].
        start: how far the first 0.2 s of motion exceed the mean, in standard deviations of single samples [1].
    """

    file: str
    speed: float
    torque: float
    std: float
    predicted: float
    plain: float
    start: float


@dataclass(frozen=True, eq=False)
class Studied:
    """One drive's points of steady and of start-stop files, curves, and what the curves say of the latter."""

    drive: Drive
    points: tuple[fd.SteadyPoint, ...]
    check: tuple[fd.SteadyPoint, ...]
    curves: Mapping[int, fd.SteadyFriction]
    stretches: tuple[Stretch, ...]
