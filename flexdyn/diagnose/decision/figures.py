"""Figures of the model as given, calibrated and corrected: on the data of the fit, and on the test data."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.forces import Forces, are_prescribed, errors_of, recorded_force
from flexdyn.diagnose.decision.gains import gains, shares_of_gap
from flexdyn.diagnose.decision.gaps import FIT_WINDOWS, Shots, shots, windows_of
from flexdyn.diagnose.decision.model_rows import ModelRows, rms, rows_of_models
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.decision.verdict import dependence, left_by_joint
from flexdyn.diagnose.equations.localise import localise
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.report.measures import Gap, JointError, Left, ResidualPlace, Shares, SignalError


@dataclass(frozen=True, eq=False)
class OnData:
    """Figures of the model as given, calibrated and corrected on some data.

    Attributes:
        parts: the data.
        rows: of the equations of the three models.
        off: simulated windows; forces where a rig prescribes the motion; None: the data are too short for a window.
    """

    parts: Sequence[DataPart]
    rows: ModelRows
    off: Shots | Forces | None

    @property
    def shots(self) -> Shots | None:
        """Simulated windows, if there are any."""
        return self.off if isinstance(self.off, Shots) else None

    @property
    def gap(self) -> Gap | None:
        """Of the windows, or of the forces."""
        return None if self.off is None else self.off.gap


@dataclass(frozen=True, eq=False)
class OnFit(OnData):
    """On the data of the fit.

    Attributes:
        calibrated: the model with the file's numbers alone.
        made: its fit, maybe of other numbers: those as given may be nearer.
        where: the residual of the calibrated model appears.
        left: where that of the corrected model appears.
        stalled: a fit whose names are withheld, as it stopped short and is farther off than the start; None: there is
            none.
    """

    calibrated: Hypothesis
    made: Fit
    where: tuple[ResidualPlace, ...]
    left: tuple[ResidualPlace, ...]
    stalled: Fit | None = None

    @property
    def worse(self) -> bool:
        """Whether the corrected model's simulated positions or forces are farther off than the given one's."""
        return self.off is not None and not self.off.closer

    @property
    def farther(self) -> bool:
        """Whether the corrected model is farther off than the numbers alone, in forces, or in all windows but a few.

        Noise decides when a joint sticks: a single window of a right model may be far more off than all others.
        """
        if self.shots is not None:
            return self.shots.after.left > self.shots.calibrated.left
        return self.gap is not None and self.gap.after > self.gap.calibrated

    def calibration_alone(self, found: Corrected) -> tuple[Corrected, OnFit]:
        """The same where nothing is named: the corrected model is the calibrated one."""
        made = dataclasses.replace(self.made, hypothesis=self.calibrated)
        given, between, _ = self.rows.models
        rows = dataclasses.replace(self.rows, models=(given, between, between))
        off = None if self.off is None else self.off.alone()
        alone = dataclasses.replace(self, rows=rows, off=off, left=self.where)
        return dataclasses.replace(found, fitted=made, names=()), alone


def on_fit(plain: Workspace, made: Fit, found: Corrected, parts: Sequence[DataPart]) -> OnFit:
    """Figures on the data of the fit.

    Args:
        plain: the equations of the model as given, with the sensors' weights.
        made: the fit of the file's numbers alone; as given they may be nearer over windows.
        found: the corrected model.
        parts: of the recordings.
    """
    tolerated = made.hypothesis
    either = (dataclasses.replace(tolerated, factors=dict.fromkeys(tolerated.factors, 1.0), counts=()), tolerated)
    at, after = plain.equations, plain.equations.of(found.hypothesis.seen())
    windows = windows_of(tolerated.given, parts, plain.noise, FIT_WINDOWS)
    nearer, off = 1, None
    if windows is not None:
        models = [tolerated.given, *(each.seen() for each in (*either, found.hypothesis))]
        first, *between, last = shots(models, windows)
        nearer = int(between[1].gap <= between[0].gap)
        off = Shots(first, between[nearer], last)
    elif are_prescribed(parts):
        errors = errors_of([at.of(each.seen()) for each in either])
        nearer = int(errors[1] <= errors[0])
    rows = ModelRows((at, at.of(either[nearer].seen()), after), plain.noise, plain.whiten)
    # Where a residual is more than noise, apart from offsets of the encoders.
    where, left = (localise(each, plain.white(each.residual), plain.whiten.mask) for each in rows.models[1:])
    forces = Forces.of(rows) if are_prescribed(parts) else off
    return OnFit(parts, rows, forces, either[nearer], made, where, left)


@dataclass(frozen=True, eq=False)
class OnTest(OnData):
    """On the test data, opened once.

    Attributes:
        errors: by joint.
        left: what the corrected model leaves.
        gains: share of the gap that each named candidate removes.
        shares: of the gap, which add up; None: all rows are masked.
    """

    errors: dict[str, JointError]
    left: tuple[Left, ...]
    gains: dict[int, float]
    shares: Shares | None


def on_test(
    plain: Workspace, first: OnFit, found: Corrected, named: Sequence[Name], parts: Sequence[DataPart]
) -> OnTest:
    """Figures on the test data.

    Args:
        plain: the equations of the model as given over the data of the fit.
        first: figures on these.
        found: the corrected model.
        named: the names that are reported.
        parts: the test data.
    """
    here, calibrated = found.hypothesis, first.calibrated
    rows = rows_of_models(plain.equations, calibrated, here, tuple(each.data for each in parts))
    windows = windows_of(here.given, parts, rows.noise)
    over = None if windows is None else Shots(*shots([here.given, calibrated.seen(), here.seen()], windows))
    off = Forces.of(rows) if are_prescribed(parts) else over
    gone = gains(rows, found, named)
    remaining = left_by_joint(rows, dependence(first.left))
    return OnTest(parts, rows, off, _errors(rows, over), remaining, gone, shares_of_gap(rows, found, named, gone))


def _errors(rows: ModelRows, over: Shots | None) -> dict[str, JointError]:
    """Errors of torques and positions of every joint."""
    found, robot = {}, rows.given.true.robot
    for j, joint in enumerate(rows.given.true.joint_names):
        off, recorded_torque = rows.torque(j)
        unit = robot.torque_unit(joint)
        torque = _errors_of_signal([rms(each) for each in off], unit, max(rms(recorded_torque), 1e-12))
        position = _errors_of_signal([math.nan] * 3 if over is None else over.position(joint), robot.angle_unit(joint))
        force = None
        if rows.given.data[0].forced[j]:
            force = _errors_of_signal(errors_of(rows.models, j), unit, recorded_force(rows.given, j))
        found[joint] = JointError(torque, position, () if over is None else over.scaled(joint), force)
    return found


def _errors_of_signal(off: Sequence[float], unit: str, size: float = 0.0) -> SignalError:
    """Errors by the model as given, calibrated and corrected."""
    before, calibrated, after = off
    return SignalError(before, after, unit, calibrated, size)
