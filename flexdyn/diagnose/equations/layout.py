"""Which equations a model has for what was measured, and their scales."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.simulated_links import hidden_links
from flexdyn.diagnose.lazy import lazy
from flexdyn.effects import JointEffect
from flexdyn.effects.motor import DCMotorLaw
from flexdyn.model.flexible_joint_model import FlexibleJointModel

MOTOR, LINK, TOTAL, TRANSMISSION, SENSOR = "motor", "link", "total", "transmission", "sensor"


@dataclass(frozen=True, eq=False)
class EquationLayout:
    """The equations of a model for measured channels.

    Rows of all recordings follow one another, time by time, and at each time stand the equations in the order of
    `kinds`: the motor's and the link's of an elastic joint with both encoders, else the joint's total; the motor's
    alone where a test rig moves the motor and the link behind it is simulated, not measured; on a rigid joint with
    both encoders also theta = q, from the start on and whatever a model makes of the joint later [rad or m].

    Attributes:
        model: that has the equations.
        data: the recordings, as measured.
        filters: that every term passes.
        stiffness: scale of the links' equations (n,) [N m/rad]; None: the model's own.
        simulated: whether unmeasured links are simulated along the motion of their motors.
    """

    model: FlexibleJointModel
    data: tuple[Measured, ...]
    filters: Filters
    stiffness: Array | None = None
    simulated: bool = False

    @lazy
    def true(self) -> FlexibleJointModel:
        """The model with parameter errors and elasticities applied."""
        return self.model.resolved()

    @lazy
    def kinds(self) -> tuple[tuple[int, str], ...]:
        """Joint and kind of every equation."""
        first = self.data[0]
        elastic = self.true.elastic if self.stiffness is None else np.isfinite(self.stiffness)
        kinds: list[tuple[int, str]] = []
        for j in range(self.true.n):
            if not first.both[j]:
                kinds.append((j, MOTOR if self.replayed[j] else TOTAL))
            else:
                kinds += [(j, MOTOR), (j, LINK)] if elastic[j] else [(j, TOTAL), (j, TRANSMISSION)]
            if first.has_tau_s[j]:
                kinds.append((j, SENSOR))
        return tuple(kinds)

    def places(self, j: int, *kinds: str) -> list[int]:
        """Equations of a joint that are of some kinds, by their places in `kinds`."""
        return [k for k, (i, kind) in enumerate(self.kinds) if i == j and kind in kinds]

    @lazy
    def sensed(self) -> bool:
        """Whether a torque was measured in any transmission."""
        return any(kind == SENSOR for _, kind in self.kinds)

    @lazy
    def computed(self) -> Flags:
        """Elastic joints with one of their two positions unmeasured, and computed from what was recorded (n,)."""
        return np.asarray(self.true.elastic & ~self.data[0].both & ~self.replayed)

    @lazy
    def replayed(self) -> Flags:
        """Joints whose motors are moved as recorded, and whose links are simulated behind them (n,)."""
        return hidden_links(self.true, self.data[0])

    @property
    def noisy(self) -> bool:
        """Whether slopes contain much noise of their rows: no filter keeps encoders from ruling links' equations."""
        return bool((self.true.elastic & ~self.replayed).any())

    @property
    def unmeasured(self) -> Flags:
        """Those whose links have no encoder (n,)."""
        return np.asarray(self.computed & ~self.data[0].has_q)

    @lazy
    def softness(self) -> Array:
        """Stiffness over the scale of the links' equations (n,).

        These equations are deflections times a stiffness that no fit changes; otherwise a softer spring would make the
        residuals smaller.
        """
        ratio = np.ones(self.true.n)
        if self.stiffness is not None:
            both = np.isfinite(self.stiffness) & self.true.elastic
            ratio[both] = self.true.stiffness[both] / self.stiffness[both]
        return ratio

    @lazy
    def motors(self) -> tuple[tuple[DCMotorLaw, ...], ...]:
        """The law of each joint's motor under voltage; none for a motor under torque."""
        laws = [law for law in self.true.motor_laws if isinstance(law, DCMotorLaw)]
        return tuple(tuple(law for law in laws if law.joint == name) for name in self.true.joint_names)

    @lazy
    def gains(self) -> Array:
        """True torque over recorded torque (n,): the equations have the scale of the recorded torque.

        The noise of the recorded torque is constant. Otherwise a motor without torque and an arm without mass would
        give residuals without noise.
        """
        gains = np.ones(self.true.n)
        for effect in self.true.all_effects:
            if isinstance(effect, JointEffect) and effect.scales_torque:
                gains[self.true.index(effect.joint)] += effect.torque_gain
        for j, laws in enumerate(self.motors):
            gains[j] *= math.prod(law.gain for law in laws)
        return np.where(np.abs(gains) < 0.05, np.copysign(0.05, gains), gains)
