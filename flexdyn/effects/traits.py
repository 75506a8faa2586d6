"""What code outside this package asks of an effect beside its law: properties that its class declares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal, Self

Limit = Literal["range", "effort"]
"""Limits in a URDF that an effect may keep a joint to."""
UNCOUNTED = ("friction", "damping", "elasticity", "drag", "backlash", "hysteresis", "ripple", "eccentricity")
"""What the name of an effect ends with where it takes no article in English."""


class Traits:
    """Properties of an effect for drawings, reports, analyses, the energy ledger and model files.

    Code outside asks for these and never for a single class, so that an effect of a user's own is treated like one of
    flexdyn's. A class that declares nothing has the default.

    Class attributes:
        words: its name in a sentence; default: the name with spaces.
        part_of: of a law that only the plant has: name of the effect that it is a part of.
        timed: it depends on the time since the start of the run; then `later` shifts the zero of time.
        conservative: it stores energy and takes none, and the core knows how much.
        cuts_torque: it limits the torque of a motor, so that a pose or a small motion must not reach it.
        scales_torque: of a gain of the motor's torque, ``tau_applied = (1 + gain) tau``, the parameter that is the
            gain. Several on one joint add.
        keeps_to: the limit of a URDF that it enforces, ``range`` or ``effort``: `flexdyn.enforce_limits` adds no other.
        exact: parameters that are exact where a model file has the effect, as the ratio of teeth is.
        regressed: the number of a joint in a linear regressor that its first linear parameter adds to: ``viscous``,
            ``coulomb`` or ``offset``.
        steady: `flexdyn.steady_friction` tries it in addition to Coulomb and viscous friction: a law of the speed alone
            that opposes the motion, and whose `axes` are speeds.
    """

    words: ClassVar[str] = ""
    part_of: ClassVar[str] = ""
    timed: ClassVar[bool] = False
    conservative: ClassVar[bool] = False
    cuts_torque: ClassVar[bool] = False
    scales_torque: ClassVar[str] = ""
    keeps_to: ClassVar[Limit | None] = None
    exact: ClassVar[tuple[str, ...]] = ()
    regressed: ClassVar[str] = ""
    steady: ClassVar[bool] = False

    @classmethod
    def uncertain(cls) -> tuple[str, ...]:
        """Parameters that may be wrong where a model file has the effect, so that a diagnosis estimates them.

        None of a mass, a sensor or a spring, nor of what says itself that a number is wrong.
        """
        return ()

    @property
    def torque_gain(self) -> float:
        """Gain of the motor's torque [1]; 0: it does not scale the torque."""
        return float(getattr(self, self.scales_torque)) if self.scales_torque else 0.0

    def later(self, begin: float) -> Self:
        """The effect in a run that starts at this time of the first one [s]."""
        return self

    def check_beside(self, others: Sequence[Any]) -> None:
        """Refuse effects of the same model beside which it cannot stand.

        Raises:
            InputError: one of them; the key is the parameter.
        """


def article(words: str) -> str:
    """``a `` or ``an `` before the name of an effect, where it takes an article."""
    if words.endswith(UNCOUNTED):
        return ""
    return "an " if words[:1] in "aeiou" else "a "
