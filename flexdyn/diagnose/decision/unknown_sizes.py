"""First values and prior widths of unknown numbers of effects: only a recording has a scale for them."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.decision.first_laws import first_laws
from flexdyn.diagnose.decision.unknown_laws import Unknown, by_effect, without_unknown
from flexdyn.diagnose.equations.columns import of_effect
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.prepared import recorded_noise
from flexdyn.diagnose.inference.sizes import Sizes
from flexdyn.effects import Effect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.stated_tolerances import known_tolerances
from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE

FIRST_SIZE = 1e-3
"""First value of a size, as a share of its prior's standard deviation [1]; a fit can take it down to a fiftieth."""
TRIAL = 1e-3
"""Size of an effect whose torque is computed, in the unit of its number."""


def with_sizes(model: FlexibleJointModel, data: tuple[Measured, ...]) -> FlexibleJointModel:
    """The model with a first value and a broad prior for every number of an effect that is unknown.

    Of a number in which the torque is linear, the prior's standard deviation s is the size at which the effect would
    make the whole root mean square torque of its joint. The first value is `FIRST_SIZE` times s: nearly nothing. Of
    another number, `first_laws` compares the values that the effect's class tries; s is ten times the largest of them.
    A number of an effect whose shape is unknown begins at the best of them.

    Args:
        model: without other unknown numbers.
        data: of the fit.

    Raises:
        InputError: the effect does nothing along these motions, or they do not tell its numbers.
    """
    unknown = by_effect(model)
    if not unknown:
        return model
    bare = without_unknown(model)
    equations = Equations(bare, data, Filters.of_rate(data[0].dt))
    sizes = Sizes(equations, recorded_noise(data), np.zeros(len(equations.residual), bool))
    shaped = {i: names for i, names in unknown.items() if not set(names) <= set(model.effects[i].linear)}
    effects, tolerance = list(bare.effects), known_tolerances(model.tolerance)

    def begin(i: int, name: str, effect: Effect, value: float, width: float) -> None:
        """Let an effect begin at a value, as uncertain as its width."""
        first = math.copysign(max(abs(value), FIRST_SIZE * width), value)
        effects[i] = effect.replace(**{name: first})
        tolerance[f"effects[{i}].{name}"] = max(width / abs(first), UNKNOWN_TOLERANCE)

    for i in unknown.keys() - shaped.keys():
        for name in unknown[i]:
            begin(i, name, effects[i], 0.0, _largest_size(sizes, effects[i], i, name))
    known = bare.replace(effects=effects, tolerance=tolerance)
    for i, (effect, widths) in first_laws(known, Unknown.of(model, shaped), data).items():
        effects[i] = effect
        for name in unknown[i]:
            width = widths[name] if name in widths else _largest_size(sizes, effect, i, name)
            begin(i, name, effects[i], getattr(effect, name), width)
    return bare.replace(effects=effects, tolerance=tolerance)


def _largest_size(sizes: Sizes, effect: Effect, i: int, name: str) -> float:
    """Size at which an effect alone would make all of its joint's torque, in the unit of its number."""
    alone = effect.replace(**dict.fromkeys(effect.linear, 0.0) | {name: TRIAL})
    share = float(sizes.largest(of_effect(sizes.equations, alone, TRIAL)[None])[0])
    if not 0.0 < share < math.inf:
        remedy = "leave the effect out, or record a motion in which it acts"
        raise InputError("along these motions the effect does nothing", key=f"effects[{i}].{name}", remedy=remedy)
    return 1.0 / share
