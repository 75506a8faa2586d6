"""Signed and nonlinear numbers of effects that nobody knows are estimated, or refused where data do not tell them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import slider
from tests.diagnose import slides
from tests.diagnose.test_unknown_sizes import unknown

COULOMB = {"effect": "coulomb_friction", "joint": "lift", "side": "motor"}
STRIBECK = {"effect": "stribeck_friction", "joint": "lift", "side": "motor"}
SPRING = {"effect": "parallel_spring", "joint": "lift"}
RIPPLE = {"effect": "torque_ripple", "joint": "lift", "harmonic": 20.0}
UNEVEN = {"effect": "position_dependent_friction", "joint": "lift", "side": "motor", "harmonic": 3.0}
DIRECTED = {"effect": "asymmetric_viscous_friction", "joint": "lift", "side": "motor"}
BACKLASH = {"effect": "backlash", "joint": "lift"}
ROTOR, LOAD, STIFFNESS, DAMPING = 0.8, 2.5, 3000.0, 8.0
Force = Callable[[float, float, float], float]


def sign(v: float) -> float:
    """Of a velocity."""
    return math.copysign(1.0, v) if v else 0.0


def wave(t: slides.Array) -> slides.Array:
    """A force that moves everything [N]."""
    return 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t) + 12.0 * np.sin(11.0 * t + 1.0)


def pushed(folder: Path, effects: Any, acting: Force, late: float = 0.0) -> fd.Diagnosis:
    """Of the rigid slide under this force, which comes late [s]."""
    t = np.arange(8000) / slides.RATE
    record = slides.pushed(t, wave(t), acting, wave(t - late))
    return fd.diagnose(slides.model(folder).replace(effects=effects), [record], progress=False)


def check(found: fd.Diagnosis, names: list[str], truth: dict[str, float]) -> None:
    """These effects are named, and every number that was unknown is within three standard deviations, a few percent."""
    assert [each.suspect.effect for each in found.findings] == names
    numbers = unknown(found)
    assert numbers.keys() == truth.keys()
    for name, true in truth.items():
        value, std = numbers[name]
        assert abs(value - true) < 3.0 * std < 0.2 * abs(true), name


@pytest.mark.parametrize("offset", [-2.0, 0.7])
def test_a_size_of_either_sign(tmp_path: Path, offset: float) -> None:
    """A constant force, beside friction that the file lacks."""
    effects = [{"effect": "torque_offset", "joint": "lift", "offset": "unknown"}]
    found = pushed(tmp_path, effects, lambda force, _x, v: force + offset - 3.0 * sign(v))
    check(found, ["coulomb_friction"], {"offset": offset})
    found.save(tmp_path / "answer")
    (given, named) = fd.load_model(tmp_path / "answer" / "model.yaml").effects
    assert [given.values[0], named.values[0]] == pytest.approx([offset, 3.0], rel=0.01)


def test_an_offset_that_is_not_there(tmp_path: Path) -> None:
    """Its interval holds 0."""
    effects = [{"effect": "torque_offset", "joint": "lift", "offset": "unknown"}]
    value, std = unknown(pushed(tmp_path, effects, lambda force, _x, _v: force))["offset"]
    assert abs(value) < 3.0 * std < 0.005


CASES: dict[str, tuple[list[dict[str, Any]], Force, list[str], dict[str, float]]] = {
    "a Stribeck velocity": (
        [{**COULOMB, "level": 2.0}, {**STRIBECK, "excess": 3.0, "velocity": "unknown"}],
        lambda force, _x, v: force - (2.0 + 3.0 * math.exp(-abs(v) / 0.2)) * sign(v),
        [],
        {"velocity": 0.2},
    ),
    "the whole Stribeck law, and missing viscous friction": (
        [{**COULOMB, "level": "unknown"}, {**STRIBECK, "excess": "unknown", "velocity": "unknown"}],
        lambda force, _x, v: force - (2.0 + 3.0 * math.exp(-abs(v) / 0.2)) * sign(v) - v,
        ["viscous_friction"],
        {"level": 2.0, "excess": 3.0, "velocity": 0.2},
    ),
    "where a spring rests": (
        [{**SPRING, "stiffness": "unknown", "rest": "unknown"}],
        lambda force, x, v: force - 40.0 * (x + 0.3) - 2.0 * sign(v),
        ["coulomb_friction"],
        {"stiffness": 40.0, "rest": -0.3},
    ),
    "a wave": (
        [{**RIPPLE, "amplitude": "unknown", "phase": "unknown"}],
        lambda force, x, _v: force + 1.5 * math.sin(20.0 * x - 0.7),
        [],
        {"amplitude": 1.5, "phase": -0.7},
    ),
    "friction that comes and goes": (
        [{**COULOMB, "level": "unknown"}, {**UNEVEN, "amplitude": "unknown", "phase": "unknown"}],
        lambda force, x, v: force - (4.0 + math.sin(3.0 * x + 0.9)) * sign(v),
        [],
        {"level": 3.0, "amplitude": 1.0, "phase": 0.9},
    ),
    "a coefficient for each direction": (
        [{**DIRECTED, "coefficient_positive": "unknown", "coefficient_negative": "unknown"}],
        lambda force, _x, v: force - (5.0 if v > 0.0 else 2.0) * v,
        [],
        {"coefficient_positive": 5.0, "coefficient_negative": 2.0},
    ),
}


@pytest.mark.parametrize(("effects", "acting", "names", "truth"), CASES.values(), ids=CASES.keys())
def test_numbers_of_a_law(
    tmp_path: Path, effects: Any, acting: Force, names: list[str], truth: dict[str, float]
) -> None:
    """Each against equations that are written here, beside what the file lacks."""
    check(pushed(tmp_path, effects, acting), names, truth)


def test_a_delay(tmp_path: Path) -> None:
    """Of three samples, which the model lacks."""
    effects = [{"effect": "command_delay", "joint": "lift", "delay": "unknown"}]
    check(pushed(tmp_path, effects, lambda force, _x, _v: force, late=0.006), [], {"delay": 0.006})


def behind_a_gap(half_gap: float, level: float) -> fd.Recording:
    """Both encoders of a mass behind a spring with a gap, whose motor rubs: Runge and Kutta's method."""
    t, h = np.arange(6000) / slides.RATE, 1.0 / slides.RATE / 12.0
    force, y, rows = wave(t), np.zeros(4), np.empty((6000, 2))

    def slope(y: slides.Array, given: float) -> slides.Array:
        q, theta, v, omega = y.tolist()
        wound = theta - q
        carried = STIFFNESS * math.copysign(max(abs(wound) - half_gap, 0.0), wound) + DAMPING * (omega - v)
        return np.array([v, omega, carried / LOAD, (given - carried - level * math.tanh(omega / 1e-3)) / ROTOR])

    for k, given in enumerate(force.tolist()):
        rows[k] = y[:2]
        for _ in range(12):
            a = slope(y, given)
            b = slope(y + 0.5 * h * a, given)
            c = slope(y + 0.5 * h * b, given)
            y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(y + h * c, given))
    noise = np.random.default_rng(1)
    rows += noise.normal(0.0, 2e-6, rows.shape)
    channels = {"q.lift": rows[:, 0], "theta.lift": rows[:, 1], "tau.lift": force + noise.normal(0.0, 0.02, len(t))}
    return fd.Recording(t, channels, meta={"units": {"q.lift": "m", "theta.lift": "m", "tau.lift": "N"}})


