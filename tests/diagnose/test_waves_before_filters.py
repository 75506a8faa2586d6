"""Fast waves over a recorded position are taken before the filters, which weaken them."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.equations.terms import applied_torque
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.effects import PositionDependentFriction, TorqueRipple, ViscousFriction
from tests.diagnose.slides import RATE, fitted, pushed

AMPLITUDE, HARMONIC, PHASE, DAMPING = 4.0, 40.0, 0.5, 1.5
RIPPLE = TorqueRipple("lift", amplitude=AMPLITUDE, harmonic=HARMONIC, phase=PHASE)
UNEVEN = {"amplitude": 3.0, "harmonic": HARMONIC, "phase": PHASE}


@cache
def slid(ripple: float = AMPLITUDE, level: float = 0.0) -> fd.Recording:
    """A mass on a slide with a ripple of the motor, damping, and dry friction."""
    t = np.arange(round(12.0 * RATE)) / RATE

    def acting(asked: float, x: float, v: float) -> float:
        wave = ripple * math.sin(HARMONIC * x + PHASE)
        return asked + wave - DAMPING * v - level * math.copysign(1.0, v)

    return pushed(t, 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t), acting)


def error(made: Fit) -> tuple[float, float]:
    """Of the ripple's amplitude [N], and in standard deviations."""
    ((effect, std),) = [(each, s) for (each, name), s in made.std().items() if name == "amplitude"]
    off = float(vars(effect)["amplitude"]) - AMPLITUDE
    return off, off / std


def test_a_wave_has_its_right_size(tmp_path: Path) -> None:
    """A ripple that turns within the width of the filter is taken over the recorded position, and weakened as it is."""
    made = fitted(tmp_path, slid(), RIPPLE, ViscousFriction("lift", side="motor", coefficient=DAMPING))
    off, deviations = error(made)
    assert abs(off) < 0.005
    assert abs(deviations) < 3.0


def test_over_the_filtered_position_it_would_be_too_large(tmp_path: Path) -> None:
    """Signals without the recorded position leave far more than noise: the filter matters here."""
    made = fitted(tmp_path, slid(), RIPPLE, ViscousFriction("lift", side="motor", coefficient=DAMPING))
    at = made.equations
    (along,) = at.motions
    weak, strong = (
        applied_torque([RIPPLE], at.true, each, 0) - each.tau[:, 0]
        for each in (along, dataclasses.replace(along, kernel=None, held=None))
    )
    assert np.abs(strong).max() == pytest.approx(AMPLITUDE, rel=1e-3)
    width = math.sqrt(at.filters.first.variance) * along.dt
    fastest = HARMONIC * np.abs(along.omega[:, 0]).max()
    assert fastest * width > 0.1
    fade = np.exp(-0.5 * (HARMONIC * along.omega[:, 0] * width) ** 2)
    steady = np.abs(along.alpha[:, 0]) * HARMONIC * width**2 < 0.005
    assert np.abs(weak - fade * strong)[steady].max() < 0.02 * AMPLITUDE


def test_friction_over_position_is_weakened_likewise(tmp_path: Path) -> None:
    """Its amplitude is that of the law, beside dry friction, which jumps at reversals."""
    t, law = np.arange(round(12.0 * RATE)) / RATE, PositionDependentFriction("lift", side="motor", **UNEVEN)

    def acting(asked: float, x: float, v: float) -> float:
        return asked - DAMPING * v + float(law.torque(x, v)) * -1.0

    recording = pushed(t, 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t), acting)
    made = fitted(tmp_path, recording, law, ViscousFriction("lift", side="motor", coefficient=DAMPING))
    found = next(each for each in made.hypothesis.effects if isinstance(each, PositionDependentFriction))
    assert found.amplitude == pytest.approx(UNEVEN["amplitude"], rel=2e-3)
