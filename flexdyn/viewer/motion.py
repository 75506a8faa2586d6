"""The motion of an arm for the viewer: positions and deflections over time, and the frames of a page."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.plant import first_positions
from flexdyn.simulation.run import Run

FASTEST = 240.0
"""Largest frame rate [Hz]: at a tenth of the speed there are still 24 frames in a second."""
MOST_FRAMES = 3600
"""Largest number of frames in a page."""
MOST_MAGNIFIED = 1e9
"""Largest magnification of a deflection [1]."""


@dataclass(frozen=True)
class PlayedMotion:
    """Positions of an arm over time.

    Attributes:
        label: its name in the page.
        t: times (samples,) [s]; one sample: the arm does not move.
        q: link positions (samples, n) [rad or m].
        deflection: theta - q (samples, n) [rad or m]; NaN where the rotor is rigid with its link or not known.
        notes: what was assumed, one sentence each.
    """

    label: str
    t: Array
    q: Array
    deflection: Array
    notes: tuple[str, ...] = ()

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""
        return float(self.t[0]), float(self.t[-1])

    def at(self, times: Array) -> PlayedMotion:
        """The motion at other times, interpolated linearly, constant before the first and after the last sample."""

        def moved(table: Array) -> Array:
            """The columns of a table (samples, n) at the other times."""
            return np.column_stack([np.interp(times, self.t, column) for column in table.T])

        return replace(self, t=times, q=moved(self.q), deflection=moved(self.deflection))


def of_run(run: Run) -> PlayedMotion:
    """A simulated motion; the rotors of elastic joints are shown."""
    deflection = np.where(run.model.elastic, run.deflection, np.nan)
    label = run.model.name if run.model.elastic.any() else f"{run.model.name}, rigid"
    return PlayedMotion(label, run.t, run.q, deflection)


def at_rest(model: FlexibleJointModel) -> PlayedMotion:
    """The arm at its initial position."""
    q = first_positions(model)[None]
    notes = ("the arm stands at the model's initial position",)
    return PlayedMotion(model.name, np.zeros(1), q, np.full_like(q, np.nan), notes)


def of_recording(recording: Recording, model: FlexibleJointModel, missing: PlayedMotion) -> PlayedMotion:
    """A recorded motion of the joints of a model.

    Args:
        recording: with q or theta of at least one joint; a joint that has theta alone is shown at theta.
        model: of the arm.
        missing: positions of joints that the recording does not have.

    Raises:
        InputError: no position of any joint of the model.
    """
    joints = model.joint_names
    linked = [joint for joint in joints if recording.has("q", joint)]
    driven = [joint for joint in joints if joint not in linked and recording.has("theta", joint)]
    absent = [joint for joint in joints if joint not in linked and joint not in driven]
    if len(absent) == len(joints):
        has = ", ".join(list(recording.channels)[:6]) or "none"
        remedy = f"channels named {' or '.join(f'{signal}.{joints[0]}' for signal in ('q', 'theta'))} are needed"
        raise InputError("no position of any joint of the arm", key="channels", value=has, remedy=remedy)
    q = missing.at(recording.t).q
    deflection = np.full_like(q, np.nan)
    for j, joint in enumerate(joints):
        if joint in absent:
            continue
        q[:, j] = recording[f"q.{joint}" if joint in linked else f"theta.{joint}"]
        if joint in linked and recording.has("theta", joint):
            measured = recording[f"theta.{joint}"] - q[:, j]
            # The rotor of a rigid joint is not shown, unless it was measured.
            if model.elastic[j] or measured.any():
                deflection[:, j] = measured
    said = {
        "only theta was measured: the link is shown at its rotor's angle": driven,
        "not in the recording, held or as in the arm it is compared with": absent,
    }
    notes = tuple(f"{text}: {', '.join(names)}" for text, names in said.items() if names)
    return PlayedMotion(recording.name or model.name, recording.t, q, deflection, notes)


@dataclass(frozen=True)
class Frames:
    """Motions at equally spaced times.

    Attributes:
        arm: motion of the arm.
        ghost: motion of the second arm, if there is one.
        rate: frames in a second [Hz].
    """

    arm: PlayedMotion
    ghost: PlayedMotion | None
    rate: float

    @property
    def everywhere(self) -> Array:
        """All positions of all arms (frames of all, n) [rad or m]."""
        return self.arm.q if self.ghost is None else np.vstack([self.arm.q, self.ghost.q])


def frames_of(motion: PlayedMotion, ghost: PlayedMotion | None) -> Frames:
    """Motions at the times of the page, which are those of the first motion that is not at rest.

    Raises:
        InputError: the two motions have no time in common.
    """
    times = frame_times(motion if ghost is None or len(motion.t) > 1 else ghost)
    if ghost is not None:
        (first, last), (start, end) = motion.span, ghost.span
        if last > first and end > start and (start >= last or end <= first):
            own, other = f"{start:.10g} to {end:.10g} s", f"{first:.10g} to {last:.10g} s"
            problem = f"it spans {own}, and what it is compared with {other}"
            raise InputError(problem, key="compare", remedy="shift the clock of one of them")
    rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 else 1.0
    return Frames(motion.at(times), None if ghost is None else ghost.at(times), float(rate))


def frame_times(motion: PlayedMotion) -> Array:
    """Equally spaced times from first to last; one time if the arm does not move.

    There are not more than the samples of the motion, `MOST_FRAMES`, or `FASTEST` in a second.
    """
    first, last = motion.span
    if last == first:
        return np.array([first])
    count = min(len(motion.t), MOST_FRAMES, math.ceil((last - first) * FASTEST) + 1)
    return np.linspace(first, last, count)


def checked_factor(magnify: float) -> float:
    """Check a magnification from the user.

    Raises:
        InputError: it is none.
    """
    if not 0.0 < magnify <= MOST_MAGNIFIED:
        remedy = f"above 0, and up to {MOST_MAGNIFIED:g}"
        raise InputError("no such factor", key="magnify", value=magnify, remedy=remedy)
    return float(magnify)


def magnification(deflection: Array, shown: float) -> float:
    """The factor 1, 2, 5, 10, ... with which the largest deflection is nearest to `shown`; 1 if there is no deflection.

    Args:
        deflection: any shape; NaN where there is none.
        shown: size that the largest deflection should have.
    """
    known = np.abs(deflection[np.isfinite(deflection)])
    largest = float(known.max()) if known.size else 0.0
    if largest * MOST_MAGNIFIED <= shown:
        return 1.0
    wanted = max(shown / largest, 1.0)
    power = 10.0 ** math.floor(math.log10(wanted))
    return min((step * power for step in (1, 2, 5, 10)), key=lambda factor: abs(math.log(factor / wanted)))
