"""A number of the model itself that is wrong."""

from __future__ import annotations

import dataclasses
import re
from typing import Any, TypeGuard

from flexdyn.effects import parameters
from flexdyn.effects.base import Effect
from flexdyn.errors import InputError


class ParameterError(Effect):
    """A number of the model file or of the URDF is wrong: ``true = factor given``.

    The numbers are: of a joint ``gear_ratio``, ``rotor_inertia``, ``stiffness``, ``damping``, and ``urdf_damping`` and
    ``urdf_friction`` of the URDF's <dynamics>; of a joint with a DC motor also ``torque_constant`` and ``resistance``;
    of a link ``link_mass``, ``link_com`` (the whole position of the centre of mass in the link's frame) and
    ``link_inertia`` (the whole inertia about the centre of mass); of another effect any parameter. The factors of
    several errors of one number multiply.

    Args:
        of: name of the joint or link, or ``effects[i]``, counting the model's own effects from 0.
        parameter: name of the number.
        factor: above 0; below it only for a number of an effect that may have either sign [1].
    """

    stage = "model"
    law = "true = factor*given"
    neutral = {"factor": 1.0}
    no_torque = "it changes a number of the model: see model.resolved()"
    shown = {"factor": 1.3}

    of: str = dataclasses.field(kw_only=False)
    parameter: str
    factor: float = parameters.parameter("1")

    def __post_init__(self) -> None:
        """Check the factor, and that the names are names."""
        super().__post_init__()
        for key in ("of", "parameter"):
            value = getattr(self, key)
            if not isinstance(value, str) or not value:
                raise InputError("a name is needed", key=f"{self.name}.{key}", value=value)
        if self.factor == 0.0 or (self.factor < 0.0 and effect_place(self.of) is None):
            raise InputError("it must be above 0 [1]", key=f"{self.name}.factor", value=self.factor)

    @classmethod
    def _example_place(cls, joint: str, other: str) -> dict[str, Any]:
        return {"of": joint, "parameter": "rotor_inertia"}


def is_number_error(effect: Effect) -> TypeGuard[ParameterError]:
    """Whether an effect says that a number of the model is wrong."""
    return effect.stage == "model"


def effect_place(of: str) -> int | None:
    """The index i of ``effects[i]``; None if `of` names a joint or link."""
    match = re.fullmatch(r"effects\[(\d{1,6})\]", of)
    return int(match[1]) if match else None
