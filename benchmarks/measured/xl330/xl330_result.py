"""What the XL330 study gives: the diagnosis, and errors of models simulated from the goal alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from xl330_data import Array, Log

import flexdyn as fd

WITHOUT = ("stribeck_gear_loss", "directional_gear_loss", "torque_saturation", "stribeck_friction", "coulomb_friction")
"""Effects that are left out of the fitted model one by one, the other numbers as they are."""
TOLD = (100, 400)
"""Gains that the second fit sees."""


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnosis: of the plain servo.
        unknown: of the same with numbers of the gear unknown instead of guessed, by the words for these.
        logs: all eight.
        fitted: the model fitted to all.
        errors: mean absolute errors (logs,) [rad] by model.
        simulated: positions of the fitted model by log [rad].
        evaluation_seconds: processor time of one evaluation of a search, all logs simulated once [s].
    """

    diagnosis: fd.Diagnosis
    unknown: Mapping[str, fd.Diagnosis]
    logs: Sequence[Log]
    fitted: fd.FlexibleJointModel
    errors: Mapping[str, Array]
    simulated: Sequence[Array]
    evaluation_seconds: float

    def mean(self, model: str) -> float:
        """Over the logs [rad]."""
        return float(self.errors[model].mean())

    def unseen(self) -> float:
        """Of the fit to two gains, on the other two [rad]."""
        apart = np.array([log.gain not in TOLD for log in self.logs])
        return float(self.errors["fitted to gains 100 and 400"][apart].mean())
