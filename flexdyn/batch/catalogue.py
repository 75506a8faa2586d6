"""The catalogue of metrics: numbers that a study stores for every run."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from flexdyn.arrays import Array
from flexdyn.batch.aim import Aim, aim_of_run
from flexdyn.batch.motion import RunsMotion, lengths
from flexdyn.errors import FlexdynError, InputError
from flexdyn.simulation.energy import EnergyWarning
from flexdyn.simulation.run import Run

Law = TypeVar("Law", bound=Callable[..., Any])
BAND = 0.02
"""For settling_time: distances below this share of the largest one count as settled [1]."""
NO_MOTION = 1e-9
"""A smaller displacement is no motion [m, rad]."""
LONGEST_REASON = 300
"""Largest number of letters of a reason."""
# A ledger that does not close is a matter of the solver; the warning would appear for each of thousands of runs.
warnings.filterwarnings("ignore", category=EnergyWarning, module=r"flexdyn\.batch\.catalogue")


@dataclass(frozen=True)
class Metric:
    """A number of a run.

    Attributes:
        name: as a study file writes it.
        unit: of the number; if all joints are prismatic, N m becomes N, and rad becomes m.
        description: one sentence.
        equation: of the number.
        law: function of a motion and its joints' columns that gives the number of each run, NaN if a run has none.
        needs: requirements that not every study meets: ``reference`` (a controller with a path to track), ``rest`` (a
            command that comes to rest before the run ends), ``tip`` (a chain with one end), ``alike`` (joints of one
            kind, or one named joint: ``motor_torque_max.elbow``), ``runs`` (more of a run than its samples).
        joint: the joint that is used; empty: all joints.
        missing: why a run may have no such number.
    """

    name: str
    unit: str
    description: str
    equation: str
    law: Callable[..., Any] = field(repr=False)
    needs: tuple[str, ...] = ()
    joint: str = ""
    missing: str = ""

    def of(self, run: Run, aim: Aim | None = None) -> float:
        """The number of one run.

        Args:
            run: the motion.
            aim: of its command, by `aim_of`; default: what the run itself determines, without a reference.

        Raises:
            InputError: the run has no such number; the message says why.
        """
        values, reasons = self.measured(RunsMotion.of(run, aim_of_run(run) if aim is None else aim))
        if reasons[0]:
            raise InputError(reasons[0])
        return float(values[0])

    def measured(self, motion: RunsMotion) -> tuple[Array, list[str]]:
        """The numbers of some runs, NaN if a run has none, and for each run the reason, or an empty text."""
        values, reasons = self._numbers(motion)
        for i in np.flatnonzero(~np.isfinite(values)):
            reasons[i] = reasons[i] or (self.missing if np.isnan(values[i]) else "") or f"it gives {values[i]}"
            values[i] = np.nan
        return values, [f"metric {self.name}: {reason}" if reason else "" for reason in reasons]

    def _numbers(self, motion: RunsMotion) -> tuple[Array, list[str]]:
        first = motion.robot.joint_index(self.joint) if self.joint else None
        try:
            values = self.law(motion, slice(first, None if first is None else first + 1))
        except (FlexdynError, ValueError) as error:
            return np.full(motion.count, np.nan), [str(error)[:LONGEST_REASON]] * motion.count
        return values, [""] * motion.count


def single_number(value: Any) -> float:
    """A metric's answer as one number; true and false are 1 and 0.

    Raises:
        ValueError: it is none.
    """
    array = np.asarray(value)
    if array.shape != () or array.dtype.kind not in "biuf":
        shape = f"an array of shape {array.shape}" if array.shape else f"a {type(value).__name__}"
        raise ValueError(f"one number is needed, not {shape}")
    return float(array)


@dataclass(frozen=True)
class RunMetric(Metric):
    """A metric whose law takes a `Run`; an error for one run does not affect the others."""

    needs: tuple[str, ...] = ("runs",)

    def _numbers(self, motion: RunsMotion) -> tuple[Array, list[str]]:
        values, reasons = np.full(motion.count, np.nan), [""] * motion.count
        for i, run in enumerate(motion.runs):
            try:
                values[i] = single_number(self.law(run))
            except (FlexdynError, ValueError) as error:
                reasons[i] = str(error)[:LONGEST_REASON]
            except Exception as error:  # a user's function may raise anything
                reasons[i] = f"{type(error).__name__}: {str(error)[:LONGEST_REASON]}"
        return values, reasons


METRICS: dict[str, Metric] = {}
"""The catalogue, by name.

Every metric uses the samples of a run at the study's ``rate``. t_rest is the time at which the command comes to rest:
its torque or reference no longer changes. tip_end and q_end are means over the last tenth of the time after t_rest.
Energies have the accuracy of the solver.
"""


def _metric(unit: str, equation: str, *needs: str, missing: str = "") -> Callable[[Law], Law]:
    """Enter a law into the catalogue: its name is the metric's, the first line of its docstring the description."""

    def enter(law: Law) -> Law:
        """Enter one law, and leave it as it is."""
        kind = RunMetric if needs == ("runs",) else Metric
        about = (law.__doc__ or "").splitlines()[0]
        METRICS[law.__name__] = kind(law.__name__, unit, about, equation, law, needs, missing=missing)
        return law

    return enter


