"""Amplitude and decay of the vibration of an arm, from simulations and from the linearised equations."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebfit, chebval
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.paper.cases import CASES_OBSERVED, TORQUE_END
from flexdyn.paper.equations import Arm, mass_matrix
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solvers import DormandPrince


def amplitude(arm: Arm, run: Run) -> Array:
    """Vibration amplitude (samples,) [rad]: the deflection at which one spring would hold all energy of the vibration.

    Without torque, friction and Coriolis terms the deflection delta = theta - q obeys ``mu delta'' = -K delta`` with
    ``mu = (D^-1 + J^-1)^-1``. Then ``A^2 = delta^T delta + delta'^T mu delta'/K`` is constant, also when the two modes
    beat: A is an envelope, and no peaks have to be found.
    """
    mu = np.linalg.inv(np.linalg.inv(mass_matrix(arm, run.q)) + np.eye(2) / arm.J)
    rate = run.omega - run.v
    kinetic = np.einsum("ti,tij,tj->t", rate, mu, rate)
    return np.asarray(np.sqrt((run.deflection**2).sum(1) + kinetic / arm.K))


@dataclass(frozen=True)
class Residual:
    """The vibration that remains after the torque.

    Attributes:
        first: amplitude, root mean square over the first second after the torque ended [rad].
        last: the same ten seconds later [rad].
        rate: of the exponential fitted to the amplitude in between [1/s].
    """

    first: float
    last: float
    rate: float

    @property
    def left(self) -> float:
        """The part of the amplitude that is left after ten seconds [1]."""
        return self.last / self.first

    def to_dict(self) -> dict[str, float]:
        """All numbers, for the JSON summary."""
        return vars(self) | {"left": self.left}


def residual(arm: Arm, run: Run) -> Residual:
    """Measure the vibration after the torque of Fig. 4."""
    size = amplitude(arm, run)
    after = run.t >= TORQUE_END
    first = after & (run.t < TORQUE_END + 1.0)
    last = run.t >= TORQUE_END + CASES_OBSERVED
    start, end = (float(np.sqrt((size[window] ** 2).mean())) for window in (first, last))
    return Residual(start, end, decay_rate(run.t[after], size[after]))


def decay_rate(t: Array, size: Array) -> float:
    """Rate r [1/s] of the exponential ``exp(-r t)`` that fits an amplitude best (least squares of its logarithm)."""
    return float(-np.polyfit(t, np.log(size), 1)[0])


def ringing_after(run: Run) -> float:
    """Size of the oscillation of the links' angles during the five seconds after the torque of Fig. 4.

    Returns:
        root mean square of the residual of q1 and q2 after a fit of polynomials of degree 7 [rad]: coasting and braking
        are smooth, vibration is not.
    """
    window = (run.t >= TORQUE_END) & (run.t <= TORQUE_END + 5.0)
    s, q = (run.t[window] - TORQUE_END) / 2.5 - 1.0, run.q[window]
    left = q - chebval(s, chebfit(s, q, 7)).T
    return float(np.sqrt((left**2).sum(1).mean()))


@dataclass(frozen=True)
class Mode:
    """A vibration of the linearised eq. 12-15: x = Re(shape exp(eigenvalue t)).

    Attributes:
        eigenvalue: [1/s].
        shape: q, theta [rad], v, omega [rad/s], largest deflection 1 rad (8,).
    """

    eigenvalue: complex
    shape: NDArray[np.complex128]

    @property
    def rate(self) -> float:
        """Rate of its decay [1/s]."""
        return -self.eigenvalue.real

    @property
    def frequency(self) -> float:
        """Frequency with damping [Hz]."""
        return self.eigenvalue.imag / (2 * np.pi)

    @property
    def decrement(self) -> float:
        """Logarithmic decrement: ln of the ratio of two successive peaks [1]."""
        return self.rate / self.frequency


def paper_modes(arm: Arm, q2: float) -> list[Mode]:
    """The vibrations of eq. 12-15 linearised at rest at an elbow angle [rad], slowest first.

    Motions that do not oscillate are left out: the arm as a whole, and joints with so much damping that they creep.
    """
    D = np.linalg.inv(mass_matrix(arm, np.array([0.0, q2])))
    system = np.zeros((8, 8))
    system[:4, 4:] = np.eye(4)
    system[4:6, :4] = arm.K * np.hstack([-D, D])
    system[4:6, 4:6] = -arm.v * D
    system[6:, :4] = arm.K / arm.J * np.hstack([np.eye(2), -np.eye(2)])
    values, vectors = np.linalg.eig(system)
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag > 1e-3:
            deflection = vector[2:4] - vector[:2]
            found.append(Mode(complex(value), vector / deflection[np.argmax(np.abs(deflection))]))
    return sorted(found, key=lambda mode: mode.frequency)


def pluck_rate(arm: Arm, model: FlexibleJointModel, mode: Mode, q2: float) -> float:
    """Decay rate [1/s] of the simulated arm, which starts in a mode's shape with a deflection of 1 mrad."""
    x0 = 1e-3 * mode.shape.real + np.array([0.0, q2, 0.0, q2, 0.0, 0.0, 0.0, 0.0])
    periods = max(2.0, round(min(10.0, 3.0 / mode.rate) * mode.frequency))
    grid = np.linspace(0.0, periods / mode.frequency, 1000)
    run = simulate(
        model,
        duration=float(grid[-1]),
        solver=DormandPrince(rtol=1e-10, atol=1e-13),
        q0=x0[:2],
        theta0=x0[2:4],
        v0=x0[4:6],
        omega0=x0[6:],
        times=grid,
    )
    return decay_rate(run.t, amplitude(arm, run))


def slowest_rates(arm: Arm, dampings: Array, q2: float) -> Array:
    """Rate [1/s] of the vibration that decays slowest, over the damping v of both joints [N m s/rad]."""
    return np.array([min(mode.rate for mode in paper_modes(replace(arm, v=float(v)), q2)) for v in dampings])
