"""Every law of the catalogue written a second time, in plain floats, from the table in words and formulas."""

from __future__ import annotations

import math


def viscous(u: float, coefficient: float) -> float:
    """Friction proportional to speed [N m]."""
    return coefficient * u


def coulomb(u: float, level: float, eps: float) -> float:
    """Dry friction, its jump smoothed over eps [rad/s]."""
    return level * math.tanh(u / eps)


def stribeck(u: float, excess: float, velocity: float, exponent: float, eps: float) -> float:
    """Excess of static over kinetic friction that fades with speed (paper, eq. 1, third term)."""
    return excess * math.exp(-((abs(u) / velocity) ** exponent)) * math.tanh(u / eps)


def paper_friction(u: float, viscous: float, static: float, dynamic: float, epsilon: float) -> float:
    """Eq. 1 of the paper as printed, with the signum of eq. 2."""
    sign = 1.0 if u > 0 else -1.0 if u < 0 else 0.0
    return viscous * u + sign * (dynamic + (static - dynamic) * math.exp(-abs(u) / epsilon))


def torque_speed_limit(tau: float, omega: float, stall: float, no_load: float) -> float:
    """What a motor gives of the torque asked for: the line of Table I, in both directions."""
    most = stall * (1.0 - omega / no_load)
    least = -stall * (1.0 + omega / no_load)
    if tau > 0 and tau > most:
        return max(most, 0.0)
    if tau < 0 and tau < least:
        return min(least, 0.0)
    return tau
