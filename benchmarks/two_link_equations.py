"""The paper's two-link arm with elastic joints in closed form, eq. 12-19, and its motion at tight tolerance.

Nothing here knows of flexdyn: numbers are those of the paper's Table I, written out, and of the shipped model where
the paper has none (the rotor's inertia, the levels of dry friction).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, pi, sin, tanh

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

LENGTH = 1.05  # m, Table I
MASS = 0.405 * LENGTH  # kg, Table I: linear density times length
CENTRE = LENGTH / 2  # m, uniform rod
INERTIA = MASS * LENGTH**2 / 12  # kg m^2, slender rod
TIP = 0.1  # kg, Table I, a point mass: I_L = 0
STIFFNESS = 5.5  # N m/rad, Table I
ROTOR = 0.1  # kg m^2, reflected

DURATION = 5.0  # s
MAX_STEP = 5e-3  # s, of the truth: eq. 1 has a kink at rest that a long step would miss
Q0 = (0.0, pi / 2)  # rad, Table I
THETA0 = (0.3, 1.3)  # rad: springs strained at the start
TORQUE_TIMES = np.linspace(0.0, DURATION, 4)  # four points: one cubic polynomial, exact for every spline
TORQUE_VALUES = np.array([[0.4, -0.2], [-0.3, 0.3], [0.5, -0.1], [-0.4, 0.2]])  # N m


@dataclass(frozen=True)
class Friction:
    """Friction on the links, eq. 1 and 20-21, with tanh(u/width) for sgn(u).

    Attributes:
        viscous: b^v [N m s/rad].
        level: b^d [N m].
        excess: b^s - b^d [N m].
        velocity: epsilon [rad/s].
        width: of the smoothed sign [rad/s].
    """

    viscous: float
    level: float = 0.0
    excess: float = 0.0
    velocity: float = 1.0
    width: float = 1.0

    def torque(self, u: float) -> float:
        """B(u) [N m]."""
        dry = self.level + self.excess * exp(-abs(u) / self.velocity)
        return self.viscous * u + dry * tanh(u / self.width)


def equations(friction: Friction) -> Callable[[float, Array], list[float]]:
    """X' = f(t, x), x = [q1, q2, theta1, theta2, and their rates]; the paper's q3, q4 are theta1, theta2."""
    tau1, tau2 = (Polynomial.fit(TORQUE_TIMES, column, 3).convert().coef.tolist() for column in TORQUE_VALUES.T)
    D22 = MASS * CENTRE**2 + INERTIA + TIP * LENGTH**2  # eq. 17
    coupling = MASS * LENGTH * CENTRE + TIP * LENGTH**2
    fixed = D22 + MASS * CENTRE**2 + INERTIA + (MASS + TIP) * LENGTH**2

    def f(t: float, x: Array) -> list[float]:
        q1, q2, theta1, theta2, v1, v2, omega1, omega2 = x.tolist()
        D11 = fixed + 2.0 * coupling * cos(q2)  # eq. 16
        D12 = D22 + coupling * cos(q2)  # eq. 18
        C = coupling * sin(q2)  # eq. 19
        spring1, spring2 = STIFFNESS * (theta1 - q1), STIFFNESS * (theta2 - q2)
        right1 = spring1 - friction.torque(v1) + C * v2 * v2 + 2.0 * C * v1 * v2  # eq. 12
        right2 = spring2 - friction.torque(v2) - C * v1 * v1  # eq. 13
        det = D11 * D22 - D12 * D12
        a1, a2 = (D22 * right1 - D12 * right2) / det, (D11 * right2 - D12 * right1) / det
        return [v1, v2, omega1, omega2, a1, a2, (_at(tau1, t) - spring1) / ROTOR, (_at(tau2, t) - spring2) / ROTOR]

    return f


def truth(
    friction: Friction, grid: Array, rtol: float = 1e-13, atol: float = 1e-14, max_step: float = MAX_STEP
) -> Array:
    """[q1, q2, theta1, theta2] at the times of the grid (len(grid), 4) [rad].

    Raises:
        RuntimeError: SciPy gave up.
    """
    start = np.array([*Q0, *THETA0, 0.0, 0.0, 0.0, 0.0])
    solution = solve_ivp(
        equations(friction),
        (0.0, DURATION),
        start,
        method="DOP853",
        t_eval=grid,
        rtol=rtol,
        atol=atol,
        max_step=max_step,
    )
    if not solution.success:
        raise RuntimeError(solution.message)
    return np.asarray(solution.y[:4].T)


def _at(coefficients: list[float], t: float) -> float:
    c0, c1, c2, c3 = coefficients
    return c0 + t * (c1 + t * (c2 + t * c3))
