"""Figures of a diagnosis: gaps, errors in physical units, the unexplained rest, calibrated numbers, the data used."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE

Role = Literal["fit", "test"]


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
        size: root mean square of the recorded signal itself, in `unit`; 0 where no share of it is told.
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
class RecordingSpan:
    """A span of a recording and what it was used for.

    Attributes:
        file: name of the recording.
        role: ``fit`` (estimates and cross-validation) or ``test`` (the verdict alone).
        start: of the span, in the recording's own time [s].
        end: of the span [s].
        rate: samples per second [Hz].
        noise: standard deviation of the sensor's noise by channel, in the channel's unit.
        samples: number of samples.
        channels: of the recording, also those that the diagnosis does not use.
    """

    file: str
    role: Role
    start: float
    end: float
    rate: float
    noise: Mapping[str, float] = field(default_factory=dict)
    samples: int = 0
    channels: tuple[str, ...] = ()
