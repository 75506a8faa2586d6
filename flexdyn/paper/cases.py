"""The arms and torque curves of the study; every arm is a variation of the shipped model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.control.samples import Samples
from flexdyn.effects import CoulombFriction, StribeckFriction, TorqueSpeedLimit, ViscousFriction
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.paper.equations import Arm, friction
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solvers import DormandPrince

CASES_RATE = 250.0  # Hz, of the saved runs: 60 samples and more in the shortest period
AMPLITUDE = 0.6  # N m: 95 % of the stall torque of Table I
PULSE = 0.6  # s, of acceleration, and as long of braking
TORQUE_END = 2 * PULSE
CASES_OBSERVED = 10.0  # s, over which the residual vibration is observed
CASES_DURATION = TORQUE_END + CASES_OBSERVED + 1.0  # s
PAPER_V = 0.01  # N m s/rad: v_1 = v_2 of Fig. 5
DAMPINGS = (0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)  # N m s/rad
SMOOTH_AMPLITUDE = 0.3  # N m
SMOOTH_END = 2.0  # s


@dataclass(frozen=True)
class FrictionNumbers:
    """Eq. 1 in the shipped model, the same at both joints.

    Attributes:
        viscous: b^v [N m s/rad].
        dynamic: b^d [N m].
        static: b^s [N m].
        epsilon: [rad/s].
    """

    viscous: float
    dynamic: float
    static: float
    epsilon: float

    def law(self, u: ArrayLike) -> Array:
        """Eq. 1 with these numbers, at joint velocities [rad/s] -> [N m]."""
        return friction(u, **vars(self))


@dataclass(frozen=True)
class PaperCases:
    """The shipped model, models derived from it, and the runs that several chapters use.

    Attributes:
        model: ``scara_two_link`` as shipped: elastic, torque-speed limit, friction of eq. 1.
    """

    model: FlexibleJointModel = field(default_factory=lambda: load_model("scara_two_link"))

    @cached_property
    def limit(self) -> TorqueSpeedLimit:
        """The actuator line of Table I."""
        return next(effect for effect in self.model.effects if isinstance(effect, TorqueSpeedLimit))

    @cached_property
    def friction(self) -> FrictionNumbers:
        """The numbers of eq. 1."""
        joint = self.model.joint_names[0]
        laws = {type(effect): effect for effect in self.model.effects if getattr(effect, "joint", None) == joint}
        viscous, dry, stribeck = (laws[kind] for kind in (ViscousFriction, CoulombFriction, StribeckFriction))
        (b_v,), (b_d,), (excess, epsilon, _) = viscous.values, dry.values, stribeck.values
        return FrictionNumbers(b_v, b_d, b_d + excess, epsilon)

    def arm(self, *, v: float = 0.0, J: float | None = None) -> Arm:
        """The closed-form arm of Table I, with the model's rotor inertia or another one."""
        return Arm(J=float(self.model.rotor_inertia[0]) if J is None else J, v=v)

    def smooth_model(self, v: float = 0.0) -> FlexibleJointModel:
        """The model of eq. 12-15 with b = v q': it has neither dry friction nor a torque limit."""
        return self.model.replace(effects=self._viscous(v))

    def viscous_model(self, v: float, J: float | None = None) -> FlexibleJointModel:
        """The model with torque-speed limit and viscous friction alone; J [kg m^2] is reflected."""
        limits = [effect for effect in self.model.effects if isinstance(effect, TorqueSpeedLimit)]
        model = self.model.replace(effects=[*limits, *self._viscous(v)])
        if J is None:
            return model
        joints = {name: {"rotor_inertia": J / joint.gear_ratio**2} for name, joint in model.joints.items()}
        return model.replace(joints=joints)

    @cached_property
    def driven(self) -> Mapping[str, Run]:
        """The four runs of Fig. 5 under the torque of Fig. 4: flexible and rigid, without and with friction."""
        free = self.viscous_model(0.0)
        return {
            "flexible": bang_bang(free),
            "rigid": bang_bang(free.rigid()),
            "flexible_friction": bang_bang(self.model),
            "rigid_friction": bang_bang(self.model.rigid()),
        }

    def _viscous(self, v: float) -> list[ViscousFriction]:
        return [ViscousFriction(joint, side="link", coefficient=v) for joint in self.model.joint_names]


def reference() -> DormandPrince:
    """The solver of the saved runs."""
    return DormandPrince(rtol=1e-9, atol=1e-11)


def bang_bang(model: FlexibleJointModel) -> Run:
    """The model under the torque of Fig. 4, until the residual vibration has been observed."""
    return simulate(model, torque_of_fig4(CASES_DURATION), CASES_DURATION, reference(), rate=CASES_RATE)


def torque_of_fig4(duration: float) -> Samples:
    """The torque of Fig. 4 for a time [s]: accelerate, brake, then zero; the same at both joints."""
    signs = np.array([1.0, -1.0, 0.0, 0.0])
    return Samples([0.0, PULSE, TORQUE_END, duration], np.outer(AMPLITUDE * signs, [1.0, 1.0]))


def smooth_torque(t: ArrayLike) -> Array:
    """A torque that starts and ends with three zero derivatives, the same at both joints (..., 2) [N m].

    ``(4 s (1 - s))^4 (1 - 2 s)``, s = t/2 s, scaled to a peak of 0.3 N m. It accelerates and brakes the arm and does
    not excite a stiff spring.
    """
    s = np.clip(np.asarray(t, dtype=float) / SMOOTH_END, 0.0, 1.0)
    peak = (8 / 9) ** 4 / 3  # of the polynomial, at s = 1/3
    pulse = (4 * s * (1 - s)) ** 4 * (1 - 2 * s) * (SMOOTH_AMPLITUDE / peak)
    return np.stack([pulse, pulse], -1)


def smooth_samples() -> Samples:
    """That torque as a command: a spline through 1,001 of its values."""
    t = np.linspace(0.0, SMOOTH_END, 1001)
    return Samples(t, smooth_torque(t), "cubic")
