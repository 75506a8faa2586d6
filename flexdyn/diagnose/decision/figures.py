"""Figures of the model as given, calibrated and corrected: on the data of the fit, and on the test data."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.gains import gains, shares
from flexdyn.diagnose.decision.gaps import FIT_WINDOWS, Shots, shots, windows_of
from flexdyn.diagnose.decision.held_out import HeldOut, held_out, rms
from flexdyn.diagnose.decision.left import dependence, left
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.localise import localise
from flexdyn.diagnose.hypothesis.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.report.measures import Gap, JointError, Left, ResidualPlace
from flexdyn.diagnose.report.record import Shares

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OnFit:
    """On the data of the fit.

    Attributes:
        calibrated: the model with the file's numbers alone.
        made: its fit, maybe of other numbers: those as given may be nearer.
        after: equations of the corrected model.
        shots: windows; None: the data are too short for one.
        where: the residual of the calibrated model appears.
        left: where that of the corrected model appears.
        stalled: a fit whose names are withheld, as it stopped short and is farther off than the start; None: there is
            none.
    """

    calibrated: Hypothesis
    made: Fit
    after: Equations
    shots: Shots | None
    where: tuple[ResidualPlace, ...]
    left: tuple[ResidualPlace, ...]
    stalled: Fit | None = None

    @property
    def gap(self) -> Gap | None:
        """Of the windows."""
        return None if self.shots is None else self.shots.gap

    @property
    def worse(self) -> bool:
        """Whether the corrected model's simulated positions are farther off than the given one's."""
        return self.shots is not None and not self.shots.closer

    @property
    def farther(self) -> bool:
        """Whether the corrected model's gap is more than that of the numbers alone."""
        return self.gap is not None and self.gap.after > self.gap.calibrated

    def calibration_alone(self, found: Corrected) -> tuple[Corrected, OnFit]:
        """The same where nothing is named: the corrected model is the calibrated one."""
        at = self.after.of(self.calibrated.seen())
        made = dataclasses.replace(self.made, hypothesis=self.calibrated)
        over = self.shots and dataclasses.replace(self.shots, after=self.shots.calibrated)
        alone = dataclasses.replace(self, after=at, shots=over, left=self.where)
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
    given = dataclasses.replace(tolerated, factors=dict.fromkeys(tolerated.factors, 1.0), counts=())
    windows = windows_of(tolerated.given, parts, plain.noise, FIT_WINDOWS)
    over, calibrated = None, tolerated
    if windows is not None:
        models = [tolerated.given, given.seen(), tolerated.seen(), found.hypothesis.seen()]
        before, *either, after = shots(models, windows)
        nearer = int(either[1].gap <= either[0].gap)
        over, calibrated = Shots(before, either[nearer], after), (given, tolerated)[nearer]
    at = plain.equations.of(found.hypothesis.seen())
    places = [_places(plain, each) for each in (plain.equations.of(calibrated.seen()), at)]
    return OnFit(calibrated, made, at, over, places[0], places[1])


def _places(plain: Workspace, at: Equations) -> tuple[ResidualPlace, ...]:
    """Where a model's residual is more than noise; offsets of the encoders are allowed for."""
    found = localise(at, plain.white(at.residual), plain.whiten.mask)
    return tuple(ResidualPlace(each.joint, each.side, each.share, each.regime) for each in found)


@dataclass(frozen=True, eq=False)
class OnTest:
    """On the test data, opened once.

    Attributes:
        rows: of the equations.
        shots: windows; None: the data are too short for one.
        errors: by joint.
        left: what the corrected model leaves.
        gains: share of the gap that goes with each named candidate.
        shares: of the gap, which add up; None: no row says anything.
    """

    rows: HeldOut
    shots: Shots | None
    errors: dict[str, JointError]
    left: tuple[Left, ...]
    gains: dict[int, float]
    shares: Shares | None

    @property
    def gap(self) -> Gap | None:
        """Of the windows."""
        return None if self.shots is None else self.shots.gap


def on_test(
    plain: Workspace, first: OnFit, found: Corrected, named: Sequence[Name], parts: Sequence[DataPart]
) -> OnTest:
    """Figures on the test data.

    Args:
        plain: the equations of the model as given over the data of the fit.
        first: figures on these.
        found: the corrected model.
        named: what is told.
        parts: the test data.
    """
    here = found.hypothesis
    rows = held_out(plain.equations, here, tuple(each.data for each in parts))
    windows = windows_of(here.given, parts, rows.noise)
    over = None
    if windows is not None:
        over = Shots(*shots([here.given, first.calibrated.seen(), here.seen()], windows))
    depends_on = dependence(first.left)
    gone = gains(rows, first.calibrated, found, named)
    parted = shares(rows, found, named, gone)
    return OnTest(rows, over, _errors(rows, over, first.calibrated), left(rows, depends_on), gone, parted)


def _errors(rows: HeldOut, over: Shots | None, calibrated: Hypothesis) -> dict[str, JointError]:
    """Errors of torques and positions of every joint."""
    found, robot = {}, rows.given.true.robot
    between = dataclasses.replace(rows, after=rows.given.of(calibrated.seen()))
    for j, joint in enumerate(rows.given.true.joint_names):
        before, after, recorded = (rms(x) for x in rows.torque(j))
        size = max(recorded, 1e-12)
        apart = (float("nan"),) * 3 if over is None else over.position(joint)
        found[joint] = JointError(
            before,
            after,
            robot.torque_unit(joint),
            before / size,
            after / size,
            apart[0],
            apart[2],
            robot.angle_unit(joint),
            rms(between.torque(j)[1]),
            apart[1],
            () if over is None else over.scaled(joint),
        )
    return found
