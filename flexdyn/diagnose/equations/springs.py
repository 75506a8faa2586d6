"""The torques of a joint's springs along a measured motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.users_laws import torque_of
from flexdyn.effects import DeflectionEffect, JointEffect, MemoryEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel

SLOPE_STEP = 1e-6
"""Step of the differences of a torque, as a share of its largest value [1]."""


@dataclass(frozen=True, eq=False)
class _Signals:
    """What the laws of a transmission depend on beside its deflection.

    Attributes:
        t: times since the start of the run (samples,) [s].
        theta: position of the rotor (samples,).
        rate: of the deflection (samples,).
        tau: commanded torque (samples,).
        by_rotor: what a law of the rotor's position adds to the deflection, and its slope (samples,) each.
    """

    t: Array
    theta: Array
    rate: Array
    tau: Array
    by_rotor: Callable[[DeflectionEffect], tuple[Array, Array]]

    @classmethod
    def smoothed(cls, model: FlexibleJointModel, motion: SmoothedMotion, j: int) -> Self:
        """After the filters; waves over the rotor's position are taken before them, see `Smoothed.recorded`."""
        theta, x = motion.theta[:, j], motion.recorded(j, "motor", bool(model.elastic[j]))

        def by_rotor(bend: DeflectionEffect) -> tuple[Array, Array]:
            """As the filters weaken it, where the position was recorded."""
            if x is None:
                return _by_rotor(bend, theta)
            wound, slope = _by_rotor(bend, x)
            return motion.filtered(wound), motion.filtered(slope)

        return cls(motion.t, theta, motion.ddelta[:, j], motion.tau[:, j], by_rotor)

    @classmethod
    def recorded(cls, motion: SmoothedMotion, j: int) -> Self:
        """Before the filters, but for rate and torque, which are smoothed."""
        rate, tau = (np.pad(x[:, j], motion.lost, mode="edge") for x in (motion.ddelta, motion.tau))
        theta = motion.data.theta[:, j]
        return cls(motion.data.t, theta, rate, tau, lambda bend: _by_rotor(bend, theta))


def spring_torque(model: FlexibleJointModel, effects: Sequence[JointEffect], motion: SmoothedMotion, j: int) -> Array:
    """tau_s (samples, 2) on the link, and on the rotor.

    Kinematic error first, then dead zones, then every spring law; hysteresis takes the result. The torque on the rotor
    is the springs' torque times the slope of the kinematic error.
    """
    on_link, on_rotor = _springs_of(model, effects, motion, j)
    dampers = model.damping[j] * motion.ddelta[:, j]
    for effect in effects:
        if effect.stage == "spring" and effect.of_velocity:
            dampers = dampers + effect.torque(motion.delta[:, j], motion.ddelta[:, j], t=motion.t)
    return np.stack([on_link + dampers, on_rotor + dampers], axis=1)


def spring_slope(
    model: FlexibleJointModel, effects: Sequence[JointEffect], motion: SmoothedMotion, j: int
) -> Array | None:
    """Slope of the springs' torque over the deflection (samples,) [N m/rad or N/m]; None: the spring is linear.

    By differences; zero in a gap. What remembers the way of the deflection follows its noise in part; here it does not.
    """
    bent = [e for e in effects if isinstance(e, DeflectionEffect) or (e.bends_spring and e.stage == "spring")]
    bent = [e for e in bent if not isinstance(e, MemoryEffect)]
    if not bent:
        return None
    signals = _Signals.smoothed(model, motion, j)
    return slope_of(lambda delta: _springs_at(model, bent, signals, j, delta)[0], motion.delta[:, j])


def slope_of(law: Callable[[Array], Array], at: Array) -> Array:
    """Slope of a law (samples,) at the arguments (samples,), by central differences."""
    step = SLOPE_STEP * max(float(np.abs(at).max()), 1e-300)
    return np.asarray((law(at + step) - law(at - step)) / (2.0 * step))


def _springs_of(
    model: FlexibleJointModel, effects: Sequence[JointEffect], motion: SmoothedMotion, j: int
) -> tuple[Array, Array]:
    """Torque of the springs on the link, and on the rotor (samples,) each.

    Of a link that is simulated the deflection is known before the filters. So are then the torques of a bent spring.
    """
    if motion.wound is None or np.isnan(motion.wound[0, j]):
        signals = _Signals.smoothed(model, motion, j)
        springs, slope = _springs_at(model, effects, signals, j, motion.delta[:, j])
        return springs, slope * springs
    springs, slope = _springs_at(model, effects, _Signals.recorded(motion, j), j, motion.wound[:, j])
    return motion.filtered(springs), motion.filtered(slope * springs)


def _springs_at(
    model: FlexibleJointModel, effects: Sequence[JointEffect], signals: _Signals, j: int, true: Array
) -> tuple[Array, Array]:
    """Torque of the springs at deflections, and its share that reaches the rotor (samples,) each."""
    seen, slope = true, np.ones(len(true))
    bent = [e for e in effects if isinstance(e, DeflectionEffect)]
    for bend in sorted(bent, key=lambda e: e.order):
        if bend.of_rotor:
            wound, steeper = signals.by_rotor(bend)
            seen, slope = seen + wound, slope + steeper
        else:
            seen = bend.deflection(seen, signals.theta)
    springs = model.stiffness[j] * seen
    for effect in effects:
        if effect.side == "transmission" and isinstance(effect, MemoryEffect):
            springs = springs + effect.along(seen)
        elif effect.stage == "spring" and not effect.of_velocity:
            springs = springs + torque_of(effect, seen, signals.rate, t=signals.t, tau=signals.tau)
    return springs, slope


def _by_rotor(bend: DeflectionEffect, theta: Array) -> tuple[Array, Array]:
    """What the rotor's position adds to the deflection of the spring, and its slope (samples,) each."""
    return bend.deflection(np.zeros_like(theta), theta), bend.slope(theta)
