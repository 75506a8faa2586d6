"""First values and prior widths of unknown sizes of effects: only a recording has a scale for them."""

from __future__ import annotations

import math

import numpy as np

from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.columns import of_effect
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.workspace import recorded_noise
from flexdyn.diagnose.inference.sizes import Sizes
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.stated_tolerances import known_tolerances, unknown_parameters

FIRST_SIZE = 1e-3
"""First value of a size, as a share of its prior's standard deviation [1]; a fit can take it down to a fiftieth."""
TRIAL = 1e-3
"""Size of an effect whose torque is computed, in the unit of its number."""


def with_sizes(model: FlexibleJointModel, data: tuple[Measured, ...]) -> FlexibleJointModel:
    """The model with a first value and a broad prior for every size of an effect that is unknown.

    The prior's standard deviation s is the size at which the effect would make the whole root mean square torque of its
    joint. The first value is `FIRST_SIZE` times s: nearly nothing.

    Args:
        model: without other unknown numbers.
        data: of the fit.

    Raises:
        InputError: the effect does nothing along these motions.
    """
    unknown = unknown_parameters(model.tolerance, model.effects)
    if not unknown:
        return model
    tolerance = known_tolerances(model.tolerance)
    without = model.replace(tolerance=tolerance)
    equations = Equations(without, data, Filters.of_rate(data[0].dt))
    sizes = Sizes(equations, recorded_noise(data), np.zeros(len(equations.residual), bool))
    effects = list(model.effects)
    for i, name in unknown:
        alone = model.effects[i].replace(**dict.fromkeys(model.effects[i].linear, 0.0) | {name: TRIAL})
        largest = float(sizes.largest(of_effect(equations, alone, TRIAL)[None])[0])
        if not 0.0 < largest < math.inf:
            remedy = "leave the effect out, or record a motion in which it acts"
            raise InputError("along these motions the effect does nothing", key=f"effects[{i}].{name}", remedy=remedy)
        effects[i] = effects[i].replace(**{name: FIRST_SIZE / largest})
        tolerance[f"effects[{i}].{name}"] = 1.0 / FIRST_SIZE
    return without.replace(effects=effects, tolerance=tolerance)
