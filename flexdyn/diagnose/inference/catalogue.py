"""What may be missing, as the posterior takes it, and its columns without the noise of the recorded torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import later
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.terms import joint_terms
from flexdyn.diagnose.hypothesis.own_effects import own_effects
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal, declared, extent_of
from flexdyn.diagnose.hypothesis.proposals import proposals
from flexdyn.effects import Effect, JointEffect, SensorEffect, catalogue


def everything(equations: Equations) -> list[Proposal]:
    """Every effect of the catalogue and of users that the model does not hold yet."""
    found = [*proposals(equations), *_loaded(equations), *own_effects(equations)[0]]
    return [each for each in found if not any(each.is_of(effect) for effect in equations.model.effects)]


def _loaded(equations: Equations) -> list[Proposal]:
    """Friction of rigid joints that takes the load: the model can hold it where the joint becomes elastic as well.

    Only the plain law: on a joint whose load nobody measures, laws that contain it share its name and hide others.
    """
    true, found = equations.true, []
    kinds = [kind for kind in catalogue().values() if kind.takes_load and kind.linear and not kind.contains]
    for j in np.flatnonzero(~true.elastic & (true.rotor_inertia > 0.0)).tolist():
        place, extent = {"joint": true.joint_names[j], "side": "motor"}, extent_of(equations, j)
        found += [declared(kind, place, extent) for kind in kinds]
    return found


def columns_of(equations: Equations, proposal: Proposal, point: Point) -> Array:
    """Derivatives of the residual (linear numbers, rows) of a proposal at a grid point."""
    return np.stack([_of_effect(equations, unit, scale) for unit, scale in proposal.units(point)])


def _of_effect(equations: Equations, effect: Effect, scale: float) -> Array:
    """Change of the residual (rows,) where the model has an effect more, over `scale`.

    Effects on the torque are computed from the torque that the model needs, because the noise of the recorded one is in
    the residual too (errors in variables). Laws that limit the torque are the exception: the lost part is not needed.
    """
    if isinstance(effect, SensorEffect) and effect.late_by and effect.signal == "tau":
        return _of_late_torque(equations, effect) / scale
    if not isinstance(effect, JointEffect):
        return columns.of_effect(equations, effect, scale)
    j = equations.true.index(effect.joint)
    if effect.takes_load and not equations.true.elastic[j]:
        return _of_loaded(equations, effect) / scale
    if effect.stage != "actuator" or effect.of_recorded_torque:
        return columns.of_effect(equations, effect, scale)

    def lost(along: SmoothedMotion) -> tuple[str, Array]:
        """What an error of the torque on its way changes, of the torque that the motion needs."""
        tau = along.tau.copy()
        tau[:, j] = equations.needed(along, j)
        return "motor", columns.on_its_way(equations.true, effect, replace(along, tau=tau, held=None), j)

    return equations.of_torque(j, lost) / scale


def _of_loaded(equations: Equations, effect: JointEffect) -> Array:
    true = equations.true
    j = true.index(effect.joint)

    def friction(along: SmoothedMotion) -> tuple[str, Array]:
        """Friction of the rotor that grows with the load."""
        # What a rigid joint carries: all that the link needs, the rotor left out, whose inertia is in M.
        carried = joint_terms(true, true.all_effects, along, j).tau_s - true.rotor_inertia[j] * along.a[:, j]
        return "motor", -effect.torque(along.theta[:, j], along.omega[:, j], tau=carried)

    return equations.of_torque(j, friction)


def _of_late_torque(equations: Equations, effect: SensorEffect) -> Array:
    j = equations.true.index(effect.joint)

    def earlier(along: SmoothedMotion) -> tuple[str, Array]:
        """How much an earlier torque differs from the one that the motion needs."""
        needed = equations.needed(along, j)
        return "motor", later(along.t, needed, -effect.lateness) - needed

    return equations.of_torque(j, earlier)
