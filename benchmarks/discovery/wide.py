"""Wider ranges for all that a case is made of: families whose name ends in _wide (`make.py --wide`).

harmonics       1 to 200 cycles per turn, log-uniform, seven in ten whole numbers
springs         6 to 60 Hz between link and rotor, so two decades of stiffness; damping 0.3 to 6 % of critical
tolerance       1 to 10 % of the numbers of the model file, log-uniform, errors to match
recordings      every, every second or every fourth of the controller's 1 kHz
motions         those of `excitation`, 0.6 to 3 rad/s, 3 to 20 rad/s^2
control         1.5 to 5 Hz, at most a quarter of the spring's frequency; 60 to 100 % of the torque fed forward
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from arm_draw import TwoLinkArm, inertia_at, pair
from excitation import KINDS
from layout import Array
from motions import Style
from sizes import Parameters, Scale, log_uniform

SUFFIX = "_wide"
HARMONICS, WHOLE = (1.0, 200.0), 0.7
FREQUENCY = (6.0, 60.0)  # Hz
SEEN_BY_ONE = 25.0  # Hz: an unknown spring that one encoder must show is no harder than this
TOLERANCE = (0.01, 0.1)
EVERY = (1, 2, 4)
STRAYED = 0.5  # rad from the reference: no controller that anyone would use


@dataclass(frozen=True)
class Setup:
    """What a case is made of beside its arm.

    Attributes:
        tolerance: of the numbers of the model file.
        motion: a kind of `excitation`.
        every: periods of the controller from one recorded sample to the next.
        feedforward: share of the model's torque that is fed forward.
        wide: drawn from the wider ranges.
    """

    tolerance: float
    motion: str
    every: int
    feedforward: float
    wide: bool = True


def split(family: str) -> tuple[str, bool]:
    """The family without its ending, and whether it is a wide one."""
    return family.removesuffix(SUFFIX), family.endswith(SUFFIX)


def draw_setup(rng: np.random.Generator) -> Setup:
    """Anything within the ranges."""
    return Setup(
        tolerance=float(f"{log_uniform(rng, TOLERANCE, 1)[0]:.3g}"),
        motion=str(rng.choice(KINDS)),
        every=int(rng.choice(EVERY)),
        feedforward=float(rng.uniform(0.6, 1.0)),
    )


def draw_style(rng: np.random.Generator, reach: tuple[float, float] = (0.5, 1.3)) -> Style:
    """From slow to quick."""
    speed, acceleration = log_uniform(rng, (0.6, 3.0), 1)[0], log_uniform(rng, (3.0, 20.0), 1)[0]
    slow = log_uniform(rng, (0.02, 0.2), 1)[0]
    return Style(float(rng.uniform(*reach)), float(speed), float(acceleration), float(slow))


def springs(rng: np.random.Generator, arm: TwoLinkArm) -> TwoLinkArm:
    """The arm with other springs."""
    both = _both(arm)
    K = both * (2.0 * np.pi * log_uniform(rng, FREQUENCY, 2)) ** 2
    return arm.replace(stiffness=pair(K), damping=pair(2.0 * log_uniform(rng, (0.003, 0.06), 2) * np.sqrt(K * both)))


def softened(arm: TwoLinkArm, j: int) -> TwoLinkArm:
    """The arm with a spring at this joint that one encoder shows."""
    K = np.array(arm.stiffness)
    K[j] = min(K[j], float(_both(arm)[j]) * (2.0 * np.pi * SEEN_BY_ONE) ** 2)
    return arm.replace(stiffness=pair(K))


def bandwidth(rng: np.random.Generator, arm: TwoLinkArm) -> Array:
    """Of the position loops (2,) [rad/s]."""
    most = 0.25 * np.sqrt(np.array(arm.stiffness) / _both(arm))
    return np.asarray(np.minimum(2.0 * np.pi * rng.uniform(1.5, 5.0, 2), most))


def _both(arm: TwoLinkArm) -> Array:
    """Inertia of link and rotor swinging against one another (2,) [kg m^2]."""
    return np.asarray(1.0 / (1.0 / inertia_at(arm) + 1.0 / arm.rotor()))


def harmonic(s: Scale) -> float:
    """Cycles per turn of the joint."""
    value = float(log_uniform(s.rng, HARMONICS, 1)[0])
    return float(round(value)) if s.rng.random() < WHOLE else value


def _swing(s: Scale) -> Parameters:
    return {"amplitude": s.torque(0.03, 0.06), "harmonic": harmonic(s), "phase": s.phase()}


def _ripple(s: Scale) -> Parameters:
    return {"amplitude": s.torque(0.02, 0.06), "harmonic": harmonic(s), "phase": s.phase()}


def _kinematic(s: Scale) -> Parameters:
    return _wavy(s, 2e-4, 8e-4)


def _link_disc(s: Scale) -> Parameters:
    return _wavy(s, 3e-4, 1e-3)


def _wavy(s: Scale, low: float, high: float) -> Parameters:
    """An error of position that is the smaller the more waves it has: a quarter at a hundred of them [rad]."""
    waves = harmonic(s)
    return {"amplitude": s.draw(low, high) / waves**0.3, "harmonic": waves, "phase": s.phase()}


def _payload(s: Scale) -> Parameters:
    more = max(1.0, s.tolerance / 0.03)  # what the tolerance of the masses could make up for grows with it
    return {"mass": s.draw(0.1, 0.25) * more * (s.arm.mass[s.joint] + s.arm.tool)}


LAWS: dict[str, Callable[[Scale], Parameters]] = {
    "position_dependent_friction": _swing,
    "torque_ripple": _ripple,
    "kinematic_error": _kinematic,
    "encoder_eccentricity": _link_disc,
    "payload": _payload,
}
"""In place of those in `sizes`."""


def wrong_factor(s: Scale) -> float:
    """Beyond three times the tolerance, and never less than what an ordinary recording shows."""
    low, high = (max(5.5 * s.tolerance, 0.12), max(12.0 * s.tolerance, 0.36))
    if s.factor < 1.0:
        low, high = max(4.3 * s.tolerance, 0.1), max(7.4 * s.tolerance, 0.2)
    return float(np.exp(s.rng.choice([-1.0, 1.0]) * s.rng.uniform(low, high)))
