"""An arm at rest: the net torques on links and rotors, loaded springs, the motor torques that hold a pose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexdyn.analysis.roots import roots
from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.plant import build_plant, coupled_inertia

TORQUE_ROUNDING = 1e-13
"""A torque below this share of the largest torque on the arm counts as zero [1]."""


class Statics:
    """One model at rest, without dry friction, which has no unique torque at rest.

    At rest every net torque depends only on its own joint's rotor position and motor torque: the link side of joint j
    on q and theta_j, its rotor side on q_j, theta_j and tau_j. Therefore all joints are solved at once. Full rotor
    coupling changes only `inertia` and no torque; `reduced_plant` is without it.

    Args:
        model: the arm; internal states of its effects are 0.
        t: time since the start of the run [s], for effects that depend on it.
    """

    def __init__(self, model: FlexibleJointModel, t: float = 0.0) -> None:
        self.model, self.t = model, t
        self.plant = build_plant(model)
        self.reduced_plant = self.plant
        if self.plant.coupled:
            self.reduced_plant = build_plant(model.replace(rotor_coupling="reduced"))
        self.links = LinkSide(model)
        self.elastic = model.elastic
        self._stiffness = np.where(self.elastic, model.stiffness, 1.0)

    def state(self, q: Array, theta: Array) -> Array:
        """X = [q, theta, 0, 0, 0] (nx,)."""
        x = np.zeros(self.plant.state_size)
        x[: self.model.n] = q
        x[self.model.n : self.model.n + int(self.elastic.sum())] = theta[self.elastic]
        return x

    def inertia(self, q: Array) -> Array:
        """H(q) (n + e, n + e) [kg m^2 or kg] of [v, omega]: M(q), with J of rigid joints, and J of rotors.

        Full rotor coupling adds S(q) between links and rotors, and within the links for rotors of rigid joints.

        Raises:
            InputError: the links have less inertia than the rotors that they carry, so that H(q) is not positive
                definite.
        """
        size = self.model.n + int(self.elastic.sum())
        return coupled_inertia(self.plant, self.state(q, q), size, ", at this pose")

    def net(self, q: Array, theta: Array, tau: Array) -> tuple[Array, Array]:
        """Net torques [N m or N] on links (n,) and rotors (n,): 0 where the arm can rest without friction.

        A rigid joint's rotor is part of its link: its entry is that of the link.

        Args:
            q: positions of the links (n,) [rad or m].
            theta: of the rotors (n,).
            tau: commanded torques (n,).
        """
        n, e = self.model.n, int(self.elastic.sum())
        rate = np.empty(self.plant.state_size)
        self.reduced_plant.derivative(self.t, self.state(q, theta), tau, np.inf, rate)
        link = self.links.mass_matrix(q) @ rate[n + e : 2 * n + e]
        rotor = link.copy()
        rotor[self.elastic] = self.model.rotor_inertia[self.elastic] * rate[2 * n + e : 2 * n + 2 * e]
        return link, rotor

    def tolerance(self, q: Array, *torques: Array) -> float:
        """The rounding error of a net torque at this pose [N m or N]."""
        weight = self.links.bias(q, np.zeros(self.model.n))
        least = 1e-2 * self.links.mass_matrix(q)  # if nothing loads the arm: torques for 1e-15 m/s^2
        return TORQUE_ROUNDING * max(float(np.abs(each).max()) for each in (least, weight, *torques))

    def loaded_springs(self, q: Array, net: Array | float = 0.0) -> Array:
        """Rotor positions (n,) at which the springs balance the links at rest, up to a given net torque on each.

        If a transmission with backlash carries no torque, its rotor is in the middle of the gap, theta = q.

        Raises:
            InputError: no deflection of a spring balances its link.
        """
        still = np.zeros(self.model.n)

        def lacking(theta: Array) -> Array:
            """How far the net torques on the links (n,) are above the given ones; 0 on rigid joints."""
            return np.where(self.elastic, self.net(q, theta, still)[0] - net, 0.0)

        return self._rotors(lacking, q, self.tolerance(q, lacking(q)))

    def driven_springs(self, q: Array, tau: Array) -> Array:
        """Rotor positions (n,) at which the springs balance the motors' torques tau at rest.

        Raises:
            InputError: no deflection of a spring balances its motor.
        """

        def excess(theta: Array) -> Array:
            """What the springs hold beyond the motors' torques (n,); 0 on rigid joints."""
            return np.where(self.elastic, -self.net(q, theta, tau)[1], 0.0)

        return self._rotors(excess, q, self.tolerance(q, excess(q), tau))

    def motor_torques(self, q: Array, theta: Array, net: Array | float = 0.0) -> Array:
        """Commanded torques (n,) that give the net torques `net` on the rotors; for rigid joints on the links.

        They are +inf or -inf where the motor saturates before it reaches the net torque.
        """

        def lacking(tau: Array) -> Array:
            """How far the net torques on the rotors (n,) are above the given ones."""
            return self.net(q, theta, tau)[1] - net

        nothing = np.zeros(self.model.n)
        first = lacking(nothing)
        step = np.maximum(np.abs(first), 1e-6)
        tau, found = roots(lacking, nothing, step, self.tolerance(q, first))
        return np.where(found, tau, np.copysign(np.inf, -first))

    def holding(self, q: Array, theta: Array) -> Array:
        """Commanded torques of the motors (n,) that keep the rotors at theta at rest.

        Raises:
            InputError: a motor too weak for it.
        """
        tau = self.motor_torques(q, theta)
        if not np.isfinite(tau).all():
            joint = self.model.joint_names[int(np.argmin(np.isfinite(tau)))]
            problem, remedy = f"the motor of {joint} is too weak to hold the pose", "give tau, or another pose"
            raise InputError(problem, key="q", value=q, remedy=remedy)
        return tau

    def _rotors(self, f: Callable[[Array], Array], q: Array, tolerance: float) -> Array:
        first = np.maximum(np.abs(f(q)) / self._stiffness, 1e-9)
        finest = 4.0 * np.spacing(np.abs(q) + first) * self._stiffness  # the torque of one bit of theta
        theta, found = roots(f, q, first, np.maximum(tolerance, finest))
        if not found.all():
            joint = self.model.joint_names[int(np.argmin(found))]
            problem = f"no equilibrium: no deflection of the spring balances the torque on {joint}"
            raise InputError(problem, remedy="check its transmission")
        return theta
