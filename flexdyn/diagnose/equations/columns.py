"""Derivatives of the residuals with respect to effects and their parameters."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.compliance import of_compliance
from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.motion import SmoothedMotion
from flexdyn.diagnose.equations.sensor_columns import of_sensor
from flexdyn.diagnose.equations.terms import applied_torque, own_torque, spreads
from flexdyn.diagnose.lazy import kept
from flexdyn.effects import Effect, JointEffect, SensorEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.link_side import LinkSide

TOLD = 1e-3
"""Share of the largest torque that an effect must make for a simulation to tell it well [1]."""
ENLARGEMENTS, LARGEST_ENLARGEMENT = 8, 1e4
"""Times that an effect is taken larger, and by how much at most each time."""


def stands_alone(equations: Equations, effect: JointEffect) -> bool:
    """Whether an effect's torque enters the equations directly and changes no other torque."""
    if effect.takes_load or effect.stage not in ("friction", "dry", "link") or effect.side not in ("motor", "link"):
        return False
    j = equations.true.index(effect.joint)
    if equations.replayed[j] and effect.side != "motor":
        return False
    return not (equations.computed[j] and (equations.sensed or is_loaded(equations, j)))


def is_loaded(equations: Equations, j: int) -> bool:
    """Whether a joint has friction that depends on its transmission torque."""
    return any(effect.takes_load for effect in acting_on(equations.true, j))


def moves_links(equations: Equations, effect: Effect) -> bool:
    """Whether an effect changes how links move that are simulated behind prescribed motors."""
    if not equations.replayed.any():
        return False
    if isinstance(effect, SensorEffect):
        return effect.signal != "tau"
    if not isinstance(effect, JointEffect) or spreads(effect, equations.true):
        return True
    return bool(equations.replayed[equations.true.index(effect.joint)]) and effect.side != "motor"


def _bends(equations: Equations, effect: Effect) -> bool:
    """Whether a position that was computed from the other one depends on an effect."""
    return isinstance(effect, JointEffect) and bool(
        effect.bends_spring and equations.computed[equations.true.index(effect.joint)]
    )


def of_replay(equations: Equations, effect: Effect, scale: float) -> Array:
    """Change of the residual (rows,) where the links are simulated with an effect more, over `scale`.

    An effect that is so small that the simulation hardly tells it is taken larger, until it does `TOLD` of the torque.
    """
    size, change = 1.0, np.zeros_like(equations.residual)
    least = TOLD * max(float(np.abs(each.tau).max()) for each in equations.motions)
    zeros = [name for name, nothing in effect.neutral.items() if nothing == 0.0]
    for _ in range(ENLARGEMENTS):
        larger = effect.replace(**{name: size * getattr(effect, name) for name in zeros})
        change = equations.change([*equations.model.effects, larger])
        largest = float(np.abs(change).max())
        if not zeros or not largest < least:
            return change / (size * scale)
        size *= float(np.clip(2.0 * least / max(largest, 1e-300), 10.0, LARGEST_ENLARGEMENT))
    return np.zeros_like(change)


def of_change(equations: Equations, effect: JointEffect, moved: JointEffect) -> Array:
    """Change of the residual (rows,) if an effect without influence on others is replaced by another of its kind."""

    def change(along: SmoothedMotion) -> tuple[str, Array]:
        """The side that the effect acts on, and how much more torque it makes where it is moved."""
        (side, before), (_, after) = (own_torque(each, equations.true, along) for each in (effect, moved))
        return side, after - before

    return equations.of_torque(equations.true.index(effect.joint), change)


def of_effect(equations: Equations, effect: Effect, scale: float = 1.0) -> Array:
    """Change of the residual (rows,) where the model has an effect more, over `scale`."""
    if moves_links(equations, effect):
        return of_replay(equations, effect, scale)
    if isinstance(effect, SensorEffect):
        return of_sensor(equations, effect) / scale
    if effect.stage == "inertia":
        model = equations.true.replace(effects=[*equations.true.effects, effect])
        return equations.of_links([LinkSide(model)])[:, 0] / scale
    if _bends(equations, effect):
        return equations.change([*equations.model.effects, effect]) / scale
    true, effect = equations.true, on_joint(effect)
    j = true.index(effect.joint)
    if effect.makes_elastic:  # to first order
        return of_compliance(equations, j) / (float(getattr(effect, effect.makes_elastic)) * scale)
    if effect.scales_torque:

        def gained(along: SmoothedMotion) -> tuple[str, Array]:
            """What a gain adds to the torque of the motor."""
            return "motor", effect.torque_gain * (equations.needed(along, j) - equations.lost(along, j))

        return equations.of_torque(j, gained) / scale
    if stands_alone(equations, effect):
        return equations.of_torque(j, lambda along: own_torque(effect, true, along)) / scale
    if effect.stage == "actuator":
        return equations.of_torque(j, lambda along: ("motor", on_its_way(true, effect, along, j))) / scale
    if effect.side == "transmission" and true.elastic[j] and not is_loaded(equations, j):
        return equations.of_spring(j, effect) / scale
    with_it = equations.of_joint(j, true, [*true.all_effects, effect])
    return (with_it - equations.own(j)) / scale


def on_its_way(true: FlexibleJointModel, effect: JointEffect, along: SmoothedMotion, j: int) -> Array:
    """What an effect does to a motion's torque on its way to the rotor (samples,)."""
    acting = acting_on(true, j)
    return applied_torque([*acting, effect], true, along, j) - applied_torque(acting, true, along, j)


@kept
def of_parameter(equations: Equations, effect: Effect, name: str, step: float) -> Array:
    """Derivative of the residual (rows,) by a parameter of an effect of the model; the equations keep it.

    Args:
        equations: of the model with the effect.
        effect: the effect.
        name: of the parameter.
        step: of the difference, in the parameter's unit.
    """
    ahead = {name: getattr(effect, name) + step}
    moved = effect.replace(**ahead)
    if moves_links(equations, effect) or effect.makes_elastic or _bends(equations, effect):
        # other rows and positions move with it
        return equations.change([moved if e == effect else e for e in equations.model.effects]) / step
    if isinstance(effect, SensorEffect):
        return of_sensor(equations, effect.replace(**ahead), effect) / step
    if effect.stage == "inertia" or effect.scales_torque:
        return (of_effect(equations, moved) - of_effect(equations, effect)) / step
    true, effect, moved = equations.true, on_joint(effect), on_joint(moved)
    if stands_alone(equations, effect):
        return of_change(equations, effect, moved) / step
    j, effects = true.index(effect.joint), [moved if e == effect else e for e in true.all_effects]
    return (equations.of_joint(j, true, effects) - equations.own(j)) / step


def on_joint(effect: Effect) -> JointEffect:
    """An effect with a torque along the motion.

    Raises:
        InputError: it has none.
    """
    if not isinstance(effect, JointEffect):
        raise InputError("the effect has no torque along a motion", key="effect", value=effect.name)
    return effect
