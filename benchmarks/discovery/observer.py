"""How well a law explains noise-free data: prediction errors of a Kalman filter of fixed gain around the simulator.

The filter knows the noise of the case (steps of the encoders, torque noise), so the squares of its errors over their
covariance are twice the logarithm of the likelihood ratio to the true law, whose errors are zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import layout as at
import numpy as np
from compiled import compiled
from layout import Array
from recording import TORQUE_NOISE
from scipy.linalg import solve_discrete_are
from two_link_run import PERIOD, Plant, one_period

STEP = 5e-4  # s: a true law is off by less than a thousandth of the noise
KEPT = 8  # states that the filter corrects
LAG, DISC, DISC_HARMONIC, DISC_PHASE, SENSOR_GAIN, SENSOR_OFFSET = range(6)


@dataclass(frozen=True, eq=False)
class Filter:
    """Gain (8, m), inverse root of the covariance of the errors (m, m), and which positions are seen (m,)."""

    gain: Array
    whiten: Array
    seen: Array


@compiled
def sees(y: Array, channel: int, sensor: Array) -> float:
    """What an encoder reports of a state, its lag to first order."""
    x = y[channel] - sensor[LAG] * y[4 + channel]
    x += sensor[DISC] * np.sin(sensor[DISC_HARMONIC] * x + sensor[DISC_PHASE])
    error: float = x * (1.0 + sensor[SENSOR_GAIN]) + sensor[SENSOR_OFFSET]
    return error


@compiled
def innovations(
    start: Array, z: Array, tau: Array, P: Array, links: Array, gain: Array, seen: Array, sensors: Array, step: float
) -> Array:
    """Prediction errors at every sample (samples, m) [rad]; z: what was measured (samples, m)."""
    y, memory, errors = start.copy(), np.zeros((3, 2)), np.zeros_like(z)
    for k in range(len(z)):
        for i in range(len(seen)):
            errors[k, i] = z[k, i] - sees(y, seen[i], sensors[seen[i]])
        for state in range(KEPT):
            for i in range(len(seen)):
                y[state] += gain[state, i] * errors[k, i]
        one_period(k, PERIOD, step, y, memory, tau, P, links)
    return errors


def design(plant: Plant, middle: Array, steps: Array, peak: Array, noise: float, seen: Array) -> Filter:
    """The filter of an arm in the middle of its motion; steps: of the encoders that are seen (m,) [rad]."""
    P = plant.P.copy()
    P[:, at.LINK : at.LINK + 16] = P[:, at.MOTOR : at.MOTOR + 16] = at.neutral()[:, at.LINK : at.LINK + 16]
    P[:, at.LINK + at.VISCOUS] = 0.02 * P[:, at.ROTOR]
    for column in (at.HALF_GAP, at.HYSTERESIS, at.ERROR, at.STOP, at.RIPPLE, at.DELAY):
        P[:, column] = 0.0
    P[:, at.STALL] = np.inf
    still = np.zeros(at.STATES)
    still[:4] = np.tile(middle, 2)

    def after(y: Array, tau: Array) -> Array:
        moved = y.copy()
        one_period(0, PERIOD, STEP, moved, np.zeros((3, 2)), tau[None], P, plant.links)
        return moved[:KEPT]

    small, rest = 1e-6, after(still, np.zeros(2))
    A = np.array([(after(still + small * e, np.zeros(2)) - rest) / small for e in np.eye(at.STATES)[:KEPT]]).T
    B = np.array([(after(still, e) - rest) for e in np.eye(2)]).T
    H = np.eye(KEPT)[seen]
    Q = B @ np.diag((TORQUE_NOISE * noise * peak) ** 2) @ B.T + 1e-18 * np.eye(KEPT)
    R = np.diag(steps**2 / 12.0)
    own = np.ix_(*[[i for i in range(KEPT) if P[i % 2, at.RIGID] == 0.0 or i % 4 < 2]] * 2)  # rigid: rotors are links
    A, Q, H = A[own], Q[own], H[:, own[1][0]]
    covariance = solve_discrete_are(A.T, H.T, Q, R)
    S = H @ covariance @ H.T + R
    gain = np.zeros((KEPT, len(seen)))
    gain[own[1][0]] = covariance @ H.T @ np.linalg.inv(S)
    return Filter(gain, np.linalg.inv(np.linalg.cholesky(S)), seen)