def elastic(folder: Path) -> fd.FlexibleJointModel:
    """Its model, without friction, with a gap of unknown width."""
    drive = {"rotor_inertia": ROTOR, "stiffness": STIFFNESS, "damping": DAMPING}
    effects = [{**BACKLASH, "half_gap": "unknown"}]
    return fd.FlexibleJointModel(slider(folder), {"lift": drive}, effects, gravity=[0.0] * 3, tolerance=0.03)


def test_a_gap(tmp_path: Path) -> None:
    """Half of 4 mm, and Coulomb friction that the file lacks."""
    found = fd.diagnose(elastic(tmp_path), [behind_a_gap(0.002, 2.0)], progress=False)
    check(found, ["coulomb_friction"], {"half_gap": 0.002})


def test_what_is_not_there_has_no_shape(tmp_path: Path) -> None:
    """One line with the key, and what to do."""
    with pytest.raises(fd.InputError, match=r"^effects\[0\].half_gap: these data do not tell it, got 'unknown'; give"):
        fd.diagnose(elastic(tmp_path), [behind_a_gap(0.0, 0.0)], progress=False)
    effects = [{**COULOMB, "level": "unknown"}, {**STRIBECK, "excess": "unknown", "velocity": "unknown"}]
    with pytest.raises(fd.InputError, match=r"^effects\[1\].velocity: these data do not tell it, got 'unknown'; give"):
        pushed(tmp_path, effects, lambda force, _x, v: force - 2.0 * sign(v))
