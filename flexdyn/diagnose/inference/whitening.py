"""Whitening by sensor noise and model error together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.covariance import Whitener
from flexdyn.diagnose.inference.discrepancy import Discrepancy

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Coloured(Whitener):
    """A whitener whose rows are then those of a model error.

    Attributes:
        error: the model error.
    """

    error: Discrepancy

    @classmethod
    def of(cls, sensors: Whitener, error: Discrepancy) -> Coloured:
        """After a whitening by the sensors' noise."""
        return cls(sensors.factor, sensors.mask, error)

    def __call__(self, rows: Array) -> Array:
        """White rows of unit variance (rows, ...); zero where masked."""
        return self.colour(super().__call__(rows))

    def colour(self, white: Array) -> Array:
        """The same of rows that are white but for the model error."""
        table = white.reshape(len(white), -1)
        return np.asarray(self.error.innovations(table)).reshape(white.shape)
