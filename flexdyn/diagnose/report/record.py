"""What was done: with which program, when, on which files, and how well the final fit is determined."""

from __future__ import annotations

import datetime
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from flexdyn.diagnose.report.measures import Role


@dataclass(frozen=True)
class File:
    """A file that was read.

    Attributes:
        path: as it was given.
        use: model, fit or test.
        bytes: its size.
        modified: when it was last changed, ISO 8601 with the zone.
    """

    path: str
    use: Role | str
    bytes: int
    modified: str

    @classmethod
    def of(cls, path: Path, use: str) -> File | None:
        """A file as it is now; None: there is none, as of a model that is known by its name."""
        try:
            # The folder of a ROS 2 bag is as large, and as new, as what lies in it.
            stats = [each.stat() for each in sorted(path.rglob("*"))] if path.is_dir() else [path.stat()]
        except OSError:
            return None
        changed = datetime.datetime.fromtimestamp(max((each.st_mtime for each in stats), default=0.0)).astimezone()
        return cls(str(path), use, sum(each.st_size for each in stats), changed.isoformat(timespec="seconds"))


@dataclass(frozen=True)
class Record:
    """How a diagnosis came about.

    Attributes:
        version: of flexdyn.
        date: of its end, ISO 8601 with the zone.
        command: the command line; empty: it was called from Python.
        files: that were read; none are known of recordings that were made in Python.
    """

    version: str
    date: str
    command: str = ""
    files: tuple[File, ...] = ()


def record(command: str = "", files: Iterable[File | None] = ()) -> Record:
    """Of now, by this version."""
    date = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return Record(version("flexdyn"), date, command, tuple(each for each in files if each is not None))


@dataclass(frozen=True)
class Statistics:
    """How well the final fit of the corrected model is determined; names and formulas as lmfit has them.

    Attributes:
        method: of the fit.
        points: rows of the equations that say something.
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

    The gap is the sum of squares of what the equations leave, in units of noise, of the model as given.

    Attributes:
        calibration: what goes when the file's numbers move to where the corrected model has them [1].
        findings: what goes besides when a finding is added to those before it, in the order of the findings [1].
        left: what the corrected model leaves [1].
        noise: what noise alone leaves of the same, part of `left` where the model is right [1].
    """

    calibration: float
    findings: tuple[float, ...]
    left: float
    noise: float
