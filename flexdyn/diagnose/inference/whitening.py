"""Whitening by sensor noise and model error together."""

from __future__ import annotations

from dataclasses import dataclass

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.covariance import Whitener
from flexdyn.diagnose.inference.model_error import ModelError


@dataclass(frozen=True, eq=False)
class Tempered(Whitener):
    """A whitener whose rows then count as a model error lets them.

    Attributes:
        error: the model error.
    """

    error: ModelError

    @classmethod
    def of(cls, sensors: Whitener, error: ModelError) -> Tempered:
        """After a whitening by the sensors' noise."""
        return cls(sensors.factor, sensors.mask, error)

    def __call__(self, rows: Array) -> Array:
        """White rows of unit variance (rows, ...); zero where masked."""
        return self.error.whiten(super().__call__(rows))
