"""The parameters of effects: their fields with unit and bounds, the check of a value, grids of values."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from flexdyn.checks import as_number
from flexdyn.errors import InputError
from flexdyn.records.units import unit_for

USUAL_SIZES = {"N m": 1.0, "N m s/rad": 0.5, "N m/rad": 100.0, "rad": 0.01, "rad/s": 0.5, "s": 0.01}
"""Unit -> a typical value in it, with which the documentation shows an effect."""


def parameter(
    unit: str,
    *,
    lower: float = -math.inf,
    strict: bool = False,
    infinite: bool = False,
    chosen: bool = False,
    by_factor: bool = False,
    around: bool = False,
    prismatic_unit: str | None = None,
    step: float | None = None,
    step_at_zero: float = 1e-4,
    default: Any = dataclasses.MISSING,
) -> Any:
    """A parameter of an effect.

    Args:
        unit: for a revolute joint; for a prismatic one N m becomes N and rad becomes m, except in a phase (`around`).
        lower: lower bound.
        strict: whether the value must be above `lower`, not equal to it.
        infinite: whether the value may be infinite; a neutral value always may.
        chosen: whether a diagnosis chooses it from a few values and does not estimate it.
        by_factor: whether a fit changes it by a limited factor in each step, because the law is another one at 0; of a
            `strict` parameter it always does.
        around: whether it is an angle in a cycle, so that a diagnosis tries values all around.
        prismatic_unit: for a prismatic joint, where it is another one than `unit` says.
        step: change at which a diagnosis computes its slope, in `unit`; None: a hundredth of its value.
        step_at_zero: likewise where its value is 0, unless `step` is given.
        default: value if none is given; without a default a value is required.

    Example:
        >>> class Magnet(fd.effects.JointEffect):
        ...     sides, stage = ("link",), "link"
        ...     stiffness: float = fd.effects.parameter("N m/rad", lower=0.0)
        ...     def torque(self, x, u, *, t=0.0, tau=0.0):
        ...         return -self.stiffness * np.asarray(x)
        >>> Magnet("elbow", stiffness=4.0).torque(0.5, 0.0)
        np.float64(-2.0)
    """
    metadata = {"unit": unit, "lower": lower, "strict": strict, "infinite": infinite}
    metadata |= {"chosen": chosen, "by_factor": by_factor or strict, "around": around}
    metadata |= {"step": step, "step_at_zero": step_at_zero}
    metadata["prismatic_unit"] = prismatic_unit or (unit if around else unit_for(unit, prismatic=True))
    return dataclasses.field(default=default, metadata=metadata)


def spaced(first: float, last: float, count: int) -> tuple[float, ...]:
    """A geometric grid from the first to the last value."""
    return tuple(float(value) for value in np.geomspace(first, last, count))


def checked_number(effect: str, field: dataclasses.Field[Any], value: Any, neutral: float) -> float:
    """A parameter's value as a number.

    Args:
        effect: name of the effect, for messages.
        field: the parameter, made by `parameter`.
        value: as the user gave it.
        neutral: its neutral value, which may be infinite; NaN: it has none.

    Raises:
        InputError: it is no number, or outside its bounds.
    """
    place = f"{effect}.{field.name}"
    unit, lower, strict, infinite = (field.metadata[key] for key in ("unit", "lower", "strict", "infinite"))
    number = as_number(value)
    if math.isnan(number):
        raise InputError("a number is needed", key=place, value=value, remedy=f"give it in {unit}")
    if math.isinf(number) and not infinite and number != neutral:
        raise InputError("it must be finite", key=place, value=number)
    if number < lower or (strict and number == lower):
        bound = f"above {lower:g}" if strict else f"at least {lower:g}"
        raise InputError(f"it must be {bound} [{unit}]", key=place, value=number)
    return number
