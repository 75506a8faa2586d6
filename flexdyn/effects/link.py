"""Effects on the links themselves."""

from __future__ import annotations

from flexdyn.effects.base import Effect, parameter


class Payload(Effect):
    """A point mass that the arm carries.

    It enters M(q) and h(q, v) like any mass: ``M += mass J^T J``, J the frame's translational Jacobian, and its weight
    loads the joints. Paper: m_e, the mass of the end effector, and m_L in eq. 16-19.

    Args:
        mass: [kg].
        frame: at whose origin it sits; left out: the last frame of the chain.
    """

    stage = "inertia"
    law = "a point mass at the origin of frame"
    neutral = {"mass": 0.0}

    mass: float = parameter("kg", lower=0.0)
    frame: str | None = None
