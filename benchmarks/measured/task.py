"""What a study diagnoses: a model and its recordings, at their own rate or at a lower one."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import flexdyn as fd


@dataclass(frozen=True, eq=False)
class Task:
    """A model, what it is diagnosed from, and what takes no part.

    Attributes:
        name: of the robot, in tables.
        model: what the lab has.
        fit: recordings that the diagnosis reads.
        check: recordings that are kept apart; none: the last fifth of the motion in each of `fit`.
        expect: effects that the drive is likely to have.
    """

    name: str
    model: fd.FlexibleJointModel
    fit: tuple[fd.Recording, ...]
    check: tuple[fd.Recording, ...] = ()
    expect: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Lowest rate of the recordings of the fit [Hz]."""
        return min(each.rate for each in self.fit)

    def decimated(self, factor: int) -> Task:
        """With one sample of so many: positions behind a filter, what is held as means (`Recording.decimate`)."""
        fit, check = (tuple(decimated(each, factor) for each in part) for part in (self.fit, self.check))
        return dataclasses.replace(self, fit=fit, check=check)

    def diagnosis(self) -> fd.Diagnosis:
        """What the recordings say of the model."""
        return fd.diagnose(self.model, self.fit, self.check, expect=self.expect, progress=False)


def decimated(recording: fd.Recording, factor: int) -> fd.Recording:
    """One sample of so many, on an even clock, which decimation needs; 1: as it is."""
    return recording if factor == 1 else recording.resample(rate=recording.rate).decimate(factor)
