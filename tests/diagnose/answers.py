"""Diagnoses made by hand, one of every kind that a report has to tell."""

from __future__ import annotations

import math

import numpy as np

import flexdyn as fd
from flexdyn.diagnose.result import Calibration, Diagnosis, Finding, Gap, Number, Place, Suspect, Tried
from flexdyn.diagnose.trace import Trace

STRIBECK = Suspect(
    "stribeck_friction",
    "elbow",
    "motor",
    {"excess": Number(1.2, 0.05, "N m"), "velocity": Number(0.031, 0.004, "rad/s"), "exponent": Number(1.0, 0.2, "1")},
)
PRESLIDING = Suspect("presliding_friction", "elbow", "motor")
HYSTERESIS = Suspect("spring_hysteresis", "elbow", "transmission", {"stiffness": Number(410.0, 30.0, "N m/rad")})
OFFSET = Suspect("sensor_offset", "elbow", "sensor", {"offset": Number(-0.0123, 0.0002, "rad")}, {"channel": "q.elbow"})
PAYLOAD = Suspect("payload", None, None, {"mass": Number(0.512, 0.006, "kg")}, {"frame": "tip"})
WRONG = Suspect(
    "parameter_error",
    "shoulder",
    None,
    {"factor": Number(1.31, 0.004, "1")},
    {"of": "shoulder", "parameter": "stiffness"},
)
TRIED = (
    Tried(Suspect("payload", None, None, {}, {"frame": "tip"}), 0.0, 1.07),
    Tried(Suspect("parameter_error", None, None, {}, {"of": "link2", "parameter": "link_mass"}), -12.0, 3.2),
    Tried(Suspect("torque_constant_error", "elbow", "motor"), 18_810.4, math.nan),
)
SWEEPS = (
    "Sweep elbow at constant speeds from 0.005 to 0.2 rad/s, both directions, 20 s; then small reversals of 0.01 rad."
)


def explained(model: fd.FlexibleJointModel | None = None) -> Diagnosis:
    """Several findings, one of them with rivals; calibration, places and residuals."""
    arm = model or fd.load_model("scara_two_link")
    found = (
        Finding(STRIBECK, 812.4, 0.62, (PRESLIDING, HYSTERESIS), SWEEPS),
        Finding(PAYLOAD, 340.0, 0.21, tried=TRIED),
        Finding(WRONG, 96.1, 0.08),
        Finding(OFFSET, 55.0, 0.05),
    )
    numbers = [
        Calibration(joint, parameter, factor, 0.004, 0.03)
        for joint in ("shoulder", "elbow")
        for parameter, factor in (("stiffness", 0.98), ("rotor_inertia", 1.051), ("damping", 0.93))
    ]
    return Diagnosis(
        "explained",
        found,
        (*numbers, Calibration("effects[0]", "level", 1.01, 0.002, 0.03)),
        Gap(11.83, 10.2, 1.04, 1.0),
        Gap(12.41, 10.9, 1.07, 1.0),
        (
            Place("elbow", "motor", 0.82, "abs(omega) < 0.1 rad/s"),
            Place("elbow", "link", 0.09, ""),
            Place("shoulder", "transmission", 0.06, "abs(tau_s) > 12 N m"),
        ),
        arm,
        (
            "Nothing was measured in the transmission: load-dependent friction is told by the deflection alone.",
            "The elbow moved from 0.2 to 1.1 rad: torques that repeat every turn are not seen.",
        ),
        41.3,
        residuals("elbow, motor side") + residuals("shoulder, motor side"),
    )


def no_discrepancy() -> Diagnosis:
    """Nothing found; a number moved."""
    moved = (Calibration("elbow", "stiffness", 0.98, 0.004, 0.03),)
    gap = Gap(2.1, 1.02, 1.02, 1.0)
    return Diagnosis("no_discrepancy", (), moved, gap, gap, (), fd.load_model("scara_two_link"))


def unexplained() -> Diagnosis:
    """A real gap without a name, and no data to check it on."""
    places = (Place("elbow", "motor", 0.7, "position 0.4 to 0.6 rad"),)
    gap = Gap(9.1, 8.2, 8.2, 1.0)
    return Diagnosis(
        "unexplained",
        (),
        (),
        gap,
        None,
        places,
        fd.load_model("scara_two_link"),
        (),
        0.0,
        residuals("elbow, motor side"),
    )


def partly() -> Diagnosis:
    """A finding beside what is left; numbers that could not be had."""
    unknown = Suspect("coulomb_friction", "shoulder", "link", {"level": Number(0.4, math.nan, "N m")})
    gap = Gap(math.inf, 8.2, 3.4, 1.0)
    found = (Finding(unknown, math.nan, 0.3),)
    return Diagnosis("unexplained", found, (), gap, gap, (), fd.load_model("scara_two_link"))


def residuals(title: str) -> tuple[Trace, ...]:
    """Over time and over velocity: friction that is missing, and noise."""
    draw = np.random.default_rng(3)
    t = np.arange(0.0, 20.0, 1e-3)
    omega = 0.4 * np.sin(t) * np.sin(0.13 * t)
    noise = 0.05 * draw.standard_normal(len(t))
    before = noise + 1.2 * np.exp(-np.abs(omega) / 0.05) * np.sign(omega)
    before[8000:8400] = math.nan
    return (
        Trace.thinned(title, "t [s]", "residual [N m]", t, before, noise),
        Trace.thinned(title, "omega [rad/s]", "residual [N m]", omega, before, noise),
    )
