"""Figures of a diagnosis: gaps, errors in physical units, the unexplained rest, calibrated numbers, the last fit."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE


@dataclass(frozen=True)
class Calibration:
    """A number of the model file that moved within its tolerance: true = factor times given.

    Attributes:
        of: joint, link or ``effects[i]`` that it belongs to.
        parameter: its name.
        factor: [1].
        std: standard deviation of the factor [1].
        tolerance: of the model file, relative, one sigma [1].
    """

    of: str
    parameter: str
    factor: float
    std: float
    tolerance: float

    @property
    def is_open(self) -> bool:
        """Whether it was not known, see `FileNumber.is_open`."""
        return self.tolerance >= UNKNOWN_TOLERANCE

    @property
    def displacement(self) -> float:
        """How far it moved, in tolerances, or as a share of a number that has none; 0 if that is unknown [1]."""
        size = abs(self.factor - 1.0) / (self.tolerance if self.tolerance > 0.0 else 1.0)
        return size if math.isfinite(size) else 0.0


@dataclass(frozen=True)
class Gap:
    """Errors of simulated positions over windows of 0.5 s, divided by the values that noise alone would give.

    Attributes:
        before: of the given model [1].
        calibrated: with numbers changed within their tolerance [1].
        after: with the findings added [1].
        floor: of a perfect model: about 1.
    """

    before: float
    calibrated: float
    after: float
    floor: float


@dataclass(frozen=True)
class ResidualPlace:
    """Where the residual appears.

    Attributes:
        joint: of the equation.
        side: link, motor, transmission, sensor or total.
        share: of the excess over noise [1].
        regime: in which it is largest, in words; empty: everywhere.
    """

    joint: str
    side: str
    share: float
    regime: str


@dataclass(frozen=True)
class SignalError:
    """Root mean square error of a signal on the test data by three models.

    Attributes:
        before: of the given model, in `unit`.
        after: of the corrected model.
        unit: ``N m`` or ``N``, ``rad`` or ``m``.
        calibrated: of the calibrated model.
        size: root mean square of the recorded signal itself, in `unit`; 0 if no share is reported.
    """

    before: float
    after: float
    unit: str
    calibrated: float = math.nan
    size: float = 0.0

    @property
    def share_before(self) -> float:
        """Error of the given model over the size of the signal [1]."""
        return self.before / self.size if self.size else math.nan

    @property
    def share_after(self) -> float:
        """The same of the corrected model [1]."""
        return self.after / self.size if self.size else math.nan


@dataclass(frozen=True)
class JointError:
    """Errors of one joint on the test data.

    Attributes:
        torque: that the inverse dynamics of a model does not explain.
        position: simulated over windows of 0.5 s, open loop.
        gap: the same positions in units of what noise alone makes there, as the gap has them: of the model as given,
            calibrated and corrected [1]; empty where nothing was simulated.
        force: simulated where a test rig prescribes the motion; None elsewhere.
    """

    torque: SignalError
    position: SignalError
    gap: tuple[float, ...] = ()
    force: SignalError | None = None


@dataclass(frozen=True)
class Left:
    """The residual torque of the corrected model at a joint, beyond noise.

    Attributes:
        joint: of the equation.
        share_of_torque: its root mean square over that of the torque [1].
        correlation_time: time over which it is correlated [s].
        depends_on: quantities on which it depends (``q``, ``omega``, ``t``), the strongest first; empty if none is
            found.
    """

    joint: str
    share_of_torque: float
    correlation_time: float
    depends_on: tuple[str, ...] = ()


@dataclass(frozen=True)
class Statistics:
    """How well the final fit of the corrected model is determined; names and formulas as lmfit has them.

    Attributes:
        method: of the fit.
        points: rows of the equations that are not masked.
        variables: numbers that were fitted, offsets of the encoders included.
        chi_square: sum of squares of the weighted rows.
        reduced: chi-square over points less variables; 1 where weights are right and nothing is left.
        aic: Akaike's criterion, ``points*log(chi_square/points) + 2*variables``.
        bic: Bayesian criterion, ``points*log(chi_square/points) + log(points)*variables``.
        correlations: pairs of numbers and their correlation, the strongest first; those below 0.1 are left out.
    """

    method: str
    points: int
    variables: int
    chi_square: float
    reduced: float
    aic: float
    bic: float
    correlations: tuple[tuple[str, str, float], ...] = ()


@dataclass(frozen=True)
class Shares:
    """Shares of the gap on the test data that add up to 1: models are made better one step after the other.

    The gap is here the sum of squares of the residuals of the equations of the model as given, in units of noise.

    Attributes:
        calibration: removed by changing the file's numbers to those of the corrected model [1].
        findings: removed by each finding when it is added to those before it, in their order [1].
        left: not removed by the corrected model [1].
        noise: share of noise alone, a part of `left` if the model is right [1].
    """

    calibration: float
    findings: tuple[float, ...]
    left: float
    noise: float
