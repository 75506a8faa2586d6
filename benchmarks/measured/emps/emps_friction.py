"""A law that the catalogue lacks: viscous friction that depends on the direction, as in the authors' second model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn.effects import parameter
from flexdyn.effects.base import JointEffect


class ViscousAsymmetry(JointEffect):
    """What viscous friction has more in the positive direction than on average, and less in the negative one.

    ``f = coefficient abs(u)``: beside ``viscous_friction`` of at least that size, whose coefficient is then
    ``viscous + coefficient`` for u > 0 and ``viscous - coefficient`` for u < 0. One number of either sign, so that
    none has to share what the model's own viscous friction does already.

    Args:
        joint: its name.
        side: ``link`` or ``motor``.
        coefficient: half the difference of the two directions [N m s/rad].
    """

    sides = ("link", "motor")
    stage = "friction"
    law = "coefficient*abs(u)"
    neutral: ClassVar[Mapping[str, float]] = {"coefficient": 0.0}
    shown: ClassVar[Mapping[str, float]] = {"coefficient": 0.2}

    coefficient: float = parameter("N m s/rad")

    def torque(self, x: ArrayLike, u: ArrayLike, *, t: ArrayLike = 0.0, tau: ArrayLike = 0.0) -> NDArray[np.float64]:
        """The law [N m or N]."""
        return np.asarray(self.coefficient * np.abs(np.asarray(u, dtype=float)))
