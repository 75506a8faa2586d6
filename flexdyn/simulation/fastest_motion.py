"""The fastest rate of the motion at a state, and the spring, damper or effect that causes it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.effects import Effect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.laws import acting_effects, core_law
from flexdyn.simulation.link_side import build_links
from flexdyn.simulation.plant import rotor_spin, state_matrix

WIDE = math.inf  # rad/s: smoothed over this width, dry friction has practically no slope


@dataclass(frozen=True)
class Fastest:
    """The fastest motion at a state.

    Attributes:
        rate: largest absolute eigenvalue of the linearised motion [1/s].
        joint: joint with the largest share in it.
        cause: the number or effect of that joint that causes it, in words.
    """

    rate: float
    joint: str
    cause: str

    def __str__(self) -> str:
        """One clause."""
        return f"the fastest rate there is {self.rate:.3g} 1/s, from {self.cause} of {self.joint}"


def fastest_motion(model: FlexibleJointModel, x: Array, tau: Array, t: float = 0.0) -> Fastest | None:
    """Find the fastest motion at a state and its cause; None where slopes are not finite.

    An eigenvalue is a sum over all springs, dampers and effects. One with the Jacobian J_k contributes ``w' J_k v /
    w' v``, where v and w are the right and left eigenvectors. The largest contribution is named.

    Args:
        model: that moves.
        x: state.
        tau: commanded torques (n,) [N m or N].
        t: time [s].
    """
    true = model.resolved()
    parts = _Parts(true, tuple(acting_effects(true)))
    J = parts.slopes(x, tau, t)
    if not np.isfinite(J).all():
        return None
    values, right = np.linalg.eig(J)
    which = int(np.abs(values).argmax())
    rate = float(np.abs(values[which]))
    v = right[:, which]
    others, left = np.linalg.eig(J.T)
    w = left[:, int(np.abs(others - values[which]).argmin())]
    joint, cause, largest = "the arm", "the motion of the links", 0.0
    for name, what, rest in parts.without(x, tau, t):
        share = float(abs(w @ (J - rest) @ v))
        if np.isfinite(share) and share > largest:
            joint, cause, largest = name, what, share
    return Fastest(rate, joint, cause)


class _Parts:
    """A plant in which one part after the other is left out."""

    def __init__(self, true: FlexibleJointModel, effects: tuple[Effect, ...]) -> None:
        self.true, self.effects, self.links = true, effects, build_links(true)
        self.laws = [core_law(true, effect) for effect in effects]

    def slopes(self, x: Array, tau: Array, t: float, laws: list[_core.Law] | None = None, **numbers: Array) -> Array:
        """Jacobian of the motion at the state (nx, nx)."""
        true = self.true
        K, D = numbers.get("K", true.stiffness), numbers.get("D", true.damping)
        kept = self.laws if laws is None else laws
        plant = _core.plant(self.links, K, D, true.rotor_inertia, rotor_spin(true), kept)
        return state_matrix(plant, t, x, tau, WIDE)

    def without(self, x: Array, tau: Array, t: float) -> Iterator[tuple[str, str, Array]]:
        """Joint, part in words, and the Jacobian without that part, in the shape of the full one."""
        true = self.true
        for j in np.flatnonzero(true.elastic):
            name = true.joint_names[j]
            softer, undamped = true.stiffness.copy(), true.damping.copy()
            softer[j] *= 1e-9
            undamped[j] = 0.0
            rotor = f"on its rotor of {true.rotor_inertia[j]:.3g} kg m^2, reflected"
            yield name, f"the stiffness {true.stiffness[j]:.3g} {rotor},", self.slopes(x, tau, t, K=softer)
            yield name, f"the damping {true.damping[j]:.3g} {rotor},", self.slopes(x, tau, t, D=undamped)
        first = len(x) - sum(effect.has_state for effect in self.effects)
        for k, effect in enumerate(self.effects):
            name = str(getattr(effect, "joint", true.name))
            others = [law for i, law in enumerate(self.laws) if i != k]
            gone = [first + sum(each.has_state for each in self.effects[:k])] if effect.has_state else []
            kept = np.delete(np.arange(len(x)), gone)
            rest = np.zeros((len(x), len(x)))
            rest[np.ix_(kept, kept)] = self.slopes(x[kept], tau, t, laws=others)
            yield name, effect.name, rest
