"""A user's law at one place along the measured motion: whether it works, and in which parameters it is linear."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexdyn.arrays import Array, evenly
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.effects import JointEffect
from flexdyn.errors import InputError

LINEARITY_SAMPLES = 300
"""Number of samples of a motion that are used to test linearity."""
EQUAL_TORQUE_DIFFERENCE = 1e-7
"""Two torques with a smaller relative difference are equal [1]."""


class OwnLaw:
    """A class of a user's effect at one place, along the measured motion.

    Args:
        kind: the class.
        place: ``joint`` and ``side``.
        equations: that have the motions.
        j: index of the joint.
    """

    def __init__(self, kind: type[JointEffect], place: Mapping[str, str], equations: Equations, j: int) -> None:
        self.kind, self.place = kind, place
        side = place["side"]
        x, u = {"link": ("q", "v"), "motor": ("theta", "omega"), "transmission": ("delta", "ddelta")}[side]
        motions = equations.motions
        columns = [np.concatenate([getattr(each, name)[:, j] for each in motions]) for name in (x, u, "tau")]
        self.whole = [*columns, np.concatenate([each.t for each in motions])]
        some = evenly(len(self.whole[0]), LINEARITY_SAMPLES)
        self.some = [column[some] for column in self.whole]

    def effect(self, numbers: Mapping[str, float]) -> JointEffect:
        """The effect with these parameters."""
        return self.kind(joint=self.place["joint"], side=self.place["side"], **numbers)  # type: ignore[arg-type]

    def added(self, numbers: Mapping[str, float], columns: Sequence[Array]) -> Array:
        """Its torque (samples,)."""
        x, u, tau, t = columns
        torque = torque_of(self.effect(numbers), x, u, t=t, tau=tau)
        return torque - tau if self.kind.stage == "actuator" else torque

    def works(self, numbers: Mapping[str, float]) -> bool:
        """Whether the law is finite along the whole motion."""
        try:
            self.added(numbers, self.whole)
        except InputError:
            return False
        return True

    def first_that_works(self, points: Sequence[dict[str, float]]) -> dict[str, float]:
        """The first grid point at which the torque is not zero, else one without an error.

        Raises:
            InputError: the law raises an error at all points; the message is that of the last one.
        """
        idle, failure = None, None
        for point in points:
            try:
                if self.added(point, self.some).any():
                    return point
                idle = idle or point
            except InputError as error:
                failure = error
        if idle is None and failure is not None:
            raise failure
        return idle or {}

    def linear_in(self, base: Mapping[str, float]) -> list[str]:
        """Parameters in which the torque is jointly linear: it adds up, scales, and is zero if they are 0."""
        chosen: list[str] = []
        for entry in self.kind.parameters():
            if self._is_linear([*chosen, entry.name], base):
                chosen.append(entry.name)
        return chosen

    def _is_linear(self, names: Sequence[str], base: Mapping[str, float]) -> bool:
        """Whether the torque is linear in these parameters, and each of them acts."""
        nothing = dict(base) | dict.fromkeys(names, 0.0)
        try:
            whole = self.added(base, self.some)
            twice = self.added(dict(base) | {name: 2.0 * base[name] for name in names}, self.some)
            alone = [self.added(nothing | {name: base[name]}, self.some) for name in names]
            rest = self.added(nothing, self.some)
        except InputError:
            return False
        size = EQUAL_TORQUE_DIFFERENCE * float(np.abs(whole).max())
        off = max(float(np.abs(each).max()) for each in (np.sum(alone, axis=0) - whole, twice - 2.0 * whole, rest))
        acting = all(np.abs(each).max() > size for each in alone)
        return size > 0.0 and acting and off < size
