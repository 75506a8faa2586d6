"""Recordings of a mass that a rigid motor pushes along a slide, integrated here and by nothing of flexdyn."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.effects import Effect
from tests.arms import slider
from tests.diagnose.workspaces import workspace

Array = NDArray[np.float64]
RATE, MASS, LOAD = 500.0, 3.0, 2.5
"""Samples in a second, moved mass with the rotor and without it [Hz, kg]."""
UNITS = {"theta.lift": "m", "tau.lift": "N"}
NOISE = (2e-6, 0.02)
"""Of position and force, 1 sigma [m, N]."""


def model(folder: Path, effects: Sequence[fd.effects.Effect] = ()) -> fd.FlexibleJointModel:
    """The slide as given, without weight."""
    return fd.FlexibleJointModel(slider(folder), {"lift": {"rotor_inertia": MASS - LOAD}}, effects, gravity=[0.0] * 3)


def recording(
    friction: Callable[[float], float], motor: Callable[[float], float] = float, seconds: float = 16.0
) -> fd.Recording:
    """Motor encoder and force asked for, both noisy, by Runge and Kutta's method in an eighth of a sample.

    Args:
        friction: force against a velocity [N].
        motor: force that the motor gives of what is asked for [N].
        seconds: duration [s].
    """
    t = np.arange(round(seconds * RATE)) / RATE
    force = 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t) + 12.0 * np.sin(11.0 * t + 1.0)
    given = np.array([motor(asked) for asked in force.tolist()])
    return pushed(t, force, lambda given, _x, v: given - friction(v), given)


def pushed(
    t: Array, force: Array, acting: Callable[[float, float, float], float], given: Array | None = None
) -> fd.Recording:
    """What the encoder and the motor's driver record, both noisy, by Runge and Kutta's method in an eighth of a sample.

    Args:
        t: times of the samples (samples,) [s].
        force: asked for, held from sample to sample (samples,) [N].
        acting: force on the mass at a force of the motor, a position and a velocity [N].
        given: force of the motor, if it is not the one asked for (samples,) [N].
    """
    h, x, v, positions = 1.0 / RATE / 8.0, 0.0, 0.0, []
    for motor in (force if given is None else given).tolist():
        positions.append(x)
        for _ in range(8):
            k1 = acting(motor, x, v) / MASS
            k2 = acting(motor, x + 0.5 * h * v, v + 0.5 * h * k1) / MASS
            k3 = acting(motor, x + 0.5 * h * v + 0.25 * h * h * k1, v + 0.5 * h * k2) / MASS
            k4 = acting(motor, x + h * v + 0.5 * h * h * k2, v + h * k3) / MASS
            x += h * (v + h / 6.0 * (k1 + k2 + k3))
            v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    draw = np.random.default_rng(1)
    channels = {"theta.lift": np.array(positions), "tau.lift": force}
    noisy = {
        name: exact + size * draw.standard_normal(len(t))
        for (name, exact), size in zip(channels.items(), NOISE, strict=True)
    }
    return fd.Recording(t, noisy, meta={"units": UNITS})


def named(diagnosis: fd.Diagnosis) -> list[tuple[str, dict[str, float], float]]:
    """Effect, values and probability of every finding."""
    findings: list[dict[str, Any]] = diagnosis.to_dict()["findings"]
    return [
        (each["effect"], {key: number["value"] for key, number in each["parameters"].items()}, each["probability"])
        for each in findings
    ]


def fitted(folder: Path, recording: fd.Recording, *effects: Effect) -> Fit:
    """A fit that begins at the true effects."""
    given = model(folder)
    data = (measured(given, recording),)
    start = dataclasses.replace(prepared(given, data)[1], effects=effects)
    space, start, _ = workspace(given, data, start)
    return fit(start, space)
