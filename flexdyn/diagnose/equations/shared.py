"""Common properties of two models, so that results for a recording can be shared between them."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.effects import Effect, InertiaEffect, SensorEffect
from flexdyn.effects.model_error import is_number_error
from flexdyn.io.locked import lock
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.resolved_parameters import OF_LINK
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide

SIGNALS_KEPT = 8
"""Filtered signals that are kept for each motion of the links."""
PROBES = 16
"""Samples by which signals are told apart before all are compared."""


class SharedResults:
    """M a + h along motions of the links, and signals after the first filter; the last ones are kept.

    Where links are measured, and positions of rotors computed, all models with the same links ask for the same torques.
    All models ask for the same measured signals.

    Args:
        room: torques that are kept, at most; `SIGNALS_KEPT` times as many signals.
    """

    def __init__(self, room: int) -> None:
        self.room = room
        self._known: tuple[tuple[LinkSide, tuple[Array, ...], Array], ...] = ()
        self._filtered: dict[tuple[object, ...], tuple[Array, Array]] = {}

    def filtered(self, kernel: GaussianSmoother, x: Array, order: int) -> Array:
        """`kernel.apply` of signals (samples, n) that nobody changes afterwards."""
        place = (kernel, order, x.shape, x[:: max(1, len(x) // PROBES)].tobytes())
        before, found = self._filtered.pop(place, (None, None))
        if before is None or found is None or not (before is x or np.array_equal(before, x)):
            before, found = x, lock(kernel.apply(x, order))
        self._filtered[place] = before, found  # the last one is the first that is kept
        for oldest in list(self._filtered)[: -SIGNALS_KEPT * self.room]:
            self._filtered.pop(oldest, None)
        return found

    def torques(self, links: LinkSide, *motion: Array) -> Array:
        """M a + h (samples, n) of positions, velocities and accelerations (samples, n)."""
        for owner, other, torques in self._known:
            if owner.same_as(links) and all(map(np.array_equal, motion, other)):
                return torques
        found = links.inverse_dynamics(*motion)
        self._known = ((links, motion, found), *self._known[: self.room - 1])
        return found


def same_signals(one: FlexibleJointModel, other: FlexibleJointModel) -> bool:
    """Whether two models give the same signals after the first filter if no position is computed."""
    mine, its = ([e for e in each.effects if isinstance(e, SensorEffect)] for each in (one, other))
    return mine == its and np.array_equal(one.elastic, other.elastic)


def same_links(one: FlexibleJointModel, other: FlexibleJointModel) -> bool:
    """Whether M and h agree: the same links, payloads, and rotors of rigid joints."""
    rigid = ~one.elastic
    mine, its = ([e for e in each.resolved().effects if isinstance(e, InertiaEffect)] for each in (one, other))
    rotors = np.array_equal(one.resolved().rotor_inertia[rigid], other.resolved().rotor_inertia[rigid])
    return rotors and mine == its and one.robot is other.robot and _wrong(one) == _wrong(other)


def _wrong(model: FlexibleJointModel) -> list[Effect]:
    """Errors of the links' numbers."""
    return [effect for effect in model.effects if is_number_error(effect) and effect.parameter in OF_LINK]
