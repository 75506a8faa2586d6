"""Find positions at which motor torques balance an arm: Newton with line search, then descent of the potential."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexdyn.arrays import Array

Net = Callable[[Array], Array]
LONGEST_STEP = 0.5
"""Largest step of a joint [rad or m]."""
EQUILIBRIUM_TORQUE_SHARE = 1e-9
"""A net torque below this share of the torques on the arm is an equilibrium [1]."""


class Search:
    """One problem net(q) = 0.

    Args:
        net: net torque on every joint (n,) at positions (n,) [N m or N].
        mass: M at the first guess (n, n); it makes torques of different joints comparable.
        size: of the torques on the arm (n,), gravity and motors [N m or N].
    """

    def __init__(self, net: Net, mass: Array, size: Array) -> None:
        self._net = net
        self._weight = 1.0 / np.sqrt(np.diag(mass))
        # If nothing loads the arm, accelerations of 1e-11 m/s^2 are rounding errors.
        self._size = max(float(np.linalg.norm(size * self._weight)), 1e-2 * float(np.sqrt(np.trace(mass))))

    def find(self, guess: Array) -> tuple[Array, bool]:
        """The equilibrium that Newton reaches from the guess, else one of lower potential; and whether there is one."""
        q, found = self.newton(guess)
        if found:
            return q, True
        low, arrived = self._downhill(guess)
        if arrived:
            return self.newton(low)
        return q, False

    def newton(self, q: Array) -> tuple[Array, bool]:
        """Newton's method with minimum-norm steps, each of which is shortened until the torques decrease."""
        y = self._torques(q)
        for _ in range(100):
            size = float(np.linalg.norm(y))
            step = np.linalg.lstsq(self._slope(q), -y, rcond=1e-7)[0] * self._weight
            step = self._short(step)
            share = 1.0
            while share > 1e-6:
                trial = q + share * step
                value = self._torques(trial)
                if np.linalg.norm(value) < (1.0 - 1e-4 * share) * size:
                    break
                share *= 0.5
            else:
                break
            q, y = trial, value
        return q, self._balanced(y)

    def _downhill(self, q: Array) -> tuple[Array, bool]:
        """Minimise the potential, by Newton steps in directions of positive curvature."""
        y = self._torques(q)
        for _ in range(150):
            if np.linalg.norm(y) <= 1e-4 * self._size:
                return q, True
            slope = -self._slope(q)
            curves, directions = np.linalg.eigh(0.5 * (slope + slope.T))
            size = np.maximum(np.abs(curves), 1e-9 * max(1.0, float(np.abs(curves).max())))
            along = directions @ ((directions.T @ y) / size)
            step = self._short(along * self._weight)
            share, gain = 1.0, float(y @ (step / self._weight))
            while share > 1e-6:
                trial = q + share * step
                value = self._torques(trial)
                if value @ (step / self._weight) > -0.5 * gain:  # not far beyond the minimum along this line
                    break
                share *= 0.5
            q, y = trial, value
        return q, False

    def _torques(self, q: Array) -> Array:
        """Net torques in units of sqrt(kg) m/s^2, the same for revolute and prismatic joints."""
        return self._net(q) * self._weight

    def _slope(self, q: Array) -> Array:
        """d(torques)/d(q / weight) (n, n) by central differences."""
        h = 1e-6
        unit = np.eye(len(q)) * h
        columns = [(self._torques(q + e) - self._torques(q - e)) / (2.0 * h) for e in unit]
        return np.array(columns).T * self._weight

    def _balanced(self, y: Array) -> bool:
        return float(np.linalg.norm(y)) <= EQUILIBRIUM_TORQUE_SHARE * self._size

    @staticmethod
    def _short(step: Array) -> Array:
        return step * min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-300))
