"""The catalogue of metrics: numbers that a study keeps of every run."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.batch.aim import Aim, aim_of_run
from flexdyn.batch.motion import Motion
from flexdyn.batch.own_metric import single_number
from flexdyn.energy import EnergyWarning
from flexdyn.errors import FlexdynError, InputError
from flexdyn.run import Run

BAND = 0.02
"""Of settling_time: share of the greatest distance that still counts as settled [1]."""
STILL = 1e-9
"""Less than this is no motion [m, rad]."""
LONGEST = 300
"""Letters of a reason that are kept."""
# What a ledger leaves unexplained is a solver's matter, and would be said once for each of thousands of runs.
warnings.filterwarnings("ignore", category=EnergyWarning, module=r"flexdyn\.batch\.catalogue")


@dataclass(frozen=True)
class Metric:
    """A number of a run.

    Attributes:
        name: as a study file writes it.
        unit: of the number; N m reads N, and rad m, for arms whose joints all slide.
        description: one sentence.
        equation: of the number.
        law: from a motion and its joints' columns to the number.
        needs: what not every study has: ``reference`` (a controller with a path to track), ``rest`` (a command that
            comes to rest before the run ends), ``tip`` (a chain with one end), ``alike`` (joints of one kind, or one
            joint that is named: ``motor_torque_max.elbow``).
        joint: the only one that counts; empty: all.
    """

    name: str
    unit: str
    description: str
    equation: str
    law: Callable[[Motion, slice], Any] = field(repr=False)
    needs: tuple[str, ...] = ()
    joint: str = ""

    def of(self, run: Run, aim: Aim | None = None) -> float:
        """The number of one run.

        Args:
            run: the motion.
            aim: of its command, by `aim_of`; default: what the run itself tells, which is no reference.

        Raises:
            InputError: it has none, and why.
        """
        return self.measured(Motion(run, aim_of_run(run) if aim is None else aim))

    def measured(self, motion: Motion) -> float:
        """The number of a motion.

        Raises:
            InputError: it has none, and why.
        """
        try:
            first = motion.run.model.index(self.joint) if self.joint else None
            value = single_number(self.law(motion, slice(first, None if first is None else first + 1)))
        except (FlexdynError, ValueError) as error:
            raise InputError(f"metric {self.name}: {str(error)[:LONGEST]}") from None
        except Exception as error:  # a user's function may raise anything
            raise InputError(f"metric {self.name}: {type(error).__name__}: {str(error)[:LONGEST]}") from None
        if not np.isfinite(value):
            raise InputError(f"metric {self.name}: it gives {value}")
        return value


def _settling_time(motion: Motion, _: slice) -> float:
    distance, t = motion.distance, motion.run.t
    band = max(BAND * float(distance.max()), STILL)
    if (distance[motion.tail] > band).any():
        raise ValueError("the tip does not settle before the run ends")
    outside = np.flatnonzero(distance > band)
    if not len(outside):
        return 0.0
    k = int(outside[-1])
    share = (distance[k] - band) / (distance[k] - distance[k + 1])
    return max(0.0, float(t[k] + share * (t[k + 1] - t[k])) - float(motion.aim.rest or 0.0))


def _overshoot(motion: Motion, joints: slice) -> float:
    q = motion.run.q[:, joints]
    last = q[motion.tail].mean(axis=0)
    way = last - q[0]
    length = float(np.sqrt(way @ way))
    if length < STILL:
        raise ValueError("it ends where it began: there is no step to overshoot")
    return max(0.0, float(((q - last) @ way).max())) / length**2


def _residual_vibration(motion: Motion, _: slice) -> float:
    left = motion.deflection[motion.resting]
    return float(np.sqrt(((left - left.mean(axis=0)) ** 2).sum(axis=1).max()))


def _dissipated(motion: Motion, _: slice) -> float:
    return float(sum(lost[-1] for lost in motion.run.energy.dissipated.values()))


def _size(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.sqrt((vectors**2).sum(axis=1)))


METRICS: dict[str, Metric] = {
    each.name: each
    for each in (
        Metric(
            "tip_deflection_max",
            "m",
            "Greatest distance between the tip and where it would be if the links stood at the rotors' angles.",
            "max over t of |tip(q) - tip(theta)|",
            lambda motion, _: _size(motion.deflection).max(),
            ("tip",),
        ),
        Metric(
            "tip_deflection_rms",
            "m",
            "Root mean square over time of the distance between the tip and its place at the rotors' angles.",
            "sqrt(1/T integral of |tip(q) - tip(theta)|^2 dt)",
            lambda motion, _: motion.root_mean_square(_size(motion.deflection)),
            ("tip",),
        ),
        Metric(
            "joint_deflection_max",
            "rad",
            "Greatest deflection of any joint.",
            "max over t and joints of |theta - q|",
            lambda motion, joints: np.abs(motion.run.deflection[:, joints]).max(),
            ("alike",),
        ),
        Metric(
            "settling_time",
            "s",
            "Time from the command's rest until the tip stays within 2 % of its greatest distance from where it ends.",
            "least T: |tip(t) - tip_end| <= 0.02 max over t of |tip - tip_end| for all t >= t_rest + T",
            _settling_time,
            ("tip", "rest"),
        ),
        Metric(
            "overshoot",
            "1",
            "How far the arm goes beyond where it ends, along its way in joint space, as a share of that way.",
            "max(0, max over t of (q(t) - q_end) . (q_end - q(0))) / |q_end - q(0)|^2",
            _overshoot,
            ("alike", "rest"),
        ),
        Metric(
            "residual_vibration",
            "m",
            "Greatest distance of the tip deflection from its mean after the command has come to rest.",
            "d = tip(q) - tip(theta): max over t >= t_rest of |d(t) - mean of d|",
            _residual_vibration,
            ("tip", "rest"),
        ),
        Metric(
            "tracking_error_max",
            "m",
            "Greatest distance between the tip and where the reference would have it.",
            "max over t of |tip(q) - tip(reference)|",
            lambda motion, _: motion.tracking_error.max(),
            ("tip", "reference"),
        ),
        Metric(
            "tracking_error_rms",
            "m",
            "Root mean square over time of the distance between the tip and where the reference would have it.",
            "sqrt(1/T integral of |tip(q) - tip(reference)|^2 dt)",
            lambda motion, _: motion.root_mean_square(motion.tracking_error),
            ("tip", "reference"),
        ),
        Metric(
            "motor_torque_max",
            "N m",
            "Greatest torque that any motor applied, after the actuator's effects, reflected to the link side.",
            "max over t and joints of |tau_applied|",
            lambda motion, joints: np.abs(motion.run.tau_applied[:, joints]).max(),
            ("alike",),
        ),
        Metric(
            "transmission_torque_max",
            "N m",
            "Greatest torque in any transmission.",
            "max over t and joints of |tau_s|",
            lambda motion, joints: np.abs(motion.run.tau_s[:, joints]).max(),
            ("alike",),
        ),
        Metric(
            "energy_supplied",
            "J",
            "Energy that all motors have supplied by the end; a second pass through the motion integrates it.",
            "sum over joints of the integral of tau_applied omega dt",
            lambda motion, _: motion.run.energy.supplied[-1].sum(),
        ),
        Metric(
            "energy_dissipated",
            "J",
            "Energy that damping, friction and other effects have dissipated by the end; by the same second pass.",
            "sum over effects of the integral of their power dt",
            _dissipated,
        ),
    )
}
"""The catalogue, by name.

Every metric is taken over the samples that a run has, at the study's ``rate``. t_rest is when the command comes to
rest: a torque that is played no longer changes, a reference stands still. tip_end and q_end are means over the last
tenth of the time after it. Energies are as exact as the solver.
"""
