"""A motor with inductance is diagnosed from its volts: the lag of its current is no effect that is missing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.windings import with_lagging_current
from flexdyn.simulation.electrical import with_asked_torque
from tests.diagnose.slides import named
from tests.simulation.test_dc_motor import KT, ROD, ROTOR, B, N, R, model

RATE, SECONDS, NOISE, LAG, LEVEL = 500, 8.0, 2e-5, 4e-3, 0.03
"""Of the record [Hz, s, rad], L/R [s], and the friction of the motor [N m]."""
INSIDE = 40
"""Steps between two samples."""


def volts(t: np.ndarray) -> np.ndarray:
    """A voltage that turns the pendulum about and changes fast enough for the winding to matter [V]."""
    return 1.8 * np.sin(1.3 * t) + 1.0 * np.sin(4.1 * t) + 0.8 * np.sin(19.0 * t + 1.0)


def recorded(limit: float = math.inf) -> fd.Recording:
    """Pendulum, winding and dry friction by small steps, written here; what the motor's encoder and the driver tell."""
    t, h, k = np.arange(round(SECONDS * RATE)) / RATE, 1.0 / RATE / INSIDE, N * KT
    asked, x, u, current, seen = volts(t), 0.0, 0.0, 0.0, np.empty(len(t))
    for row, volt in enumerate(asked.tolist()):
        seen[row] = x
        for _ in range(INSIDE):
            current = min(max(current + h * (volt - R * current - k * u) / (LAG * R), -limit), limit)
            free = u + h * (k * current - 0.49 * 9.81 * 0.1 * math.sin(x)) / (ROTOR + ROD)
            u = math.copysign(max(abs(free) - h * LEVEL / (ROTOR + ROD), 0.0), free)
            x += h * u
    seen += np.random.default_rng(2).normal(0.0, NOISE, len(t))
    return fd.Recording(t, {"voltage.swing": asked, "theta.swing": seen})


def pendulum(folder: Path, inductance: float, **motor: float) -> fd.FlexibleJointModel:
    """The pendulum without friction."""
    made: fd.FlexibleJointModel = model(folder, gravity=9.81, motor={"inductance": inductance, **motor})
    return made.replace(tolerance=0.03)


@pytest.mark.parametrize("limit", [math.inf, 0.5], ids=["free", "limited"])
def test_friction_alone_is_named(tmp_path: Path, limit: float) -> None:
    """With its level; the corrected model keeps the inductance, and its supply and current limit."""
    given = pendulum(tmp_path, LAG * R, supply=12.0, current_limit=limit)
    found = fd.diagnose(given, [recorded(limit)], progress=False)
    ((effect, values, _),) = named(found)
    assert effect == "coulomb_friction"
    assert values["level"] == pytest.approx(LEVEL, rel=0.05)
    assert found.verdict == "explained"
    found.save(tmp_path / "answer")
    actuator = fd.load_model(tmp_path / "answer" / "model.yaml").joints["swing"].actuator
    assert actuator is not None
    motor = actuator.dc_motor
    assert (motor.inductance, motor.supply, motor.current_limit) == (LAG * R, 12.0, limit)


def test_the_current_is_that_of_the_winding(tmp_path: Path) -> None:
    """``k i`` of the simulation's own winding, at the means between samples."""
    given = pendulum(tmp_path, LAG * R)
    t = np.arange(1000) / RATE
    run = fd.simulate(given, fd.Recording(t, {"voltage.swing": volts(t)}), rate=RATE * INSIDE)
    fine = N * KT * run.electrical.current[:, 0]
    means = 0.5 * (fine[:-1] + fine[1:])[: len(t[:-1]) * INSIDE].reshape(-1, INSIDE).mean(axis=1)
    seen = fd.Recording(t, {"voltage.swing": volts(t), "theta.swing": run.theta[::INSIDE, 0][: len(t)]})
    asked = with_lagging_current(given, with_asked_torque(given, seen))["tau.swing"][:-1]
    through = asked - B * np.diff(seen["theta.swing"]) * RATE
    settled = t[:-1] > 10.0 * LAG
    assert np.abs(through - means)[settled].max() < 2e-3 * np.abs(means).max()
