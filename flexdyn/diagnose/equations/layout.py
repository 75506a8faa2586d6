"""Which equations a model has for what was measured, and how torques become their rows."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.computed_positions import steepness
from flexdyn.diagnose.equations.motion import SmoothedMotion, hidden_links
from flexdyn.diagnose.equations.response import LinkResponse
from flexdyn.diagnose.lazy import kept, lazy
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

    def back_emf(self, j: int) -> float:
        """Decrease of the torque of a motor under voltage with speed [N m s/rad]."""
        return sum(law.back_emf / law.gain for law in self.motors[j])

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

    def combined(
        self,
        along: SmoothedMotion,
        motor: Array | None,
        link: Array | None,
        tau_s: Array | None,
        only: int | None = None,
        wound: Array | None = None,
    ) -> Array:
        """Rows (times, equations) of the terms in the equations of motors, links and sensors (samples, n).

        With `only`, the terms of that joint alone (samples,). None: no terms. `wound` is the deflection of rigid joints
        (samples, n), if any.
        """
        rows = np.zeros((self.filters.count(len(along.t)), len(self.kinds)))
        each = (motor, link, tau_s if self.sensed else None)
        motor_, link_, sensor_ = (self._filtered(torque, only) for torque in each)
        # What is simulated leaves nothing in its own equations: `wound` is given with the model's own terms.
        lifted = self._lifted(along, motor, link, only, None if wound is not None else self._behind(along, link, only))
        for place, (j, kind) in enumerate(self.kinds):
            if kind == SENSOR:
                rows[:, place] = sensor_(j)
            elif kind == TOTAL or (kind == MOTOR and not self.true.elastic[j]):
                rows[:, place] = (link_(j) + lifted[:, j] + motor_(j)) / self.gains[j]
            elif kind == MOTOR:
                rows[:, place] = motor_(j) / self.gains[j]
            elif self.true.elastic[j]:
                unit = (self.softness if kind == LINK else self.true.stiffness)[j]
                rows[:, place] = (link_(j) + lifted[:, j]) / unit
            elif wound is not None:  # rigid: theta should be q
                unit = self.stiffness[j] if kind == LINK and self.stiffness is not None else 1.0
                rows[:, place] = unit * self.filters.rows(wound[:, j])
        return rows

    def _filtered(self, torque: Array | None, only: int | None) -> Callable[[int], Array | float]:
        """Rows by joint (times,) of a torque (samples, n), or of one joint alone (samples,); 0 where there is none."""
        if torque is None or not torque.any():
            return lambda j: 0.0
        rows = self.filters.rows(torque)
        return lambda j: rows[:, j] if only is None else rows if j == only else 0.0

    def _lifted(
        self, along: SmoothedMotion, motor: Array | None, link: Array | None, only: int | None, behind: Array | None
    ) -> Array:
        """The effect of computed positions on the equations (times, n).

        A link position from the motor's equation has the error ``-motor/K``: its acceleration loads every link, and it
        changes the torques of gravity and Coriolis. While the motor rests, the link position is from the link's own
        equation and has the error ``link/K``. Where it is simulated, its error is the response to the torques on all
        links. A rotor position from the link's equation has the error ``-link/K``, whose acceleration loads the rotor.
        """
        first, model = along.data, self.true
        lifted = np.zeros((self.filters.count(len(along.t)), model.n))
        at = self.filters.instants(len(along.t))
        for i in np.flatnonzero(self.computed).tolist():
            own = [None if x is None or only not in (None, i) else x if only == i else x[:, i] for x in (motor, link)]
            if first.has_q[i]:
                if own[1] is not None:
                    lifted[:, i] += model.rotor_inertia[i] * self.filters.rows(own[1] / model.stiffness[i], 2)
                continue
            wrong = -behind[:, i] if behind is not None else self._misplaced(along, i, *own)
            if wrong is not None:
                lifted += along.dragged(i, [self.filters.rows(wrong, order) for order in range(3)], at)
        return lifted

    def _misplaced(self, along: SmoothedMotion, i: int, motor: Array | None, link: Array | None) -> Array | None:
        """Error of a link position that was computed (samples,), by the error of the torques on its motor and link."""
        rests, K = along.resting[:, i], self.true.stiffness[i]
        if self.simulated or (motor is None and (link is None or not rests.any())):
            return None
        wrong = np.zeros(len(along.t)) if motor is None else motor / K
        if rests.any():
            wrong = np.where(rests, 0.0 if link is None else -self.filters.calmed(link) / K, wrong)
        return wrong

    def _behind(self, along: SmoothedMotion, link: Array | None, only: int | None) -> Array | None:
        """Deflections (samples, n) that torques on the links (samples, n), or of one joint, cause behind all motors."""
        if link is None or not self.simulated:
            return None
        joints = np.flatnonzero(self.unmeasured)
        torques = np.zeros((len(along.t), self.true.n))
        torques[:, slice(None) if only is None else only] = link
        found = np.zeros_like(torques)
        found[:, joints] = self.response(along)(torques[:, joints])
        return found

    @kept
    def response(self, along: SmoothedMotion) -> LinkResponse:
        """How the unmeasured links respond to a torque."""
        joints = np.flatnonzero(self.unmeasured)
        by_place, by_speed, M = dataclasses.replace(along, near=None).slopes_by(joints)
        K = np.stack([steepness(self.true, j, along.delta[:, j]) for j in joints.tolist()], axis=1)
        spring, damper = K[:, :, None] * np.eye(len(joints)), np.diag(self.true.damping[joints])
        return LinkResponse.of(M, spring + by_place, damper + by_speed, along.dt)

    def behind(self, along: SmoothedMotion, deflections: Array) -> Array:
        """Rows (times, equations) of additional deflections of the simulated links (samples, links)."""
        found = np.zeros((len(along.t), self.true.n))
        found[:, self.unmeasured] = deflections
        rows = np.zeros((self.filters.count(len(along.t)), len(self.kinds)))
        lifted = self._lifted(along, None, None, None, found)
        for place, (j, kind) in enumerate(self.kinds):
            rows[:, place] = lifted[:, j] / self.gains[j] if kind == TOTAL else 0.0
        return rows
