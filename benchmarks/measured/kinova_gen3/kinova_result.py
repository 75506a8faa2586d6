"""What the Kinova's study gives: a diagnosis of every sweep, and what the trajectory says of each name."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from along import Inverse


@dataclass(frozen=True)
class Trial:
    """One finding of a sweep, held against the trajectory, which no decision read.

    The sizes of all laws are least squares on the sweep, so that without a law the others take over what they can.

    Attributes:
        joint: that was swept.
        finding: effects that it may be, the first one in the corrected model.
        error: of the joint's torque over the trajectory with all that the sweep names [1].
        without: the same less this finding.
        rivals: the same with each rival in the place of the first; NaN where its numbers are not known.
    """

    joint: int
    finding: tuple[str, ...]
    error: float
    without: float
    rivals: Mapping[str, float]

    @property
    def survives(self) -> bool:
        """Whether the trajectory is better predicted with it."""
        return self.error < self.without


@dataclass(frozen=True)
class Reference:
    """Plain least squares on the trajectory itself: rotor inertia, viscous and Coulomb friction of one joint.

    Attributes:
        numbers: in this order [kg m^2 behind the gear, N m s/rad, N m].
        error: of the torque that it was fitted to [1].
    """

    numbers: tuple[float, float, float]
    error: float


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        diagnoses: by joint that was swept.
        models: of the whole arm: the plain URDF, and with what the sweeps found.
        inverses: of them over the trajectory.
        trials: of all findings.
        references: by joint.
        cycles: repeated rows, single and lost cycles by file.
    """

    diagnoses: Mapping[int, fd.Diagnosis]
    models: Mapping[str, fd.FlexibleJointModel]
    inverses: Mapping[str, Inverse]
    trials: Sequence[Trial]
    references: Mapping[int, Reference]
    cycles: Mapping[str, tuple[int, int, int]]

    def error(self, model: str, joint: int) -> float:
        """Of a joint's torque over the trajectory [1]."""
        return self.inverses[model].error(joint - 1)

    def named(self) -> list[str]:
        """What the diagnoses name, each with its joint."""
        return [
            f"{' or '.join(dict.fromkeys(each.effect for each in finding.names))} (joint {joint})"
            for joint, diagnosis in self.diagnoses.items()
            for finding in diagnosis.findings
        ]
