"""Effects with memory: their torque depends on the path, through an internal state z."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects.joint_effect import JointEffect


class MemoryEffect(JointEffect, abstract=True):
    """An effect on one joint with a state of its own: ``z' = u - abs(u) z/reach``.

    While u keeps its sign, z depends on the covered distance s and not on time: ``dz/ds = sgn(u) - z/reach``, so ``z ->
    sgn(u) reach`` after a few times the reach.

    Example:
        >>> contact = fd.effects.PreslidingFriction("elbow", side="link", level=0.5, stiffness=100.0)
        >>> contact.along([0.0, 0.001, 1.0]).round(3)  # a spring at first, then the friction level
        array([0.   , 0.091, 0.5  ])
    """

    no_torque = "it depends on the path: use along(x)"

    @property
    def reach(self) -> float:
        """Largest abs(z) [rad or m]; a loop closes over about four times this distance."""
        raise NotImplementedError

    def states_along(self, x: ArrayLike, z0: float = 0.0) -> Array:
        """The state z along a path, exact for a path that is monotone between its points.

        Args:
            x: position on the effect's side, delta in a transmission (samples,) [rad or m].
            z0: the state at its start [rad or m].

        Returns:
            z (samples,) [rad or m].
        """
        path = np.ascontiguousarray(x, dtype=float)
        z = np.zeros(path.shape)
        if self.reach > 0.0:
            _core.states_along(path, self.reach, z0, z)
        return z

    def along(self, x: ArrayLike, u: ArrayLike = 0.0, z0: float = 0.0) -> Array:
        """The torque along a path.

        Args:
            x: as `states_along` takes it.
            u: the velocity there, for damping of the state (samples,) [rad/s or m/s]; 0: slow motion.
            z0: the state at its start [rad or m].

        Returns:
            the torque (samples,) [N m or N].
        """
        z = self.states_along(x, z0)
        if self.reach == 0.0:
            return z
        nothing = np.zeros(z.shape)
        return self._evaluate(nothing, nothing, nothing + np.asarray(u, dtype=float), nothing, z)

    def example_path(self) -> Array:
        """A path that shows the loop: out and back twice, widely and then less so (samples,) [rad or m]."""
        turns = self.reach * np.array([0.0, 4.0, -4.0, 4.0, 2.0, 4.0])
        return np.interp(np.linspace(0.0, 5.0, 1201), np.arange(6.0), turns)
