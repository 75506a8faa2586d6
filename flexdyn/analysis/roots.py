"""Roots: of many functions of one unknown each, and of the torques on an arm, which depend on all positions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexdyn.arrays import Array, Flags

Balance = Callable[[Array], Array]
MOST_DOUBLINGS = 100
"""Doublings of the first step after which a component counts as having no root."""
Net = Callable[[Array], Array]
LONGEST_STEP = 0.5
"""Largest step of a joint [rad or m]."""
EQUILIBRIUM_TORQUE_SHARE = 1e-9
"""A net torque below this share of the torques on the arm is an equilibrium [1]."""


def roots(f: Balance, start: Array, step: Array, tolerance: Array | float) -> tuple[Array, Flags]:
    """Solve f_j(x_j) = 0 for every j together.

    Args:
        f: (n,) -> (n,), component by component, nowhere decreasing.
        start: first guess (n,); kept where abs(f) is within the tolerance.
        step: first step of the search (n,), above 0.
        tolerance: of abs(f); if rounding of x does not allow it, the best x is used.

    Returns:
        The roots (n,), and whether there is one (n,); where there is none, x is the end of the search.
    """
    low, high, f_low, f_high = _brackets(f, start, step, tolerance)
    found = (f_low <= tolerance) & (f_high >= -tolerance)
    for turn in range(400):
        inside = np.spacing(np.maximum(np.abs(low), np.abs(high)))
        open_ = found & (np.abs(f_low) > tolerance) & (np.abs(f_high) > tolerance) & (high - low > inside)
        if not open_.any():
            break
        # False position, and every third time bisection: kinks and flat pieces cannot stop the progress.
        width = np.where(open_, f_high - f_low, 1.0)
        share = np.full_like(low, 0.5) if turn % 3 == 2 else np.clip(-f_low / width, 1e-3, 1.0 - 1e-3)
        middle = np.where(open_, low + share * (high - low), low)
        exact = np.where(open_, low - f_low * (high - low) / width, low)
        if turn % 3 == 0:
            middle = np.where(open_ & (exact > low) & (exact < high), exact, middle)
        value = f(middle)
        left, right = open_ & (value < 0), open_ & (value >= 0)
        low, f_low = np.where(left, middle, low), np.where(left, value, f_low)
        high, f_high = np.where(right, middle, high), np.where(right, value, f_high)
    return np.where(np.abs(f_low) <= np.abs(f_high), low, high), found


def _brackets(f: Balance, start: Array, step: Array, tolerance: Array | float) -> tuple[Array, Array, Array, Array]:
    """Intervals in which every component changes its sign, found by doubling steps from the start."""
    value = f(start)
    low, high, f_low, f_high = start.copy(), start.copy(), value.copy(), value.copy()
    reach = step.copy()
    for _ in range(MOST_DOUBLINGS):
        down, up = f_low > tolerance, f_high < -tolerance
        if not (down.any() or up.any()):
            break
        # One end becomes the other: the root is within the last step.
        high, f_high = np.where(down, low, high), np.where(down, f_low, f_high)
        low, f_low = np.where(up, high, low), np.where(up, f_high, f_low)
        low, high = np.where(down, low - reach, low), np.where(up, high + reach, high)
        f_low, f_high = np.where(down, f(low), f_low), np.where(up, f(high), f_high)
        reach = 2.0 * reach
    return low, high, f_low, f_high


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
        return self.newton(low) if arrived else (q, False)

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
        return q, float(np.linalg.norm(y)) <= EQUILIBRIUM_TORQUE_SHARE * self._size

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

    @staticmethod
    def _short(step: Array) -> Array:
        return step * min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-300))
