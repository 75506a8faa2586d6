"""Open-loop simulation over windows: the gap, and the error of every joint's position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.decision.forces import are_prescribed
from flexdyn.diagnose.decision.model_rows import rms
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.parallel import in_parallel
from flexdyn.diagnose.report.measures import Gap
from flexdyn.diagnose.shooting.gap import Shot, shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel

FIT_WINDOWS = 40
"""Number of windows of the fit data that are simulated, evenly spaced: 20 s give the gap within some percent.
Of the test data all windows are simulated."""


@dataclass(frozen=True, eq=False)
class Shots:
    """Windows simulated by the model as given, calibrated and corrected.

    Attributes:
        before: of the model as given.
        calibrated: of the numbers alone.
        after: of the corrected model.
    """

    before: Shot
    calibrated: Shot
    after: Shot

    @lazy
    def gap(self) -> Gap:
        """Of all windows."""
        return Gap(self.before.gap, self.calibrated.gap, self.after.gap, self.after.floor())

    @property
    def closer(self) -> bool:
        """Whether the corrected model's positions are as near as the given one's, over the usual window.

        The gap cannot be used: its unit is the error that a model expects, and for a sticking joint it expects no
        motion.
        """
        return nearer(self.before.residual, self.after.residual)

    def alone(self) -> Shots:
        """The same where the corrected model is the calibrated one."""
        return replace(self, after=self.calibrated)

    def position(self, joint: str) -> tuple[float, ...]:
        """Error of a joint's measured positions, root mean square, of the three models."""
        return self._rms("residual", joint)

    def scaled(self, joint: str) -> tuple[float, ...]:
        """The same in units of what noise alone makes there [1]."""
        return self._rms("scaled", joint)

    def _rms(self, errors: str, joint: str) -> tuple[float, ...]:
        own = [k for k, name in enumerate(self.after.windows.channels) if name.partition(".")[2] == joint]
        models = (self.before, self.calibrated, self.after)
        return tuple(rms(getattr(shot, errors)[:, :, own][shot.used[:, :, own]]) for shot in models)


def nearer(before: Array, after: Array) -> bool:
    """Whether residuals are not larger than others: every channel's median window, by the channels' geometric mean.

    Args:
        before: of the one model (windows, rows, channels).
        after: of the other.
    """
    sizes = (np.nanmedian(np.sqrt((each**2).mean(axis=1)), axis=0) for each in (before, after))
    one, other = (np.log(np.maximum(each, 1e-300)) for each in sizes)
    return bool((other - one).mean() <= 1e-9)


def windows_of(
    model: FlexibleJointModel, parts: Sequence[DataPart], noise: SampleNoise, most: int | None = None
) -> Windows | None:
    """Windows of what is fitted or tested; None where the data are too short for one, or a motion is prescribed.

    Args:
        model: as given.
        parts: spans of recordings.
        noise: of the channels.
        most: number of windows; None: as many as there are.
    """
    if are_prescribed(parts):
        return None
    try:
        since = [float(each.data.t[0]) for each in parts]
        cut = Windows.of(model, [each.recording for each in parts], noise, since=since)
    except InputError:
        return None
    return cut if most is None else cut.thinned(most)


def shots(models: Sequence[FlexibleJointModel], windows: Windows) -> list[Shot]:
    """The windows under each model; of equal ones, once."""
    different = list(dict.fromkeys(models))
    made = dict(zip(different, in_parallel(lambda model: shoot(model, windows), different), strict=True))
    return [made[model] for model in models]
