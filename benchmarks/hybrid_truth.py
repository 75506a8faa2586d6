"""The two-link arm of two_link_equations.py with dry friction on its links and play in its gears, between its corners.

Nothing here knows of flexdyn: which joints stick is found by trying all modes, and SciPy is stopped and started again
at every stop, break-away and touch.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from two_link_equations import CENTRE, INERTIA, LENGTH, MASS, TIP

Array = NDArray[np.float64]
Motion = tuple[int, int]
D22 = MASS * CENTRE**2 + INERTIA + TIP * LENGTH**2  # eq. 17
COUPLING = MASS * LENGTH * CENTRE + TIP * LENGTH**2
FIXED = D22 + MASS * CENTRE**2 + INERTIA + (MASS + TIP) * LENGTH**2
HOP = 1e-8  # s after a corner in which no other is looked for: the root lies on either side of it by rounding


@dataclass(frozen=True, eq=False)
class TwoLinkWithCorners:
    """Two uniform rods, horizontal; x = [q, theta, v, omega], both joints each.

    Attributes:
        stiffness: of the springs [N m/rad].
        damping: across them [N m s/rad].
        rotor: inertias [kg m^2].
        viscous: on the links [N m s/rad].
        level: of Coulomb friction on the links [N m]; 0: none.
        half_gap: of the gears [rad].
        tau: motor torques [N m].
    """

    stiffness: Array
    damping: Array
    rotor: Array
    viscous: Array
    level: Array
    half_gap: Array
    tau: Array

    def net(self, x: Array) -> tuple[Array, Array, Array]:
        """M(q), link torques without dry friction, torque of the transmissions (eq. 12, 13, 16-19)."""
        delta = x[2:4] - x[0:2]
        spring = self.stiffness * (delta - np.clip(delta, -self.half_gap, self.half_gap))
        spring = spring + self.damping * (x[6:8] - x[4:6])
        c2, c = COUPLING * cos(x[1]), COUPLING * sin(x[1])
        M = np.array([[FIXED + 2.0 * c2, D22 + c2], [D22 + c2, D22]])
        turning = np.array([c * x[5] * x[5] + 2.0 * c * x[4] * x[5], -c * x[4] * x[4]])
        return M, spring - self.viscous * x[4:6] + turning, spring

    def links(self, x: Array, motion: Motion) -> tuple[Array, Array, Array]:
        """Accelerations, friction torques and transmission torques while every link slides one way or sticks (0)."""
        M, drive, spring = self.net(x)
        free = [j for j in (0, 1) if motion[j] or not self.level[j]]
        a, friction = np.zeros(2), np.array(motion) * self.level
        if len(free) == 2:
            b = drive - friction
            a = np.array([M[1, 1] * b[0] - M[0, 1] * b[1], M[0, 0] * b[1] - M[0, 1] * b[0]])
            a /= M[0, 0] * M[1, 1] - M[0, 1] ** 2
        elif free:
            a[free[0]] = (drive - friction)[free[0]] / M[free[0], free[0]]
        for j in {0, 1} - set(free):
            friction[j] = (drive - M @ a)[j]
        return a, friction, spring

    def derivative(self, x: Array, motion: Motion) -> Array:
        """X' = f(x)."""
        a, _, spring = self.links(x, motion)
        return np.concatenate([x[4:8], a, (self.tau - spring) / self.rotor])

    def next_motion(self, x: Array) -> Motion:
        """The one way in which the links at rest can go on without contradiction.

        Raises:
            RuntimeError: there is none, or more than one.
        """
        choices = [
            (0,) if not self.level[j] else (-1, 0, 1) if x[4 + j] == 0.0 else (int(np.sign(x[4 + j])),) for j in (0, 1)
        ]
        good: list[Motion] = []
        for motion in itertools.product(*choices):
            a, friction, _ = self.links(x, (motion[0], motion[1]))
            at_rest = [j for j in (0, 1) if self.level[j] and x[4 + j] == 0.0]
            if all(motion[j] * a[j] > 0.0 if motion[j] else abs(friction[j]) <= self.level[j] for j in at_rest):
                good.append((motion[0], motion[1]))
        if len(good) != 1:
            raise RuntimeError(f"{len(good)} consistent motions at {x}")
        return good[0]

    def switches(self, motion: Motion) -> list[Any]:
        """Functions whose zeros are corners while the links move so."""
        found: list[Any] = []
        for j in (0, 1):
            if self.level[j] and motion[j]:
                found.append(lambda t, x, j=j: motion[j] * x[4 + j])
            elif self.level[j]:
                found.append(lambda t, x, j=j: self.level[j] - abs(self.links(x, motion)[1][j]))
            if self.half_gap[j]:
                found.append(lambda t, x, j=j: x[2 + j] - x[j] - self.half_gap[j])
                found.append(lambda t, x, j=j: x[2 + j] - x[j] + self.half_gap[j])
        for switch in found:
            switch.terminal = True
        return found

    def positions(self, x0: Array, grid: Array, max_step: float) -> tuple[Array, int]:
        """[q, theta] at the times of the grid (len(grid), 4) [rad], and how many corners were passed.

        Raises:
            RuntimeError: SciPy gave up.
        """
        t, x, end, hop, corners = float(grid[0]), x0.copy(), float(grid[-1]), False, 0
        rows: list[Array] = []
        motion = self.next_motion(x)
        while True:
            piece = solve_ivp(
                lambda t, x, motion=motion: self.derivative(x, motion),
                (t, min(t + HOP, end) if hop else end),
                x,
                method="DOP853",
                rtol=1e-13,
                atol=1e-14,
                max_step=max_step,
                events=None if hop else self.switches(motion),
                dense_output=True,
            )
            if not piece.success:
                raise RuntimeError(piece.message)
            last = float(piece.t[-1])
            inside = (grid >= t) & ((grid < last) | (last == end))
            if inside.any():
                rows.append(piece.sol(grid[inside])[:4].T)
            if last == end:
                return np.vstack(rows), corners
            t, x = last, piece.y[:, -1].copy()
            if not hop:
                corners += 1
                for j in (0, 1):
                    if self.level[j] and motion[j] and abs(x[4 + j]) < 1e-12:
                        x[4 + j] = 0.0
                motion = self.next_motion(x) if self.level.any() else motion
            hop = not hop
