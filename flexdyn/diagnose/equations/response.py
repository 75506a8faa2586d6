"""How links whose motors' motion is known respond to small torques: masses on their springs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array

FOURTH_ORDER, ALWAYS_STABLE = 1.0 / 12.0, 1.0 / 4.0
"""Newmark's beta: exact to fourth order in the time step, or stable for every stiffness [1]."""
LARGEST_TURN = 2.0
"""Largest frequency times the time step with the first one, which is stable up to the root of 6 [rad]."""


@dataclass(frozen=True, eq=False)
class LinkResponse:
    """The deflections y = theta - q of joints that a torque f on their links causes: ``M y'' + D y' + K y = f``.

    Here D and K also have the slopes of the arm's own torques by speeds and positions: gravity and Coriolis torques
    change the frequency of a vibration, and where it lasts for hundreds of periods, a hundredth of it is another phase.

    Newmark's method with accelerations at three samples (Fox and Goodwin, 1949; Hughes, The Finite Element Method,
    1987, section 9.1). The links begin at rest.

    Attributes:
        band: the steps as a lower triangular band matrix (3 joints, joints * samples), sample by sample.
        solved: inverse of A in the steps ``A y(k+1) = ...`` (samples, joints, joints).
        beta: Newmark's parameter of each spring (joints,).
        dt: between samples [s].
        rates: matrix A of ``x' = A x``, x = (y, y'), at the first sample (2 joints, 2 joints).
    """

    band: Array
    solved: Array
    beta: Array
    dt: float
    rates: Array

    @classmethod
    def of(cls, M: Array, K: Array, D: Array, dt: float) -> LinkResponse:
        """The response of joints.

        Args:
            M: mass matrix of the joints (samples, joints, joints) [kg m^2 or kg].
            K: slopes of their torques by deflections (samples, joints, joints) [N m/rad or N/m].
            D: the same by rates of deflections (samples, joints, joints) [N m s/rad or N s/m].
            dt: between samples [s].
        """
        many, n = K.shape[:2]
        fastest = np.sqrt(np.abs(np.diagonal(K, axis1=1, axis2=2) / np.diagonal(M, axis1=1, axis2=2)).max(axis=0))
        beta = np.where(n * fastest * dt < LARGEST_TURN, FOURTH_ORDER, ALWAYS_STABLE)
        heavy, damped, sides = M / dt**2, D / (2.0 * dt), beta * K
        solved = np.asarray(np.linalg.inv(heavy + damped + sides), dtype=float)
        last = solved @ (2.0 * heavy - (K - 2.0 * sides))
        before = solved @ (damped - heavy - sides)
        band = np.zeros((3 * n, many, n))
        band[0] = 1.0
        for back, step in ((1, last), (2, before)):
            for row in range(n):
                for column in range(n):
                    band[back * n + row - column, : many - back, column] = -step[back - 1 : many - 1, row, column]
        inverse = np.linalg.inv(M[0])
        rates = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K[0], -inverse @ D[0]]])
        return cls(band.reshape(3 * n, many * n), solved, beta, dt, rates)

    def __call__(self, f: Array) -> Array:
        """Deflections (samples, joints) [rad or m] under torques (samples, joints) [N m or N]."""
        given = np.zeros_like(f)
        mean = self.beta * (f[2:] + f[:-2]) + (1.0 - 2.0 * self.beta) * f[1:-1]
        given[2:] = np.einsum("kij,kj->ki", self.solved[1:-1], mean)
        return self._stepped(given)

    def free(self, y: Array, v: Array, earlier: float = 0.0) -> Array:
        """Free vibration (samples, joints) from deflections y and rates v (joints,), a time before the first sample."""
        from scipy.linalg import expm

        n = len(y)
        y, v = (expm(self.rates * earlier) @ np.concatenate([y, v])).reshape(2, n)
        given = np.zeros((len(self.solved), n))
        last, before = (
            -np.array([[self.band[back * n + row - column, column] for column in range(n)] for row in range(n)])
            for back in (1, 2)
        )
        # Sample -1 from the central difference v = (y(1) - y(-1))/(2 dt).
        second = np.linalg.solve(np.eye(n) - before, last @ y - 2.0 * self.dt * before @ v)
        given[0], given[1] = y, second - last @ y
        return self._stepped(given)

    def _stepped(self, given: Array) -> Array:
        """The steps, of which each adds something (samples, joints)."""
        from scipy.linalg.lapack import dtbtrs

        y, _ = dtbtrs(self.band, given.reshape(-1, 1), uplo="L")
        return np.asarray(y.reshape(given.shape))
