"""Residuals of the equations of motion along measured motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.abreast import SILENT, abreast
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.data.sensors import corrected
from flexdyn.diagnose.equations.motion import Smoothed, SmoothedMotion, hidden_links, motion, smoothed
from flexdyn.diagnose.equations.rest import Rests
from flexdyn.diagnose.equations.shared import same_links, same_signals
from flexdyn.diagnose.equations.terms import joint_terms, of_joint, spring_torque
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.progress import check
from flexdyn.effects import Effect, JointEffect, TorqueConstantError
from flexdyn.effects.motor import MotorTorque
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.plant import LinkSide

MOTOR, LINK, TOTAL, TRANSMISSION, SENSOR = "motor", "link", "total", "transmission", "sensor"


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of a model along measured motions.

    Rows of all recordings follow one another, time by time, and at each time stand the equations in the order of
    `kinds`: the motor's and the link's of an elastic joint with both encoders, else the joint's total; the motor's
    alone where a test rig moves the motor and the link behind it is simulated, not measured; on a rigid joint with
    both encoders also theta = q, from the start on and whatever a model makes of the joint later [rad or m].

    Attributes:
        model: that has the equations.
        data: the recordings, as measured.
        filters: that every term passes.
        stiffness: scale of the links' equations (n,) [N m/rad]; None: the model's own.
        quasi_static: whether an unmeasured link whose motor rests is taken to follow its load without ringing, so that
            the equations of other joints can be used meanwhile.
    """

    model: FlexibleJointModel
    data: tuple[Measured, ...]
    filters: Filters
    stiffness: Array | None = None
    quasi_static: bool = False

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

    @lazy
    def sensed(self) -> bool:
        """Whether a torque was measured in any transmission."""
        return any(kind == SENSOR for _, kind in self.kinds)

    @lazy
    def links(self) -> LinkSide:
        """M and h of the model."""
        return LinkSide(self.true)

    @lazy
    def motions(self) -> tuple[SmoothedMotion, ...]:
        """The smoothed motions, without the sensor effects of the model."""
        bases = self._bases or (None,) * len(self.smoothed)
        return tuple(motion(self.links, *each) for each in zip(self.smoothed, bases, strict=True))

    @lazy
    def _bases(self) -> tuple[SmoothedMotion, ...]:
        """Motions of the model from which this one was made, by `of`."""
        return ()

    @lazy
    def smoothed(self) -> tuple[Smoothed, ...]:
        """The recordings after the first filter, without the sensor effects of the model."""
        return tuple(
            smoothed(self.true, self.links, corrected(data, self.model), self.filters.first, rests)
            for data, rests in zip(self.data, self.rests, strict=True)
        )

    @lazy
    def rests(self) -> tuple[Rests | None, ...]:
        """Where motors rest whose links are not measured, by recording; None: nowhere, or it is not made use of."""
        found = (Rests.of(each, self.filters) if self.quasi_static else None for each in self.data)
        return tuple(each if each is not None and each.where.any() else None for each in found)

    @lazy
    def residual(self) -> Array:
        """The residuals (rows,) [N m or N]: only noise if the model is right."""
        check()
        return self._rows(self.true, self.motions, self.true.all_effects)

    def of(self, model: FlexibleJointModel) -> Equations:
        """The same data with another model; motions are shared if the models do not change them."""
        own = self.true.stiffness if self.stiffness is None else self.stiffness
        other = replace(self, model=model, stiffness=own)
        other.__dict__["rests"] = self.rests
        if not (self.made_up.any() or self.replayed.any()) and same_signals(self.model, model):
            other.__dict__["smoothed"] = self.smoothed
            if same_links(self.model, model):
                other.__dict__["links"] = self.links
                other.__dict__["motions"] = self.motions
                return other
        other.__dict__["_bases"] = tuple(each.near or each for each in self.motions)
        return other

    def of_joint(self, j: int, model: FlexibleJointModel, effects: Sequence[Effect]) -> Array:
        """The contribution of one joint's terms to the rows (rows,), without the inertia of the links."""
        parts = []
        for along in self.motions:
            terms = joint_terms(model, effects, along, j)
            rotor = model.rotor_inertia[j] * along.alpha[:, j] if model.elastic[j] else 0.0
            parts.append(self.combined(along, terms.motor - rotor, terms.link, -terms.tau_s, only=j).ravel())
        return np.concatenate(parts)

    def own(self, j: int) -> Array:
        """The contribution of one joint's terms to the rows (rows,) with the model's own effects; it is cached."""
        if j not in self._own:
            self._own[j] = self.of_joint(j, self.true, self.true.all_effects)
        return self._own[j]

    @lazy
    def _own(self) -> dict[int, Array]:
        return {}

    @lazy
    def made_up(self) -> Flags:
        """Elastic joints with one of their two positions unmeasured, and made up from what was recorded (n,)."""
        return np.asarray(self.true.elastic & ~self.data[0].both & ~self.replayed)

    @lazy
    def replayed(self) -> Flags:
        """Joints whose motors are moved as recorded, and whose links are simulated behind them (n,)."""
        return hidden_links(self.true, self.data[0])

    def needed(self, along: SmoothedMotion, j: int) -> Array:
        """Motor torque (samples,) that the model needs for a motion.

        In columns it replaces the commanded torque, whose noise is also in the residual and would cause a bias.
        """
        known = self._needed.setdefault(j, [])
        found = next((torque for motion, torque in known if motion is along), None)
        if found is None:
            found = self._needs(along, j)
            known.append((along, found))
        return found

    @lazy
    def _needed(self) -> dict[int, list[tuple[SmoothedMotion, Array]]]:
        return {}

    def _needs(self, along: SmoothedMotion, j: int) -> Array:
        effects = [e for e in self.true.all_effects if e.stage != "actuator"]
        terms = joint_terms(self.true, effects, along, j)
        left = along.tau[:, j] - terms.motor
        if self.true.elastic[j]:
            left = left + self.true.rotor_inertia[j] * along.alpha[:, j]
        else:
            left = left + along.inverse_dynamics[:, j] - terms.link
        for law in self.motors[j]:
            left = left / law.gain + self.lost(along, j)
        return np.asarray(left)

    def of_spring(self, j: int, effect: JointEffect) -> Array:
        """Change of the rows (rows,) by an effect more in a transmission whose torque nothing else depends on."""
        parts = []
        for k, along in enumerate(self.motions):
            acting = of_joint(self.true.all_effects, self.true.joint_names[j])
            if (k, j) not in self._springs:
                self._springs[k, j] = spring_torque(self.true, acting, along, j)
            link, motor = (spring_torque(self.true, [*acting, effect], along, j) - self._springs[k, j]).T.copy()
            sensed = -link if along.data.both[j] or self.replayed[j] else None
            parts.append(self.combined(along, -motor, link, sensed, only=j).ravel())
        return np.concatenate(parts)

    @lazy
    def _springs(self) -> dict[tuple[int, int], Array]:
        return {}

    def lost(self, along: SmoothedMotion, j: int) -> Array:
        """The part of the commanded torque (samples,) that the back-EMF of a motor under voltage takes; else zero."""
        return np.asarray(self.back_emf(j) * along.omega[:, j])

    def back_emf(self, j: int) -> float:
        """Decrease of the torque of a motor under voltage with speed [N m s/rad]."""
        return sum(law.back_emf / law.gain for law in self.motors[j])

    def of_torque(self, j: int, torque: Callable[[SmoothedMotion], tuple[str, Array]]) -> Array:
        """The contribution of one torque on the motor or link side of a joint to the rows (rows,)."""
        parts = []
        for along in self.motions:
            side, values = torque(along)
            motor, link = (values, None) if side == MOTOR else (None, values)
            carried = None if self.true.elastic[j] else link
            parts.append(self.combined(along, motor, link, carried, only=j).ravel())
        return np.concatenate(parts)

    def of_damper(self, j: int) -> Array:
        """The contribution of the damper of an elastic joint with both encoders to the rows (rows,)."""
        parts = []
        for along in self.motions:
            torque = self.true.damping[j] * along.ddelta[:, j]
            parts.append(self.combined(along, -torque, torque, -torque, only=j).ravel())
        return np.concatenate(parts)

    def of_links(self, others: Sequence[LinkSide]) -> Array:
        """Change of the rows (rows, others) with other inertias of the links: minus the change of ``M a + h``."""
        parts = []
        for along in self.motions:
            extra = self.links.extra_torques(others, along.q, along.v, along.a)
            parts.append(np.stack(abreast(partial(self._heavier, along), extra.transpose(1, 0, 2)), axis=1))
        return np.concatenate(parts)

    def _heavier(self, along: SmoothedMotion, more: Array) -> Array:
        """Change of the rows (times * equations,) if the links need additional torques (samples, n)."""
        with SILENT():
            needed = np.where(self.true.elastic, 0.0, -more)
            return self.combined(along, None, -more, needed).ravel()

    def of_channel(self, signal: str, j: int, error: Callable[[Measured], Array]) -> Array:
        """First-order change of the rows (rows,) if a true channel is the measured one plus `error` (samples,).

        A position that is computed from the other encoder changes with it. The change of friction is neglected.
        """
        parts = []
        model = self.true
        for along in self.motions:
            wrong = error(along.data)
            d0 = self._smoothed(along, wrong, 0)
            if signal in ("tau", "tau_s"):
                motor, tau_s = (d0, None) if signal == "tau" else (None, d0)
                parts.append(self.combined(along, motor, None, tau_s, only=j).ravel())
                continue
            d1, d2 = (self._smoothed(along, wrong, k) for k in (1, 2))
            alone, sign = not along.data.both[j], 1.0 if signal == "theta" else -1.0
            rows = np.zeros((self.filters.count(len(along.t)), len(self.kinds)))
            if signal == "q" or alone:
                rows += self.combined(along, None, -along.dragged(j, (d0, d1, d2)), None)
            if model.elastic[j]:
                rotor = -model.rotor_inertia[j] * d2 if signal == "theta" or alone else 0.0
                bent = 0.0 * d0 if alone else sign * (model.stiffness[j] * d0 + model.damping[j] * d1)
                rows += self.combined(along, rotor - bent, bent, -bent, only=j)
            elif not alone:
                wound = np.zeros_like(along.q)
                wound[:, j] = sign * d0
                rotor = -sign * model.rotor_inertia[j] * d2
                rows += self.combined(along, rotor, None, None, only=j, wound=wound)
            parts.append(rows.ravel())
        return np.concatenate(parts)

    def _smoothed(self, along: SmoothedMotion, x: Array, order: int) -> Array:
        y = self.filters.first.apply(x, order)
        spare = (len(y) - len(along.t)) // 2
        if self.made_up.any() or self.replayed.any():
            return self.filters.first.apply(y, 0)
        return y[spare : len(y) - spare]

    def _rows(self, model: FlexibleJointModel, motions: Sequence[SmoothedMotion], effects: Sequence[Effect]) -> Array:
        return np.concatenate([self._of_motion(model, each, effects).ravel() for each in motions])

    def _of_motion(self, model: FlexibleJointModel, along: SmoothedMotion, effects: Sequence[Effect]) -> Array:
        """Residuals of one recording (times, equations)."""
        terms = [joint_terms(model, effects, along, j) for j in range(model.n)]
        motor = np.stack([each.motor for each in terms], axis=1)
        link = np.stack([each.link for each in terms], axis=1) - along.inverse_dynamics
        # The inertia of a rigid joint's rotor is in M; if theta was measured, it gives the acceleration more
        # accurately.
        ahead = along.alpha - np.where(model.elastic, 0.0, along.a)
        motor -= model.rotor_inertia * ahead
        tau_s = along.tau_s - np.stack([each.tau_s for each in terms], axis=1)
        return self.combined(along, motor, link, tau_s, wound=along.delta)

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
        motor_, link_, sensor_ = (self._filtered(along, torque, only) for torque in each)
        lifted = self._lifted(along, motor, link, only)
        for place, (j, kind) in enumerate(self.kinds):
            if kind == MOTOR and self.true.elastic[j]:
                rows[:, place] = motor_[:, j] / self.gains[j]
            elif kind == SENSOR:
                rows[:, place] = sensor_[:, j]
            elif kind in (MOTOR, TOTAL):
                rows[:, place] = (link_[:, j] + lifted[:, j] + motor_[:, j]) / self.gains[j]
            elif kind == LINK and self.true.elastic[j]:
                rows[:, place] = (link_[:, j] + lifted[:, j]) / self.softness[j]
            elif self.true.elastic[j]:
                rows[:, place] = (link_[:, j] + lifted[:, j]) / self.true.stiffness[j]
            elif wound is not None:  # rigid: theta should be q
                unit = self.stiffness[j] if kind == LINK and self.stiffness is not None else 1.0
                rows[:, place] = unit * self.filters.rows(wound[:, j])
        return rows

    def _filtered(self, along: SmoothedMotion, torque: Array | None, only: int | None) -> Array:
        """Rows (times, n) of a torque (samples, n), or of one joint alone (samples,)."""
        rows = np.zeros((self.filters.count(len(along.t)), self.true.n))
        if torque is not None and torque.any():
            rows[:, slice(None) if only is None else only] = self.filters.rows(torque)
        return rows

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
    def motors(self) -> tuple[tuple[MotorTorque, ...], ...]:
        """The law of each joint's motor under voltage; None for a motor under torque."""
        laws = [law for law in self.true.motor_laws if isinstance(law, MotorTorque)]
        return tuple(tuple(law for law in laws if law.joint == name) for name in self.true.joint_names)

    @lazy
    def gains(self) -> Array:
        """True torque over recorded torque (n,): the equations have the scale of the recorded torque.

        The noise of the recorded torque is constant. Otherwise a motor without torque and an arm without mass would
        give residuals without noise.
        """
        gains = np.ones(self.true.n)
        for effect in self.true.all_effects:
            if isinstance(effect, TorqueConstantError):
                gains[self.true.index(effect.joint)] += effect.gain
        for j, laws in enumerate(self.motors):
            gains[j] *= math.prod(law.gain for law in laws)
        return np.where(np.abs(gains) < 0.05, np.copysign(0.05, gains), gains)

    def _lifted(self, along: SmoothedMotion, motor: Array | None, link: Array | None, only: int | None) -> Array:
        """The effect of computed positions on the equations (times, n).

        A link position from the motor's equation has the error ``-motor/K``: its acceleration loads every link, and it
        changes the torques of gravity and Coriolis. While the motor rests, the link position is from the link's own
        equation and has the error ``link/K``. A rotor position from the link's equation has the error ``-link/K``,
        whose acceleration loads the rotor.
        """
        first, model = along.data, self.true
        lifted = np.zeros((self.filters.count(len(along.t)), model.n))
        at = self.filters.instants(len(along.t))
        for i in np.flatnonzero(self.made_up).tolist():
            if only not in (None, i):
                continue
            own = [x if x is None or only == i else x[:, i] for x in (motor, link)]
            if first.has_q[i] and own[1] is not None:
                lifted[:, i] += model.rotor_inertia[i] * self.filters.rows(own[1] / model.stiffness[i], 2)
            elif not first.has_q[i] and (own[0] is not None or along.resting[:, i].any()):
                by_motor, by_link = (np.zeros(len(along.t)) if x is None else x for x in own)
                wrong = by_motor / model.stiffness[i]
                if along.resting[:, i].any():
                    wrong = np.where(along.resting[:, i], -self.filters.calmed(by_link) / model.stiffness[i], wrong)
                lifted += along.dragged(i, [self.filters.rows(wrong, order) for order in range(3)], at)
        return lifted
