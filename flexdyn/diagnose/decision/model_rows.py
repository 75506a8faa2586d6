"""The equations over data, as a rule the test data, by the model as given, calibrated and corrected."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.covariance import SampleNoise, Whitener, whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import LINK, MOTOR, TOTAL
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import between_counts, recorded_noise
from flexdyn.diagnose.inference.weights import quieter
from flexdyn.errors import InputError
from flexdyn.records.signals.decimate import CLOCK_JITTER

Models = tuple[Equations, Equations, Equations]


@dataclass(frozen=True, eq=False)
class ModelRows:
    """Rows of the equations by the model as given, calibrated and corrected.

    Attributes:
        models: equations of the three models over the same data.
        noise: of the channels.
        whiten: by that noise.
    """

    models: Models
    noise: SampleNoise
    whiten: Whitener

    @property
    def given(self) -> Equations:
        """Equations of the model as given."""
        return self.models[0]

    @property
    def after(self) -> Equations:
        """Equations of the corrected model."""
        return self.models[2]

    @property
    def seen(self) -> Flags:
        """Rows that are not masked (rows of an equation, equations)."""
        return ~self.whiten.mask.reshape(-1, len(self.after.kinds))

    @property
    def variance(self) -> Array:
        """Variance of the rows from noise (rows of an equation, equations)."""
        return np.asarray((self.whiten.factor**2).sum(axis=1).reshape(self.seen.shape))

    def white(self, at: Equations) -> Array:
        """White rows of a model (rows of an equation, equations)."""
        return self.whiten(at.residual).reshape(self.seen.shape)

    def size(self, at: Equations) -> float:
        """Root mean square of a model's white rows that are not masked [1]."""
        return rms(self.white(at)[self.seen])

    def of_hypothesis(self, hypothesis: Hypothesis) -> Equations:
        """Equations of another model over the same data."""
        return self.given.of(hypothesis.seen())

    def torque(self, j: int) -> tuple[list[Array], Array]:
        """Torque that the inverse dynamics of each model do not explain, and the recorded one (rows,).

        Of an elastic joint with both encoders it is the sum of the motor's equation and the link's: the spring's torque
        stands in both and drops out. Masked rows are left out.
        """
        left = [summed(each, j) for each in self.models]
        clear = self.seen[:, left[0][1]].all(axis=1)
        return [off[clear] for off, _ in left], self.after.at_rows("tau")[clear, j]


def summed(at: Equations, j: int) -> tuple[Array, list[int]]:
    """Torque of a joint that its equations leave (rows,), recorded less needed, and which equations these are."""
    own = at.places(j, MOTOR, LINK, TOTAL)
    rows = at.residual.reshape(-1, len(at.kinds))
    units = {LINK: at.softness[j] / at.gains[j]}
    return np.asarray(sum(rows[:, k] * units.get(at.kinds[k][1], 1.0) for k in own)), own


def rows_of_models(
    equations: Equations, calibrated: Hypothesis, corrected: Hypothesis, data: tuple[Measured, ...]
) -> ModelRows:
    """Rows of the test data.

    Args:
        equations: of the model as given over the data of the fit, whose filters are taken.
        calibrated: the model with the file's numbers alone.
        corrected: the corrected model.
        data: the test data.

    Raises:
        InputError: they are shorter than the filters.
    """
    given = dataclasses.replace(equations, data=between_counts(data), filters=_filters(equations, data[0].dt))
    if not given.residual.size:
        samples = max(len(each.t) for each in data)
        remedy = "keep more apart (check, hold_out), or record faster"
        raise InputError("the test data are shorter than the filters", key="check", value=f"{samples} samples at"
                         f" {1.0 / data[0].dt:.4g} Hz", remedy=remedy)  # fmt: skip
    between, after = (given.of(each.seen()) for each in (calibrated, corrected))
    recorded = recorded_noise(data)
    mask = _mask(given, after, recorded)
    noise = quieter(recorded, after, mask)
    return ModelRows((given, between, after), noise, whitener(after, noise, mask))


def _mask(given: Equations, after: Equations, noise: SampleNoise) -> Flags:
    """Rows that are masked by the given or by the corrected model (rows,).

    Where a corrected model's made-up positions would hide all rows of an equation, its own joint's standstill decides.
    """
    many = len(after.kinds)
    mask = (sign_mask(given, noise) | sign_mask(after, noise)).reshape(-1, many)
    own = (sign_mask(given, noise, alone=True) | sign_mask(after, noise, alone=True)).reshape(-1, many)
    return np.where(mask.all(axis=0), own, mask).ravel()


def _filters(equations: Equations, dt: float) -> Filters:
    """Filters of the fit; at another rate, filters of the same width."""
    own = equations.data[0].dt
    if abs(dt - own) <= CLOCK_JITTER * own:
        return equations.filters
    taps = equations.filters.second.taps[0]
    offset = np.arange(len(taps)) - 0.5 * (len(taps) - 1)
    return Filters.of_rate(dt, second=own * float(np.sqrt((taps * offset**2).sum() / taps.sum())))


def rms(x: Array) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt((x**2).mean())) if x.size else float("nan")
