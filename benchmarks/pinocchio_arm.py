"""The same arm as a user of Pinocchio's Python would write it: pin.aba for the links, NumPy for rotors and springs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from arms import Arm, Array
from scipy.integrate import solve_ivp


class PinocchioArm:
    """An `Arm` without dry friction, its state x = [q, theta, v, omega].

    Args:
        arm: every joint elastic.
    """

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.model: Any = arm.model.robot.pin_model.copy()
        self.model.gravity.linear = np.array(arm.model.gravity)
        self.data: Any = self.model.createData()
        self.K, self.D, self.J = (np.array(getattr(arm.model, k)) for k in ("stiffness", "damping", "rotor_inertia"))
        self.on_link = arm.coefficients("viscous_friction", "link")
        self.on_rotor = arm.coefficients("viscous_friction", "motor")
        self.x0 = np.concatenate([arm.q0, arm.theta0, np.zeros(2 * arm.n)])

    def derivative(self, t: float, x: Array) -> Array:
        """X' = f(x)."""
        n = self.arm.n
        q, theta, v, omega = x[:n], x[n : 2 * n], x[2 * n : 3 * n], x[3 * n :]
        tau_s = self.K * (theta - q) + self.D * (omega - v)
        a = pin.aba(self.model, self.data, q, v, tau_s - self.on_link * v)
        alpha = (self.arm.tau - tau_s - self.on_rotor * omega) / self.J
        return np.concatenate([v, omega, a, alpha])

    def runge_kutta(self, x: Array, step: float, count: int) -> Array:
        """The state after so many steps of the classical method, the loop in Python."""
        f = self.derivative
        for _ in range(count):
            k1 = f(0.0, x)
            k2 = f(0.0, x + 0.5 * step * k1)
            k3 = f(0.0, x + 0.5 * step * k2)
            k4 = f(0.0, x + step * k3)
            x = x + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        return x

    def runge_kutta_positions(self, samples: int, between: int, step: float) -> Array:
        """[q, theta] from the first state on, every so many steps (samples + 1, 2 n) [rad]."""
        states = [self.x0]
        for _ in range(samples):
            states.append(self.runge_kutta(states[-1], step, between))
        return np.array(states)[:, : 2 * self.arm.n]

    def scipy_positions(self, method: str, grid: Array, rtol: float, atol: float) -> Array:
        """[q, theta] at the times of the grid by scipy.integrate.solve_ivp (len(grid), 2 n) [rad]."""
        solution = solve_ivp(
            self.derivative, (0.0, grid[-1]), self.x0, method=method, t_eval=grid, rtol=rtol, atol=atol
        )
        if not solution.success:
            raise RuntimeError(f"{method}: {solution.message}")
        return np.asarray(solution.y[: 2 * self.arm.n].T)
