"""Effects that no entry of the catalogue describes, nor any pair of entries imitates."""

from __future__ import annotations

from collections.abc import Callable

import layout as at
import numpy as np
from hidden import Hidden
from layout import Array
from sizes import Parameters, Scale


def _mode(s: Scale, low: float, high: float, share: tuple[float, float]) -> Parameters:
    inertia = s.rng.uniform(*share) * float(s.inertia[s.joint])
    stiffness = inertia * (2.0 * np.pi * s.rng.uniform(low, high)) ** 2
    return {"inertia": inertia, "stiffness": stiffness, "damping": 0.04 * np.sqrt(stiffness * inertia)}


OUTSIDE: dict[str, tuple[dict[str, int], Callable[[Scale], Parameters]]] = {
    # Drag with the cube of the speed: the catalogue has the square at most.
    "cubic_drag": ({"c": at.CUBIC_DRAG}, lambda s: {"c": s.at_speed(0.25, 0.5) / float(s.speed[s.joint]) ** 2}),
    # Viscous friction that depends on the position: a bearing tight over part of the turn.
    "patchy_drag": (
        {"c": at.PATCHY, "harmonic": at.PATCHY_HARMONIC},
        lambda s: {"c": s.at_speed(0.1, 0.25), "harmonic": float(s.rng.integers(4, 9))},
    ),
    # A stiffness that swings in time.
    "breathing_stiffness": (
        {"share": at.BREATHING, "rate": at.BREATHING_RATE},
        lambda s: {"share": s.draw(0.2, 0.4), "rate": s.rng.uniform(0.3, 3.0)},
    ),
    # A torque constant that sags with speed, as with field weakening.
    "torque_sag": ({"per_speed": at.SAG}, lambda s: {"per_speed": s.draw(0.25, 0.5) / float(s.speed[s.joint])}),
    # An offset that grows with time.
    "drifting_torque": ({"per_second": at.DRIFT}, lambda s: {"per_second": s.signed(0.05, 0.12) * _peak(s) / 40.0}),
    # A torque at a frequency of its own, in time: a fan.
    "fan": (
        {"torque": at.FAN, "rate": at.FAN_RATE},
        lambda s: {"torque": s.torque(0.04, 0.08), "rate": s.rng.uniform(3, 9)},
    ),
    # Dry friction that grows with time: a bearing that seizes.
    "growing_friction": ({"per_second": at.WEAR}, lambda s: {"per_second": s.torque(0.08, 0.15) / 40.0}),
    # A cable from link to link, its torque c sin(q) q_other.
    "cross_cable": ({"c": at.CABLE}, lambda s: {"c": s.signed(0.1, 0.2) * _peak(s)}),
    # Damping across the transmission with the root of the rate.
    "root_damping": ({"c": at.ROOT_DAMPING}, lambda s: {"c": s.draw(0.1, 0.2) * s.K * s.wound}),
    # A link that bends: one more mode behind the joint.
    "bending_link": (
        {"inertia": at.MODE_INERTIA, "stiffness": at.MODE_STIFFNESS, "damping": at.MODE_DAMPING},
        lambda s: _mode(s, 6.0, 12.0, (0.05, 0.12)),
    ),
    # A load that swings on the arm: a sling, a liquid.
    "swinging_load": (
        {"inertia": at.MODE_INERTIA, "stiffness": at.MODE_STIFFNESS, "damping": at.MODE_DAMPING},
        lambda s: _mode(s, 1.2, 3.0, (0.04, 0.1)),
    ),
}


def draw_outside(name: str, scale: Scale) -> Hidden:
    """One of them at design size."""
    parameters = {key: float(value) for key, value in OUTSIDE[name][1](scale).items()}
    return Hidden(name, scale.joint, None, parameters, catalogued=False)


def enter_outside(P: Array, hidden: Hidden) -> None:
    """Write it into the plant's table, in place."""
    for key, column in OUTSIDE[hidden.effect][0].items():
        P[hidden.joint, column] = hidden.parameters[key]


def _peak(s: Scale) -> float:
    return float(s.peak[s.joint])
