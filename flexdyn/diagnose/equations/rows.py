"""How torques along a motion become rows of the equations."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.computed_positions import steepness
from flexdyn.diagnose.equations.layout import LINK, MOTOR, SENSOR, TOTAL, EquationLayout
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.response import LinkResponse
from flexdyn.diagnose.lazy import kept


@dataclass(frozen=True, eq=False)
class EquationRows(EquationLayout):
    """The equations of a model for measured channels, and the rows that torques have in them."""

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
