"""What a diagnosis says: the verdict, the named effects, the numbers that moved, the gap before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.commands import PD
from flexdyn.diagnose.trace import Trace
from flexdyn.model import FlexibleJointModel

SCHEMA = "flexdyn.diagnosis/1"


@dataclass(frozen=True)
class Number:
    """An estimated number.

    Attributes:
        value: in `unit`.
        std: its standard deviation, which holds for coloured residuals.
        unit: as the effect's parameter has it on this kind of joint.
    """

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class Suspect:
    """An effect where it acts.

    Attributes:
        effect: its name in the catalogue.
        joint: None where it has none (payload, a link's number).
        side: link, motor, transmission or sensor; None where it has none.
        parameters: its numbers by name; empty where they were not estimated.
        place: what else says where it acts: ``channel`` of a sensor effect, ``of`` and ``parameter`` of a parameter
            error, ``other`` of a coupling, ``frame`` of a payload.
    """

    effect: str
    joint: str | None
    side: str | None
    parameters: Mapping[str, Number] = field(default_factory=dict)
    place: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Experiment:
    """A motion that was shown by simulation to tell a finding from its rivals.

    Attributes:
        motion: what to do, in words.
        seconds: it takes, repetitions included.
        passes: how often it is made.
        payload: known mass to be added at the tip [kg].
        delta_bic: expected, of the right name to the nearest of the others, whichever of them is right.
        command: what was simulated: joint control along the motion, once.
        names: the finding's, and that of its nearest rival.
        t: times (points,) [s].
        position: of the joint that moves (points,) [rad or m].
        left: what the rival then cannot explain, its numbers fitted again, if the finding is right (points,).
        noise: standard deviation of that (points,).
        labels: of position and of what is left, with their units.
    """

    motion: str
    seconds: float
    passes: int
    payload: float
    delta_bic: float
    command: PD
    names: tuple[str, str]
    t: NDArray[np.float64]
    position: NDArray[np.float64]
    left: NDArray[np.float64]
    noise: NDArray[np.float64]
    labels: tuple[str, str]

    def __post_init__(self) -> None:
        """Copy and lock the arrays."""
        for name in ("t", "position", "left", "noise"):
            column = np.array(getattr(self, name), dtype=float)
            column.setflags(write=False)
            object.__setattr__(self, name, column)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are locked again."""
        return (type(self), tuple(getattr(self, entry.name) for entry in fields(self)))

    @property
    def apart(self) -> float:
        """How many times the noise the names are apart: the root of the expected delta BIC."""
        return math.sqrt(self.delta_bic)


@dataclass(frozen=True)
class Tried:
    """A name that was tried in a finding's place.

    Attributes:
        suspect: it, without numbers.
        behind: by how much it explains the data of the fit worse than the name that was chosen, in BIC.
        gap: with it on data that took no part in the fit; NaN where that was not needed to turn it down.
    """

    suspect: Suspect
    behind: float
    gap: float


@dataclass(frozen=True)
class Finding:
    """A named effect and why it has this name.

    Attributes:
        suspect: the effect with its numbers.
        delta_bic: how much worse the model without it explains the data that it was fitted to.
        check_gain: share of the gap on data that took no part in the fit that goes with it, from 0 to 1.
        rivals: others that explain the data as well: then the answer is "this or one of those".
        experiment: the motion that would tell them apart; empty where there is no rival.
        plan: that motion, where one was found; None else.
        tried: the name that was chosen and the next best ones, in the round in which it was chosen.
    """

    suspect: Suspect
    delta_bic: float
    check_gain: float
    rivals: tuple[Suspect, ...] = ()
    experiment: str = ""
    plan: Experiment | None = None
    tried: tuple[Tried, ...] = ()


@dataclass(frozen=True)
class Calibration:
    """A number of the model file that moved within its tolerance: true = factor times given."""

    of: str
    parameter: str
    factor: float
    std: float
    tolerance: float


@dataclass(frozen=True)
class Gap:
    """Simulated against measured positions over windows of 0.5 s, in units of what noise alone makes there.

    Attributes:
        before: of the model as it was given.
        calibrated: with its numbers moved within their tolerance.
        after: with the findings added.
        floor: of a perfect model: about 1.
    """

    before: float
    calibrated: float
    after: float
    floor: float


@dataclass(frozen=True)
class Place:
    """Where a part of the gap is: the share of a joint's equation, and the regime in which it stands out."""

    joint: str
    side: str
    share: float
    regime: str


@dataclass(frozen=True)
class Diagnosis:
    """The answer to "where do model and measurement disagree, and what is missing?".

    Attributes:
        verdict: ``no_discrepancy``, ``explained`` or ``unexplained``.
        findings: in the order of their share of the gap.
        calibration: numbers that moved within three sigma of their tolerance.
        fit: the gap on the data of the fit; None where it could not be simulated.
        check: the gap on data that took no part in it.
        where: where the gap was.
        model: the corrected model.
        notes: what the data cannot tell, and what was assumed; a sentence each.
        seconds: that it took.
        residuals: pictures of what the model left unexplained, before and after, for the report.
    """

    verdict: str
    findings: tuple[Finding, ...]
    calibration: tuple[Calibration, ...]
    fit: Gap | None
    check: Gap | None
    where: tuple[Place, ...]
    model: FlexibleJointModel
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    residuals: tuple[Trace, ...] = ()

    def save(self, folder: str | Path) -> None:
        """Write report.html, report.json and model.yaml; all of them, or nothing.

        model.yaml is the corrected model, ready to be simulated: calibration, parameter errors and elasticities are
        folded into its numbers. Where numbers of links changed, a corrected URDF lies beside it.

        Args:
            folder: is made if it is not there; files of an earlier report in it are replaced.

        Raises:
            InputError: the folder cannot be made or written to.
            MissingExtra: matplotlib or plotly is not installed.
        """
        from flexdyn.diagnose.report import write_report

        write_report(self, Path(folder))

    def to_dict(self) -> dict[str, Any]:
        """As report.json holds it (SPEC 8)."""
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "findings": [_finding(entry) for entry in self.findings],
            "calibration": [vars(entry).copy() for entry in self.calibration],
            "gap": {"fit": _gap(self.fit), "check": _gap(self.check)},
            "where": [vars(entry).copy() for entry in self.where],
            "notes": list(self.notes),
            "seconds": self.seconds,
        }


def _finding(entry: Finding) -> dict[str, Any]:
    return {
        **_suspect(entry.suspect),
        "evidence": {
            "delta_bic": entry.delta_bic,
            "check_gain": entry.check_gain,
            "tried": [{**_suspect(each.suspect), "behind": each.behind, "gap": each.gap} for each in entry.tried],
        },
        "indistinguishable_from": [_suspect(rival) for rival in entry.rivals],
        "experiment": entry.experiment,
    }


def _suspect(entry: Suspect) -> dict[str, Any]:
    numbers = {name: vars(number).copy() for name, number in entry.parameters.items()}
    return {"effect": entry.effect, "joint": entry.joint, "side": entry.side, **entry.place, "parameters": numbers}


def _gap(gap: Gap | None) -> dict[str, float] | None:
    return None if gap is None else vars(gap).copy()


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of a diagnosis.

    Attributes:
        diagnosis: what was known by then; None where that was nothing.
    """

    def __init__(self, diagnosis: Diagnosis | None = None) -> None:
        super().__init__("the diagnosis was interrupted")
        self.diagnosis = diagnosis
