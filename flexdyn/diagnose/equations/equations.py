"""Residuals of the equations of motion along measured motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.data.sensors import true_channels
from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.equations.layout import MOTOR
from flexdyn.diagnose.equations.motion import SmoothedMotion, motion
from flexdyn.diagnose.equations.rest import Rests
from flexdyn.diagnose.equations.rows import EquationRows
from flexdyn.diagnose.equations.shared import SharedResults, same_links, same_signals
from flexdyn.diagnose.equations.smoothed import Smoothed, smoothed
from flexdyn.diagnose.equations.springs import spring_torque
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.diagnose.lazy import kept, lazy
from flexdyn.diagnose.parallel import SILENT, in_parallel
from flexdyn.diagnose.progress import check
from flexdyn.effects import Effect, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.link_side import LinkSide

Torques = tuple[Array | None, Array | None, Array | None]
"""In a joint's equations of the motor, of the link and of the torque sensor (samples,) each; None: nothing."""

MODELS_KEPT = 2
"""Other models of the same data whose equations are kept: fits, weights and odds ask for the same ones again."""
TORQUES_KEPT = 4
"""Motions of each recording whose torques of the links are kept: behind each of two filters, of two models."""


@dataclass(frozen=True, eq=False)
class Equations(EquationRows):
    """The equations of a model along measured motions.

    Attributes:
        quasi_static: whether an unmeasured link whose motor rests is taken to follow its load without ringing, so that
            the equations of other joints can be used meanwhile.
        error: known error of the rows (rows,), taken off the residual; None: none is known.
        began: how simulated links begin in each recording, see `links_behind_motors`; None: at rest, held by gravity.
    """

    quasi_static: bool = False
    error: Array | None = None
    began: tuple[Array, ...] | None = None

    @lazy
    def links(self) -> LinkSide:
        """M and h of the model."""
        return LinkSide(self.true)

    @lazy
    def motions(self) -> tuple[SmoothedMotion, ...]:
        """The smoothed motions, without the sensor effects of the model."""
        bases = self._bases or (None,) * len(self.smoothed)
        return tuple(motion(self.links, *each, self.shared) for each in zip(self.smoothed, bases, strict=True))

    @lazy
    def shared(self) -> SharedResults:
        """What other models of the same data ask for, too."""
        return SharedResults(TORQUES_KEPT * len(self.data))

    @lazy
    def _bases(self) -> tuple[SmoothedMotion, ...]:
        """Motions of the model from which this one was made, by `of`."""
        return ()

    @lazy
    def smoothed(self) -> tuple[Smoothed, ...]:
        """The recordings after the first filter, without the sensor effects of the model."""
        return tuple(
            smoothed(
                self.true,
                self.links,
                true_channels(data, self.model),
                self.filters.first,
                rests,
                simulated=self.simulated,
                began=None if self.began is None else self.began[k],
                shared=self.shared,
            )
            for k, (data, rests) in enumerate(zip(self.data, self.rests, strict=True))
        )

    @lazy
    def rests(self) -> tuple[Rests | None, ...]:
        """Where motors rest whose links are not measured, by recording; None: nowhere, or it is not made use of."""
        if self.simulated:
            return tuple(Rests.everywhere(each, self.filters) for each in self.data)
        found = (Rests.of(each, self.filters) if self.quasi_static else None for each in self.data)
        return tuple(each if each is not None and each.where.any() else None for each in found)

    @lazy
    def residual(self) -> Array:
        """The residuals (rows,) [N m or N]: only noise if the model is right."""
        check()
        left = self._rows(self._left)
        return left if self.error is None else left - self.error

    @lazy
    def counts(self) -> tuple[int, ...]:
        """Rows of an equation in each recording."""
        return tuple(self.filters.count(len(along.t)) for along in self.motions)

    def by_recording(self, table: Array) -> list[Array]:
        """Rows of an equation (rows of an equation, ...), recording by recording."""
        return np.split(table, np.cumsum(self.counts)[:-1])

    def at_rows(self, signal: str) -> Array:
        """A signal of the motions at the rows of an equation: ``t`` (rows of an equation,), ``q`` (..., n)."""
        return np.concatenate([getattr(each, signal)[self.filters.instants(len(each.t))] for each in self.motions])

    def of(self, model: FlexibleJointModel) -> Equations:
        """The same data with another model; the last ones are kept."""
        found = next((each for each in self._others if each.model == model), None) or self._with(model)
        self._others[:] = [found, *(each for each in self._others if each is not found)][:MODELS_KEPT]
        return found

    @lazy
    def _others(self) -> list[Equations]:
        return []

    def _with(self, model: FlexibleJointModel) -> Equations:
        """The same data with another model; motions are shared if the models do not change them."""
        own = self.true.stiffness if self.stiffness is None else self.stiffness
        other = self._sharing(model=model, stiffness=own)
        if not (self.computed.any() or self.replayed.any()) and same_signals(self.model, model):
            other.__dict__["smoothed"] = self.smoothed
            if same_links(self.model, model):
                other.__dict__["links"] = self.links
                other.__dict__["motions"] = self.motions
                return other
        other.__dict__["_bases"] = tuple(each.near or each for each in self.motions)
        return other

    def with_filters(self, filters: Filters) -> Equations:
        """The same model and data behind other filters."""
        return replace(self, filters=filters, error=None)

    def less(self, error: Array) -> Equations:
        """The same without a known error of the rows (rows,)."""
        return self._sharing(error=error)

    def beginning(self, more: Array) -> Equations:
        """The same where simulated links begin otherwise.

        Args:
            more: deflections and their rates in addition, in the order of `of_first_states` (states,).
        """
        joints, still = np.flatnonzero(self.unmeasured), np.zeros((2, self.true.n))
        began = [each.copy() for each in self.began or (still,) * len(self.data)]
        for states, change in zip(began, more.reshape(len(began), len(joints), 2), strict=True):
            states[:, joints] += change.T
        return self._sharing(began=tuple(began))

    def along(self, data: tuple[Measured, ...]) -> Equations:
        """The same model along other recordings of the same motion; motors rest where they did."""
        return self._sharing(data=data)

    def _sharing(self, **changes: Any) -> Equations:
        """The same with some changes; motors rest where they did, and torques that are known are kept."""
        other = replace(self, **changes)
        other.__dict__["rests"], other.__dict__["shared"] = self.rests, self.shared
        return other

    def change(self, effects: Sequence[Effect]) -> Array:
        """Change of the residual (rows,) where the model has these effects; all equations are computed again."""
        return self._with(self.model.replace(effects=effects)).residual - self.residual

    def of_terms(self, j: int, terms: Callable[[SmoothedMotion], Torques]) -> Array:
        """The contribution of torques in one joint's equations to the rows (rows,)."""
        return self._rows(lambda along: self.combined(along, *terms(along), only=j))

    def of_joint(self, j: int, model: FlexibleJointModel, effects: Sequence[Effect]) -> Array:
        """The contribution of one joint's terms to the rows (rows,), without the inertia of the links."""

        def terms(along: SmoothedMotion) -> Torques:
            """Torques of the joint's own terms."""
            found = joint_terms(model, effects, along, j)
            rotor = model.rotor_inertia[j] * along.alpha[:, j] if model.elastic[j] else 0.0
            return found.motor - rotor, found.link, -found.tau_s

        return self.of_terms(j, terms)

    @kept
    def own(self, j: int) -> Array:
        """The contribution of one joint's terms to the rows (rows,) with the model's own effects."""
        return self.of_joint(j, self.true, self.true.all_effects)

    @kept
    def needed(self, along: SmoothedMotion, j: int) -> Array:
        """Motor torque (samples,) that the model needs for a motion.

        In columns it replaces the commanded torque, whose noise is also in the residual and would cause a bias.
        """
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

    def lost(self, along: SmoothedMotion, j: int) -> Array:
        """The part of the commanded torque (samples,) that the back-EMF of a motor under voltage takes; else zero."""
        per_speed = sum(law.back_emf / law.gain for law in self.motors[j])
        return np.asarray(per_speed * along.omega[:, j])

    def of_spring(self, j: int, effect: JointEffect) -> Array:
        """Change of the rows (rows,) by an effect more in a transmission whose torque nothing else depends on."""
        acting = acting_on(self.true, j)

        def terms(along: SmoothedMotion) -> Torques:
            """Changes of the torques by the additional effect in the transmission."""
            wound = spring_torque(self.true, [*acting, effect], along, j) - self.spring(along, j)
            link, motor = wound.T.copy()
            return -motor, link, -link if along.data.both[j] or self.replayed[j] else None

        return self.of_terms(j, terms)

    @kept
    def spring(self, along: SmoothedMotion, j: int) -> Array:
        """The torque in a transmission on the link, and on the rotor (samples, 2)."""
        return spring_torque(self.true, acting_on(self.true, j), along, j)

    def of_torque(self, j: int, torque: Callable[[SmoothedMotion], tuple[str, Array]]) -> Array:
        """The contribution of one torque on the motor or link side of a joint to the rows (rows,)."""

        def terms(along: SmoothedMotion) -> Torques:
            """The torque where it acts: on a rigid joint, a torque on the link is one of the transmission, too."""
            side, values = torque(along)
            if side == MOTOR:
                return values, None, None
            return None, values, None if self.true.elastic[j] else values

        return self.of_terms(j, terms)

    def of_links(self, others: Sequence[LinkSide]) -> Array:
        """Change of the rows (rows, others) with other inertias of the links: minus the change of ``M a + h``."""
        parts = []
        for along in self.motions:
            extra = self.links.extra_torques(others, along.q, along.v, along.a)
            parts.append(np.stack(in_parallel(partial(self._heavier, along), extra.transpose(1, 0, 2)), axis=1))
        return np.concatenate(parts)

    def _heavier(self, along: SmoothedMotion, more: Array) -> Array:
        """Change of the rows (times * equations,) if the links need additional torques (samples, n)."""
        with SILENT():
            needed = np.where(self.true.elastic, 0.0, -more)
            return self.combined(along, None, -more, needed).ravel()

    def _rows(self, of_motion: Callable[[SmoothedMotion], Array]) -> Array:
        """Rows (rows,) of all recordings, of which each motion has its own (times, equations)."""
        return np.concatenate([of_motion(each).ravel() for each in self.motions])

    def _left(self, along: SmoothedMotion) -> Array:
        """Residuals of one recording (times, equations)."""
        model = self.true
        terms = [joint_terms(model, model.all_effects, along, j) for j in range(model.n)]
        motor, link, tau_s = (np.stack([getattr(e, x) for e in terms], axis=1) for x in ("motor", "link", "tau_s"))
        # The inertia of a rigid joint's rotor is in M; if theta was measured, it gives the acceleration more
        # accurately.
        motor -= model.rotor_inertia * (along.alpha - np.where(model.elastic, 0.0, along.a))
        link -= along.inverse_dynamics
        return self.combined(along, motor, link, along.tau_s - tau_s, wound=along.delta)