@_metric("m", "max over t of |tip(q) - tip(theta)|", "tip")
def tip_deflection_max(motion: RunsMotion, _: slice) -> Array:
    """Greatest distance between the tip and where it would be if the links were at the rotors' angles."""
    return np.asarray(lengths(motion.deflection).max(axis=1))


@_metric("m", "sqrt(1/T integral of |tip(q) - tip(theta)|^2 dt)", "tip")
def tip_deflection_rms(motion: RunsMotion, _: slice) -> Array:
    """Root mean square over time of the distance between the tip and its place at the rotors' angles."""
    return motion.root_mean_square(lengths(motion.deflection))


@_metric("rad", "max over t and joints of |theta - q|", "alike")
def joint_deflection_max(motion: RunsMotion, joints: slice) -> Array:
    """Greatest deflection of any joint."""
    return motion.greatest(motion.signals["theta"] - motion.signals["q"], joints)


@_metric(
    "s",
    "least T: |tip(t) - tip_end| <= 0.02 max over t of |tip - tip_end| for all t >= t_rest + T",
    *("tip", "rest"),
    missing="the tip does not settle before the run ends",
)
def settling_time(motion: RunsMotion, _: slice) -> Array:
    """Time from the command's rest until the tip stays within 2 % of its greatest distance from where it ends."""
    distance, t = motion.distance, motion.t
    band = np.maximum(BAND * distance.max(axis=1), NO_MOTION)
    outside = distance > band[:, None]
    values = np.where(outside[:, motion.tail].any(axis=1), np.nan, 0.0)
    (late,) = np.nonzero(outside.any(axis=1) & (values == 0.0))
    k = len(t) - 1 - np.argmax(outside[late, ::-1], axis=1)  # the last sample that is outside
    share = (distance[late, k] - band[late]) / (distance[late, k] - distance[late, k + 1])
    values[late] = np.maximum(0.0, t[k] + share * (t[k + 1] - t[k]) - float(motion.aim.rest or 0.0))
    return np.asarray(values)


@_metric(
    "1",
    "max(0, max over t of (q(t) - q_end) . (q_end - q(0))) / |q_end - q(0)|^2",
    *("alike", "rest"),
    missing="it ends where it began: there is no step to overshoot",
)
def overshoot(motion: RunsMotion, joints: slice) -> Array:
    """How far the arm goes beyond where it ends, along its way in joint space, as a share of that way."""
    q = motion.signals["q"][..., joints]
    last = q[:, motion.tail].mean(axis=1, keepdims=True)
    way = last - q[:, :1]
    square = (way**2).sum(axis=(1, 2))
    beyond = np.maximum(0.0, ((q - last) * way).sum(axis=2).max(axis=1))
    return np.asarray(np.divide(beyond, square, out=np.full(motion.count, np.nan), where=square >= NO_MOTION**2))


@_metric("m", "d = tip(q) - tip(theta): max over t >= t_rest of |d(t) - mean of d|", "tip", "rest")
def residual_vibration(motion: RunsMotion, _: slice) -> Array:
    """Greatest distance of the tip deflection from its mean after the command has come to rest."""
    left = motion.deflection[:, motion.resting]
    return np.asarray(lengths(left - left.mean(axis=1, keepdims=True)).max(axis=1))


@_metric("m", "max over t of |tip(q) - tip(reference)|", "tip", "reference")
def tracking_error_max(motion: RunsMotion, _: slice) -> Array:
    """Greatest distance between the tip and where the reference would have it."""
    return np.asarray(motion.tracking_error.max(axis=1))


@_metric("m", "sqrt(1/T integral of |tip(q) - tip(reference)|^2 dt)", "tip", "reference")
def tracking_error_rms(motion: RunsMotion, _: slice) -> Array:
    """Root mean square over time of the distance between the tip and where the reference would have it."""
    return motion.root_mean_square(motion.tracking_error)


@_metric("N m", "max over t and joints of |tau_applied|", "alike")
def motor_torque_max(motion: RunsMotion, joints: slice) -> Array:
    """Greatest torque that any motor applied, after the actuator's effects, reflected to the link side."""
    return motion.greatest(motion.signals["tau_applied"], joints)


@_metric("N m", "max over t and joints of |tau_s|", "alike")
def transmission_torque_max(motion: RunsMotion, joints: slice) -> Array:
    """Greatest torque in any transmission."""
    return motion.greatest(motion.signals["tau_s"], joints)


@_metric("J", "sum over joints of the integral of tau_applied omega dt", "runs")
def energy_supplied(run: Run) -> float:
    """Energy that all motors have supplied by the end; a second pass through the motion integrates it."""
    return float(run.energy.supplied[-1].sum())


@_metric("J", "sum over effects of the integral of their power dt", "runs")
def energy_dissipated(run: Run) -> float:
    """Energy that damping, friction and other effects have dissipated by the end; by the same second pass."""
    return float(sum(lost[-1] for lost in run.energy.dissipated.values()))
