"""Effects between rotor and link: they act on the deflection delta = theta - q and its rate."""

from __future__ import annotations

from flexdyn.effects.base import JointEffect, parameter


class TransmissionDamping(JointEffect):
    """Damping across the spring of an elastic joint.

    ``tau_s += coefficient (omega - v)``, of the true velocities. It adds to the joint's `damping`.

    Args:
        joint: its name; it must be elastic.
        coefficient: [N m s/rad].
    """

    sides = ("transmission",)
    stage = "spring"
    law = "coefficient*(omega - v)"
    neutral = {"coefficient": 0.0}

    coefficient: float = parameter("N m s/rad", lower=0.0)
