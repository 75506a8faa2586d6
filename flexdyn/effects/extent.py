"""What a joint does in recordings: the scales of what a diagnosis tries of an effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SLOW_HARMONICS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Cycles per turn of the joint that are tried [1]."""

DELAYS = (0.0005, 0.001, 0.002, 0.004, 0.008)
"""Delays of commands and channels that are tried [s]: from a sample of a fast drive to that of a slow bus."""


@dataclass(frozen=True)
class MotionExtent:
    """Scales of a joint's motion in the data.

    Attributes:
        speed: nearly the largest speed of the rotor [rad/s].
        span: range of the rotor's position [rad].
        deflection: nearly the largest one, 0 for a rigid joint [rad].
        torque: the largest commanded torque [N m].
        given: nearly the largest torque that the motion needs according to the model, at most `torque` [N m].
        seconds: duration of the longest recording [s].
        low, high: ends of the link's range [rad].
        ratio: of the gear [1].
        turns: whether the joint is revolute, so that effects may be periodic over a turn.
        half_gaps: possible half gaps of the transmission [rad].
        signal: of the channel, where an effect acts on one.
    """

    speed: float
    span: float
    deflection: float
    torque: float
    given: float
    seconds: float
    low: float
    high: float
    ratio: float
    turns: bool = True
    half_gaps: tuple[float, ...] = ()
    signal: str = ""

    def size(self, scale: str) -> float:
        """A scale by its name; 1 for ``one``."""
        return 1.0 if scale == "one" else float(getattr(self, scale))

    def waves(self, of_joint: Sequence[float] = (), of_motor: Sequence[float] = ()) -> list[tuple[float]]:
        """Cycles per turn that a joint can show.

        Of a wave that a sliding joint follows for less than a radian it sees a constant and a slope: other laws.

        Args:
            of_joint: cycles per turn of the joint.
            of_motor: cycles per turn of the motor.
        """
        cycles = (*of_joint, *(k * self.ratio for k in of_motor))
        return [(h,) for h in cycles if self.turns or h * self.span >= 1.0]
