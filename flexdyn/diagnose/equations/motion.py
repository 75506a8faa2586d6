"""The dynamics of the links along the smoothed signals of one recording."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.equations.shared import SharedResults
from flexdyn.diagnose.equations.smoothed import Smoothed
from flexdyn.diagnose.lazy import kept, lazy
from flexdyn.simulation.link_side import LinkSide

Places = NDArray[np.intp] | slice
SHARED_MOTION_SHARE, SHARED_TORQUE_SHARE = 0.01, 0.1
"""Slopes are shared if motions, and their torques, differ by less than these shares of their ranges [1]."""


@dataclass(frozen=True, eq=False)
class SmoothedMotion(Smoothed):
    """Smoothed signals, and the dynamics of the links along them.

    Attributes:
        links: the link side.
        inverse_dynamics: M a + h (samples, n) [N m].
        near: a similar motion whose slopes of M a + h are used; None: its own slopes.
    """

    links: LinkSide
    inverse_dynamics: Array
    near: SmoothedMotion | None = None

    @lazy
    def M(self) -> Array:
        """Mass matrices (samples, n, n) [kg m^2]."""
        return self.links.mass_matrix(self.q)

    @kept
    def inertias(self, filters: Filters) -> Array:
        """Mass matrices at the rows of these filters (times, n, n) [kg m^2]."""
        return self.links.mass_matrix(self.q[filters.instants(len(self.t))])

    @lazy
    def ranges(self) -> tuple[float, float, float]:
        """Largest range of a position, of a speed and of a torque M a + h."""
        q, v, torque = (float(np.ptp(x, axis=0).max()) for x in (self.q, self.v, self.inverse_dynamics))
        return q, v, torque

    def dragged(self, j: int, moved: Sequence[Array], at: Places = slice(None)) -> Array:
        """Change of M a + h (samples, n) by changes of a joint's position, speed and acceleration.

        ``d(M a + h)/dq_j dq + dh/dv_j dv + M_j da``, with Pinocchio's derivatives.

        Args:
            j: the joint.
            moved: changes of its position, speed and acceleration (samples,).
            at: samples of the motion.
        """
        if self.near is not None and isinstance(at, slice):
            return self.near.dragged(j, moved, at)
        return np.asarray(sum(s * d[:, None] for s, d in zip(self._slopes(j, at), moved, strict=True)))

    def slopes_by(self, joints: Indices) -> tuple[Array, Array, Array]:
        """Slopes of M a + h at some joints by their positions, speeds and accelerations (samples, joints, joints)."""
        each = [self._slopes(j, slice(None)) for j in joints.tolist()]
        place, speed, M = (np.stack([torque[:, joints] for torque in by], axis=2) for by in zip(*each, strict=True))
        return place, speed, M

    def _slopes(self, j: int, at: Places) -> tuple[Array, Array, Array]:
        """Slopes of M a + h by a joint's position, speed and acceleration (samples, n); they are kept."""
        place = isinstance(at, slice)
        if place not in self._known:
            q = self.q[at]
            M = self.M if isinstance(at, slice) else self.links.mass_matrix(q)
            self._known[place] = (*self.links.inverse_derivatives(q, self.v[at], self.a[at]), M)
        by_place, by_speed, M = (by[:, :, j] for by in self._known[place])
        return by_place, by_speed, M

    @lazy
    def _known(self) -> dict[bool, tuple[Array, Array, Array]]:
        return {}


def motion(
    links: LinkSide, signals: Smoothed, base: SmoothedMotion | None = None, shared: SharedResults | None = None
) -> SmoothedMotion:
    """The links' dynamics along smoothed signals.

    Args:
        links: the link side.
        signals: of one recording.
        base: motion of another model in the same recording, whose slopes are used if it is similar.
        shared: what other models may have asked for; None: nothing.
    """
    total = (shared or SharedResults(1)).torques(links, signals.q, signals.v, signals.a)
    made = SmoothedMotion(**vars(signals), links=links, inverse_dynamics=total)
    return dataclasses.replace(made, near=base) if base is not None and _alike(made, base) else made


def _alike(one: SmoothedMotion, base: SmoothedMotion) -> bool:
    """Whether two motions are so similar that the slopes of M a + h can be shared: these enter only small terms."""
    if one.q.shape != base.q.shape:
        return False
    pairs = ((one.q, base.q), (one.v, base.v), (one.inverse_dynamics, base.inverse_dynamics))
    shares = (SHARED_MOTION_SHARE, SHARED_MOTION_SHARE, SHARED_TORQUE_SHARE)
    return all(np.abs(a - b).max() <= s * r for (a, b), s, r in zip(pairs, shares, base.ranges, strict=True))
