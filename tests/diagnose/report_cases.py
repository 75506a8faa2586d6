"""Diagnoses made by hand, one of every verdict, and one of a robot that lacks much."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

import flexdyn as fd
from flexdyn.diagnose.report.measures import (
    Calibration,
    Gap,
    JointError,
    Left,
    ResidualPlace,
    Shares,
    SignalError,
    Statistics,
)
from flexdyn.diagnose.report.origin import File, Record, RecordingSpan
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Considered, Finding, Number, Structure, Suspect
from flexdyn.diagnose.report.trace import MeasuredCurve, ResidualTrace, Trajectory

STRIBECK = Suspect(
    "stribeck_friction",
    "elbow",
    "motor",
    {"excess": Number(1.2, 0.05, "N m"), "velocity": Number(0.031, 0.004, "rad/s"), "exponent": Number(1.0, 0.2, "1")},
    probability=0.71,
)
PRESLIDING = Suspect("presliding_friction", "elbow", "motor", probability=0.21)
HYSTERESIS = Suspect(
    "spring_hysteresis", "elbow", "transmission", {"stiffness": Number(410.0, 30.0, "N m/rad")}, probability=0.076
)
OFFSET = Suspect("sensor_offset", "elbow", "sensor", {"offset": Number(-0.0123, 0.0002, "rad")}, {"channel": "q.elbow"})
PAYLOAD = Suspect("payload", None, None, {"mass": Number(0.512, 0.006, "kg")}, {"frame": "tip"})
MASS = Suspect("parameter_error", None, None, {}, {"of": "link2", "parameter": "link_mass"})
WRONG = Suspect(
    "parameter_error",
    "shoulder",
    "transmission",
    {"factor": Number(1.31, 0.004, "1")},
    {"of": "shoulder", "parameter": "stiffness"},
)
COULOMB = Suspect("coulomb_friction", "elbow", "motor", {"level": Number(0.4, 0.01, "N m")})
SWEEPS = (
    "Sweep elbow at constant speeds from 0.005 to 0.2 rad/s, both directions, 20 s; then small reversals of 0.01 rad."
)
RIVAL_NOTE = "Its bristle is stiffer than these data can tell from dry friction."


def explained(model: fd.FlexibleJointModel | None = None) -> Diagnosis:
    """Several findings, one of them with rivals; everything that a page can hold."""
    return Diagnosis(
        "explained",
        (
            Finding(STRIBECK, 0.996, 406.2, 0.62, (PRESLIDING, HYSTERESIS), SWEEPS),
            Finding(PAYLOAD, 0.9996, 170.0, 0.21),
            Finding(WRONG, 0.97, 4.1, 0.08),
            Finding(OFFSET, 0.991, 27.5, 0.05),
        ),
        calibration=_numbers(),
        gap_fit=Gap(11.83, 10.2, 1.04, 1.0),
        gap_test=Gap(12.41, 10.9, 1.07, 1.0),
        errors={
            "shoulder": JointError(
                SignalError(4.1, 0.62, "N m", 3.9, 37.3), SignalError(0.0102, 0.00038, "rad", 0.01), (9.1, 8.9, 1.02)
            ),
            "elbow": JointError(
                SignalError(1.73, 0.081, "N m", 1.7, 5.58),
                SignalError(0.0231, 0.00041, "rad", 0.022),
                (15.0, 14.1, 1.1),
            ),
        },
        where=(
            ResidualPlace("elbow", "motor", 0.82, "abs(omega) < 0.1 rad/s"),
            ResidualPlace("elbow", "link", 0.09, ""),
            ResidualPlace("shoulder", "transmission", 0.06, "abs(tau_s) > 12 N m"),
        ),
        left=(),
        structures=ranked(),
        data=sources(),
        model=model or fd.load_model("scara_two_link"),
        notes=(
            "Nothing was measured in the transmission: load-dependent friction is told by the deflection alone.",
            "The elbow moved from 0.2 to 1.1 rad: torques that repeat every turn are not seen.",
        ),
        seconds=41.3,
        residuals=residuals("elbow, motor side") + residuals("shoulder, motor side"),
        considered=compared(),
        trajectories=(motion("elbow"), motion("shoulder")),
        record=Record(
            "0.1.0",
            "2026-03-01T10:00:00+01:00",
            "flexdyn diagnose arm.yaml monday.csv -o out",
            (
                File("arm.yaml", "model", 412, "2026-02-27T16:01:02+01:00"),
                File("monday.csv", "fit", 5_201_337, "2026-02-28T09:30:00+01:00"),
            ),
        ),
        fit=Statistics(
            "Gauss-Newton", 8123, 18, 8011.5, 0.9885, -76.4, 49.6, (("mass of link2", "inertia of link2", -0.97),)
        ),
        shares=Shares(0.02, (0.6, 0.21, 0.09, 0.07), 0.01, 0.0094),
    )


def motion(joint: str) -> Trajectory:
    """Ten seconds of a joint, the model as given off by what friction does."""
    t = np.arange(41.6, 51.6, 0.01)
    q, off = np.sin(t), np.sign(np.cos(t))
    errors = np.stack([0.1 * off, 0.09 * off, 0.001 * off])
    return Trajectory(
        joint,
        "monday.csv",
        "test",
        MeasuredCurve("q [rad]", t, q, 0.1 * errors),
        MeasuredCurve("torque [N m]", t, 9.0 * q, errors),
    )


def ranked() -> tuple[Structure, ...]:
    """Four structures: the payload stands in all of them, the stiffness in all but the last."""
    rest = (PAYLOAD, WRONG, OFFSET)
    return (
        Structure((STRIBECK, *rest), 0.69, -1204.2),
        Structure((PRESLIDING, *rest), 0.21, -1205.4),
        Structure((HYSTERESIS, *rest), 0.07, -1206.5),
        Structure((STRIBECK, PAYLOAD, OFFSET), 0.03, -1208.3),
    )


def compared() -> tuple[Considered, ...]:
    """Named candidates and others."""
    return (
        Considered(PAYLOAD, 0.9996, 170.0),
        Considered(OFFSET, 0.991, 27.5),
        Considered(WRONG, 0.97, 4.1),
        Considered(STRIBECK, 0.71, 1.2),
        Considered(PRESLIDING, 0.21, -1.2, RIVAL_NOTE),
        Considered(HYSTERESIS, 0.076, -2.3),
        Considered(COULOMB, 0.02, -3.9),
        Considered(dataclasses.replace(COULOMB, side="link"), 0.004, -5.5),
        Considered(MASS, 0.0003, -12.0),
    )


def sources() -> tuple[RecordingSpan, ...]:
    """One recording, its last fifth kept for the test."""
    noise = {"q.elbow": 2.1e-6, "theta.elbow": 1.4e-7, "tau.elbow": 0.031}
    return (
        RecordingSpan("monday.csv", "fit", 0.0, 41.6, 1000.0, noise),
        RecordingSpan("monday.csv", "test", 41.6, 52.0, 1000.0, noise),
    )


def no_discrepancy() -> Diagnosis:
    """Nothing found; a number moved."""
    moved = (Calibration("elbow", "stiffness", 0.98, 0.004, 0.03),)
    gap = Gap(2.1, 1.02, 1.02, 1.0)
    structures = (Structure((), 0.98, -310.0), Structure((COULOMB,), 0.02, -313.9))
    return _diagnosis("no_discrepancy", calibration=moved, gap_fit=gap, gap_test=gap, structures=structures)


def unexplained() -> Diagnosis:
    """A real gap without an established name, and no test data."""
    return _diagnosis(
        "unexplained",
        gap_fit=Gap(9.1, 8.2, 8.2, 1.0),
        where=(ResidualPlace("elbow", "motor", 0.7, "q between 0.4 and 0.6 rad"),),
        left=(Left("elbow", 0.12, 0.08, ()),),
        considered=(Considered(COULOMB, 0.41, 1.1), Considered(PRESLIDING, 0.3, -0.2)),
        residuals=residuals("elbow, motor side"),
    )


def partly() -> Diagnosis:
    """A finding beside what is left; numbers that could not be had."""
    unknown = Suspect("coulomb_friction", "shoulder", "link", {"level": Number(0.4, math.nan, "N m")})
    gap = Gap(math.inf, 8.2, 3.4, 1.0)
    return _diagnosis(
        "partly_explained",
        findings=(Finding(unknown, 0.97, math.nan, math.nan),),
        gap_fit=gap,
        gap_test=gap,
        errors={
            "shoulder": JointError(SignalError(2.0, math.nan, "N m", size=6.7), SignalError(0.02, math.inf, "rad"))
        },
        left=(Left("shoulder", 0.02, 0.011), Left("elbow", 0.043, 0.083, ("q", "omega"))),
    )


def not_converged() -> Diagnosis:
    """The fit stopped; one name had been established; the corrected model is worse than the given one."""
    return _diagnosis(
        "not_converged",
        findings=(Finding(PAYLOAD, 0.998, 55.0, math.nan), Finding(COULOMB, 0.6, 0.4, math.nan)),
        gap_fit=Gap(4.0, 3.5, 4.4, 1.0),
        stopped=("stiffness of elbow", "damping of elbow"),
        no_model="on the data of the fit the corrected model is worse than the model as it was given",
    )


def untested() -> Diagnosis:
    """A lone short recording: one name, and no test data."""
    return _diagnosis(
        "untested", findings=(Finding(COULOMB, 0.998, 55.0, math.nan),), gap_fit=Gap(9.1, 8.2, 1.0, 1.0),
        data=sources()[:1],
    )  # fmt: skip


def interrupted() -> Diagnosis:
    """Ctrl-C in the search: one name stands, one does not."""
    return _diagnosis(
        "interrupted",
        findings=(Finding(PAYLOAD, 0.99, 31.0, math.nan), Finding(COULOMB, 0.6, 0.4, math.nan)),
        considered=(Considered(PAYLOAD, 0.99, 31.0), Considered(COULOMB, 0.6, 0.4)),
        seconds=8.0,
        stopped_at="simulating windows (3 of 5)",
    )


def interrupted_early() -> Diagnosis:
    """Ctrl-C while structures were compared: no name, and no corrected model."""
    return _diagnosis(
        "interrupted",
        structures=(Structure((COULOMB,), 0.7, -310.0), Structure((), 0.3, -310.8)),
        data=sources()[:1],
        no_model="there was no corrected model yet",
        stopped_at="comparing structures: pass 2 of at most 5",
    )


CASES = (explained, no_discrepancy, unexplained, partly, not_converged, untested, interrupted, interrupted_early)


def robot() -> Diagnosis:
    """Six joints whose published model has no friction: twelve findings, and something is left."""
    model = fd.load_model("ur5")
    found, numbers = [], []
    for k, joint in enumerate(model.joint_names):
        viscous = {"coefficient": Number(8.0 / (k + 1), 0.11, "N m s/rad")}
        dry = {"level": Number(6.5 / (k + 1), 0.07, "N m")}
        found.append(Finding(Suspect("viscous_friction", joint, "motor", viscous), 0.9999, 812.0 / (k + 1), 0.06))
        found.append(
            Finding(Suspect("coulomb_friction", joint, "motor", dry), 0.9991 - 0.004 * k, 96.0 / (k + 1), 0.08)
        )
        numbers.append(Calibration(joint, "rotor_inertia", 1.0 + 0.1 * (-1) ** k * k, 0.05, 0.3))
    base = tuple(each.suspect for each in found)
    extra = Suspect("load_dependent_friction", model.joint_names[1], "motor")
    gap = Gap(57.2, 52.0, 6.1, 1.0)
    noise = {f"{signal}.{joint}": 1e-5 for joint in model.joint_names for signal in ("theta", "tau")}
    return Diagnosis(
        "partly_explained",
        tuple(found),
        calibration=tuple(numbers),
        gap_fit=gap,
        gap_test=gap,
        errors={
            joint: JointError(
                SignalError(40.0 / (k + 1), 4.1 / (k + 1), "N m", size=50.0), SignalError(0.05, 0.004, "rad")
            )
            for k, joint in enumerate(model.joint_names)
        },
        where=tuple(ResidualPlace(joint, "total", 0.4 / (k + 1), "") for k, joint in enumerate(model.joint_names)),
        left=tuple(Left(joint, 0.1 - 0.01 * k, 0.12, ("q", "t")[: k % 3]) for k, joint in enumerate(model.joint_names)),
        structures=tuple(
            Structure(base if k % 2 == 0 else (*base[k:], extra), 0.6 / 2.0 ** (k + 1), -9000.0 - 3.2 * k)
            for k in range(12)
        ),
        data=(
            RecordingSpan("monday.csv", "fit", 0.0, 48.0, 125.0, noise),
            RecordingSpan("tuesday_with_a_long_name_of_a_file.csv", "fit", 0.0, 48.0, 125.0, noise),
            RecordingSpan("wednesday.csv", "test", 0.0, 30.0, 125.0, noise),
        ),
        model=model,
        notes=("Motor encoders only: an elastic joint is told by what it does to the rotor.",),
        seconds=28.4,
        residuals=tuple(trace for joint in model.joint_names for trace in residuals(joint)),
        considered=tuple(Considered(each.suspect, each.probability, each.log_bayes_factor) for each in found),
    )


def residuals(title: str) -> tuple[ResidualTrace, ...]:
    """Over time and over velocity: friction that is missing, and noise."""
    draw = np.random.default_rng(3)
    t = np.arange(0.0, 20.0, 1e-3)
    omega = 0.4 * np.sin(t) * np.sin(0.13 * t)
    noise = 0.05 * draw.standard_normal(len(t))
    before = noise + 1.2 * np.exp(-np.abs(omega) / 0.05) * np.sign(omega)
    before[8000:8400] = math.nan
    return (
        ResidualTrace.thinned(title, "t [s]", "residual [N m]", t, before, noise),
        ResidualTrace.thinned(title, "omega [rad/s]", "residual [N m]", omega, before, noise),
    )


def _numbers() -> tuple[Calibration, ...]:
    moved = [
        Calibration(joint, parameter, factor, 0.004, 0.03)
        for joint in ("shoulder", "elbow")
        for parameter, factor in (("stiffness", 0.98), ("rotor_inertia", 1.051), ("damping", 0.93))
    ]
    return (*moved[1:], Calibration("effects[0]", "stall_torque", 1.01, 0.002, 0.03))


def _diagnosis(verdict: str, **given: object) -> Diagnosis:
    """With nothing in it but what is given."""
    return Diagnosis(verdict, **{"findings": (), "model": fd.load_model("scara_two_link"), **given})  # type: ignore[arg-type]
