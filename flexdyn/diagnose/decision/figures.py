"""Figures of the model as given, calibrated and corrected: on the data of the fit, and on the test data."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.diagnose.decision.corrected import Corrected
from flexdyn.diagnose.decision.forces import Forces, are_prescribed, errors_of, recorded
from flexdyn.diagnose.decision.gains import gains, shares
from flexdyn.diagnose.decision.gaps import FIT_WINDOWS, Shots, shots, windows_of
from flexdyn.diagnose.decision.held_out import HeldOut, held_out, rms
from flexdyn.diagnose.decision.naming import Name
from flexdyn.diagnose.decision.split import DataPart
from flexdyn.diagnose.decision.verdict import dependence, left
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.localise import localise
from flexdyn.diagnose.hypothesis.fitted import Fit, Workspace
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.report.measures import Gap, JointError, Left, ResidualPlace, SignalError
from flexdyn.diagnose.report.record import Shares

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OnFit:
    """On the data of the fit.

    Attributes:
        calibrated: the model with the file's numbers alone.
        made: its fit, maybe of other numbers: those as given may be nearer.
        after: equations of the corrected model.
        shots: windows; None: the data are too short for one, or a rig prescribes the motion.
        forces: where it does; None elsewhere.
        where: the residual of the calibrated model appears.
        left: where that of the corrected model appears.
        stalled: a fit whose names are withheld, as it stopped short and is farther off than the start; None: there is
            none.
    """

    calibrated: Hypothesis
    made: Fit
    after: Equations
    shots: Shots | None
    forces: Forces | None
    where: tuple[ResidualPlace, ...]
    left: tuple[ResidualPlace, ...]
    stalled: Fit | None = None

    @property
    def gap(self) -> Gap | None:
        """Of the windows, or of the forces."""
        over = self.shots or self.forces
        return None if over is None else over.gap

    @property
    def worse(self) -> bool:
        """Whether the corrected model's simulated positions or forces are farther off than the given one's."""
        over = self.shots or self.forces
        return over is not None and not over.closer

    @property
    def farther(self) -> bool:
        """Whether the corrected model's gap is more than that of the numbers alone."""
        return self.gap is not None and self.gap.after > self.gap.calibrated

    def calibration_alone(self, found: Corrected) -> tuple[Corrected, OnFit]:
        """The same where nothing is named: the corrected model is the calibrated one."""
        at = self.after.of(self.calibrated.seen())
        made = dataclasses.replace(self.made, hypothesis=self.calibrated)
        over = self.shots and dataclasses.replace(self.shots, after=self.shots.calibrated)
        forces = self.forces and self.forces.alone()
        alone = dataclasses.replace(self, after=at, shots=over, forces=forces, left=self.where)
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
    forces = None
    if are_prescribed(parts):
        between = [plain.equations.of(each.seen()) for each in (given, tolerated)]
        forces, calibrated = _forces(plain, [plain.equations, *between, at], (given, tolerated))
    places = [_places(plain, each) for each in (plain.equations.of(calibrated.seen()), at)]
    return OnFit(calibrated, made, at, over, forces, places[0], places[1])


def _forces(
    plain: Workspace, models: Sequence[Equations], either: tuple[Hypothesis, Hypothesis]
) -> tuple[Forces, Hypothesis]:
    """Of the model as given, the nearer one of two calibrations and the corrected one; and that calibration."""
    seen = ~plain.whiten.mask
    white = [plain.white(at.residual)[: len(seen)][seen] for at in models]
    errors = errors_of(models)
    nearer = int(errors[2] <= errors[1])
    kept = (0, 1 + nearer, 3)
    rows = [white[k] for k in kept]
    return Forces(rows[0], rows[1], rows[2], (errors[0], errors[kept[1]], errors[3])), either[nearer]


def _places(plain: Workspace, at: Equations) -> tuple[ResidualPlace, ...]:
    """Where a model's residual is more than noise; offsets of the encoders are allowed for."""
    found = localise(at, plain.white(at.residual), plain.whiten.mask)
    return tuple(ResidualPlace(each.joint, each.side, each.share, each.regime) for each in found)


@dataclass(frozen=True, eq=False)
class OnTest:
    """On the test data, opened once.

    Attributes:
        rows: of the equations.
        shots: windows; None: the data are too short for one, or a rig prescribes the motion.
        forces: where it does; None elsewhere.
        errors: by joint.
        left: what the corrected model leaves.
        gains: share of the gap that goes with each named candidate.
        shares: of the gap, which add up; None: no row says anything.
    """

    rows: HeldOut
    shots: Shots | None
    forces: Forces | None
    errors: dict[str, JointError]
    left: tuple[Left, ...]
    gains: dict[int, float]
    shares: Shares | None

    @property
    def gap(self) -> Gap | None:
        """Of the windows, or of the forces."""
        over = self.shots or self.forces
        return None if over is None else over.gap


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
    forces = None
    if are_prescribed(parts):
        each = [rows.given, rows.given.of(first.calibrated.seen()), rows.after]
        white = [rows.whiten(at.residual).reshape(rows.seen.shape)[rows.seen] for at in each]
        before, calibrated, after = errors_of(each)
        forces = Forces(white[0], white[1], white[2], (before, calibrated, after))
    depends_on = dependence(first.left)
    gone = gains(rows, first.calibrated, found, named)
    parted = shares(rows, found, named, gone)
    return OnTest(rows, over, forces, _errors(rows, over, first.calibrated), left(rows, depends_on), gone, parted)


def _errors(rows: HeldOut, over: Shots | None, calibrated: Hypothesis) -> dict[str, JointError]:
    """Errors of torques and positions of every joint."""
    found, robot = {}, rows.given.true.robot
    between = dataclasses.replace(rows, after=rows.given.of(calibrated.seen()))
    for j, joint in enumerate(rows.given.true.joint_names):
        before, after, recorded_torque = (rms(x) for x in rows.torque(j))
        apart = (float("nan"),) * 3 if over is None else over.position(joint)
        torque_unit, size = robot.torque_unit(joint), max(recorded_torque, 1e-12)
        torque = SignalError(before, after, torque_unit, rms(between.torque(j)[1]), size)
        position = SignalError(apart[0], apart[2], robot.angle_unit(joint), apart[1])
        force = None
        if rows.given.data[0].forced[j]:
            off = errors_of((rows.given, between.after, rows.after), j)
            force = SignalError(off[0], off[2], torque_unit, off[1], recorded(rows.given, j))
        found[joint] = JointError(torque, position, () if over is None else over.scaled(joint), force)
    return found
