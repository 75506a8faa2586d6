"""How much of each channel's noise the residuals contain: coefficients by channel, order of derivative and equation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.equations.computed_positions import LEAST_TRANSMITTED, acting_on, lost_share
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, MOTOR, SENSOR, TOTAL, TRANSMISSION
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.springs import spring_slope
from flexdyn.diagnose.equations.terms import torque_slope

Coefficient = float | Array
"""One number, or one for each time (times,)."""
Terms = dict[int, Coefficient]
"""Of every equation."""
Channel = tuple[str, int]


def coefficients(equations: Equations, along: SmoothedMotion) -> dict[Channel, dict[int, Terms]]:
    """C by channel, order of derivative and equation, in units of its rows; those that are zero are left out."""
    M = along.inertias(equations.filters).transpose(1, 2, 0).copy()
    shares = [1.0 + _lost(equations, along, i) for i in range(equations.true.n)]
    found: dict[Channel, dict[int, Terms]] = {}
    # Positions that are computed from a limited torque are right to first order only: they err by as much as its noise.
    exact = not equations.computed.any()
    given = [passed_torque(equations, along, i) if exact else gain for i, gain in enumerate(equations.gains)]
    for row, (j, kind) in enumerate(equations.kinds):
        own = _own_coefficients(equations, along, j, kind, shares[j])
        unit = {LINK: equations.softness[j], MOTOR: equations.gains[j], TOTAL: equations.gains[j]}.get(kind, 1.0)
        links = _links(equations, along, M, j, kind, shares) if kind in (LINK, TOTAL) else ()
        for channel, order, value in (*own, *links):
            if np.any(value):
                rows = found.setdefault(channel, {}).setdefault(order, {})
                true = given[channel[1]] if channel[0] == "tau" else 1.0
                rows[row] = rows.get(row, 0.0) + true / unit * value
    return found


def passed_torque(equations: Equations, along: SmoothedMotion, j: int) -> Coefficient:
    """True noise of a motor's torque over that of the recorded one, as far as its limits pass it (times,) [1].

    Root mean square over a row's filter; without limits the motor's gain.
    """
    slope = torque_slope(acting_on(equations.true, j), along, j)
    return float(equations.gains[j]) if slope is None else _rms(equations, slope)


def _stiffness(equations: Equations, along: SmoothedMotion, j: int) -> Coefficient:
    """Torque that noise of a measured deflection makes, over that noise (times,) [N m/rad or N/m].

    Root mean square over a row's filter; that of a linear spring is its stiffness.
    """
    slope = spring_slope(equations.true, acting_on(equations.true, j), along, j)
    return float(equations.true.stiffness[j]) if slope is None else _rms(equations, slope)


def _rms(equations: Equations, slope: Array) -> Array:
    """Root mean square over a row's filter (times,) of a slope (samples,)."""
    return np.sqrt(np.maximum(equations.filters.rows(slope**2), 0.0))


def _lost(equations: Equations, along: SmoothedMotion, j: int) -> Coefficient:
    """Friction of a motor over the torque that its spring carries, of laws that take the load (times,) [1]."""
    true = equations.true
    if not true.elastic[j] or not any(each.takes_load for each in acting_on(true, j)):
        return 0.0
    share = lost_share(true, j, true.stiffness[j] * along.delta[:, j], along.theta[:, j], along.omega[:, j], along.t)
    return equations.filters.rows(np.maximum(share, LEAST_TRANSMITTED - 1.0))


def _own_coefficients(
    equations: Equations, along: SmoothedMotion, j: int, kind: str, share: Coefficient
) -> Iterator[tuple[Channel, int, Coefficient]]:
    """Coefficients of a joint's torques, transmission and rotor in one of its equations.

    Args:
        equations: that have the row.
        along: the motion.
        j: the joint.
        kind: of the row.
        share: torque that the motor must give over that which the spring carries [1].
    """
    model = equations.true
    D, elastic = model.damping[j], bool(model.elastic[j])
    K = _stiffness(equations, along, j) if elastic and kind in (MOTOR, LINK, SENSOR) else 0.0
    passed = 1.0 / share if equations.computed[j] and not along.data.has_q[j] else 1.0  # of the motor's torque
    if kind in (MOTOR, TOTAL):
        yield ("tau", j), 0, passed
        yield ("theta" if along.data.has_theta[j] else "q", j), 1, -sum(law.back_emf for law in equations.motors[j])
    if kind == SENSOR:
        yield ("tau_s", j), 0, 1.0
    bent = {
        MOTOR: (-K * share, -D * share),
        LINK: (K, D),
        TRANSMISSION: (1.0,),
        SENSOR: (-K,) if elastic else (),
    }
    for order, value in enumerate(bent.get(kind, ())):
        yield ("q", j), order, -value
        yield ("theta", j), order, value
    if kind == MOTOR:
        yield ("theta", j), 2, -model.rotor_inertia[j]


def _links(
    equations: Equations, along: SmoothedMotion, M: Array, j: int, kind: str, shares: Sequence[Coefficient]
) -> Iterator[tuple[Channel, int, Coefficient]]:
    """The links' accelerations in one equation: measured, or computed from those of the rotors.

    Args:
        equations: that have the row.
        along: the motion.
        M: mass matrices (n, n, times).
        j: the joint.
        kind: of the row.
        shares: torque that each motor must give over that which its spring carries [1].
    """
    model = equations.true
    taken = shares[j] if kind == TOTAL and not along.data.has_theta[j] else 1.0  # friction takes what the links need
    has_q, has_theta = along.data.has_q, along.data.has_theta
    K, D, J = model.stiffness, model.damping, model.rotor_inertia
    moves = ~along.resting[equations.filters.instants(len(along.t))]
    for i in range(model.n):
        if model.elastic[i] and not has_q[i]:
            yield ("theta", i), 2, -M[j, i]
            # Of a resting joint the load is known, and smoothed.
            soft = np.where(moves[:, i], M[j, i] / (K[i] * shares[i]), 0.0)
            yield ("theta", i), 4, -soft * J[i]
            yield ("tau", i), 2, soft
            yield ("theta", i), 5, soft * D[i] * J[i] / K[i]
            yield ("tau", i), 3, -soft * D[i] / K[i]
            continue
        channel = ("q" if has_q[i] else "theta", i)
        yield channel, 2, -M[j, i] * taken
        if kind == TOTAL and model.elastic[j] and not has_theta[j]:
            yield channel, 4, -M[j, i] * J[j] / K[j]
            yield channel, 5, M[j, i] * J[j] * D[j] / K[j] ** 2
    if kind == TOTAL and model.elastic[j]:
        yield ("theta" if has_theta[j] else "q", j), 2, -J[j] / (shares[j] if not has_q[j] else 1.0)
    elif kind == TOTAL and has_q[j] and has_theta[j]:  # M includes the rotor, whose acceleration follows from theta
        yield ("theta", j), 2, -J[j]
        yield ("q", j), 2, J[j]


def freest(equations: Equations, along: SmoothedMotion, j: int) -> Flags:
    """Rows in which a motor's limits pass most of the noise of its torque (times,)."""
    times = equations.filters.count(len(along.t))
    power = np.broadcast_to(np.asarray(passed_torque(equations, along, j)) ** 2, times)
    return np.asarray(power >= 0.5 * power.max())
