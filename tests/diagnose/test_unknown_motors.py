"""A torque constant or a resistance that nobody knows is estimated from volts where the other one is known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.diagnose.test_unknown_sizes import unknown
from tests.simulation.test_dc_motor import KT, ROD, ROTOR, N, R, model

RATE, INSIDE, SUPPLY, WEIGHT = 500.0, 8, 12.0, 0.49 * 9.81 * 0.1


def driven(command: str, coefficient: float, level: float) -> fd.Recording:
    """A pendulum on a geared motor under voltage, Runge and Kutta's method; the motor's encoder has noise.

    Args:
        command: what is recorded, ``voltage`` or ``duty``.
        coefficient: of viscous friction [N m s/rad].
        level: of dry friction [N m].
    """
    t, h = np.arange(5000) / RATE, 1.0 / RATE / INSIDE
    volts = 1.8 * np.sin(1.3 * t) + np.sin(4.1 * t) + 0.5 * np.sin(9.3 * t + 1.0)
    k, x, v, seen = N * KT, 0.0, 0.0, []

    def speed_up(volt: float, x: float, v: float) -> float:
        torque = k * (volt - k * v) / R - coefficient * v - level * math.tanh(v / 1e-4) - WEIGHT * math.sin(x)
        return torque / (ROTOR + ROD)

    for volt in volts.tolist():
        seen.append(x)
        for _ in range(INSIDE):
            a = speed_up(volt, x, v)
            b = speed_up(volt, x + 0.5 * h * v, v + 0.5 * h * a)
            c = speed_up(volt, x + 0.5 * h * (v + 0.5 * h * a), v + 0.5 * h * b)
            d = speed_up(volt, x + h * (v + 0.5 * h * b), v + h * c)
            x, v = x + h * (v + h / 6.0 * (a + b + c)), v + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    theta = np.array(seen) + np.random.default_rng(0).normal(0.0, 2e-5, len(t))
    return fd.Recording(t, {f"{command}.swing": volts / (SUPPLY if command == "duty" else 1.0), "theta.swing": theta})


def arm(folder: Path, motor: dict[str, Any], **joint: Any) -> fd.FlexibleJointModel:
    """Its model without friction, of which numbers of the motor are unknown."""
    made: fd.FlexibleJointModel = model(folder, gravity=9.81, motor={"supply": SUPPLY, **motor}, **joint)
    assert isinstance(made.tolerance, Mapping)
    return made.replace(tolerance={**made.tolerance, "*": 0.03})


@pytest.mark.parametrize("command", ["voltage", "duty"])
@pytest.mark.parametrize(("number", "true"), [("torque_constant", KT), ("resistance", R)])
def test_one_number_of_a_motor(tmp_path: Path, command: str, number: str, true: float) -> None:
    """Beside viscous and dry friction that the file lacks; the other number has its tolerance of 3 %."""
    found = fd.diagnose(arm(tmp_path, {number: "unknown"}), [driven(command, 0.012, 0.03)], progress=False)
    assert {each.suspect.effect for each in found.findings} == {"coulomb_friction", "viscous_friction"}
    value, std = unknown(found)[number]
    assert abs(value - true) < 2.0 * std < 0.15 * true
    words = f"The {number.replace('_', ' ')} of swing was not known: it is estimated as"
    assert any(note.startswith(words) for note in found.notes)
    found.save(tmp_path / "answer")
    drive = fd.load_model(tmp_path / "answer" / "model.yaml").joints["swing"].actuator
    assert drive is not None
    assert getattr(drive.dc_motor, number) == pytest.approx(value)


def test_a_motor_that_turns_the_other_way(tmp_path: Path) -> None:
    """All signals are reflected; only the ratio's sign is another one, and with it that of the volts."""
    record = driven("voltage", 0.0, 0.0)
    turned = fd.Recording(record.t, {"voltage.swing": -record["voltage.swing"], "theta.swing": record["theta.swing"]})
    found = fd.diagnose(arm(tmp_path, {"resistance": "unknown"}, gear_ratio=-N), [turned], progress=False)
    value, std = unknown(found)["resistance"]
    assert abs(value - R) < 2.0 * std < 0.15 * R


def test_two_numbers_of_a_motor_are_too_many(tmp_path: Path) -> None:
    """Viscous friction makes up for a change of both."""
    motor = {"torque_constant": "unknown", "resistance": "unknown"}
    words = (
        r"^joints.swing.actuator.dc_motor.torque_constant: torque constant and resistance are both unknown, got 'unk"
    )
    with pytest.raises(fd.InputError, match=words):
        fd.diagnose(arm(tmp_path, motor), [driven("voltage", 0.0, 0.0)], progress=False)


def test_a_motor_that_hardly_works(tmp_path: Path) -> None:
    """Steady turning without load tells back-EMF and no resistance: it takes no torque."""
    t = np.arange(3000) / RATE
    theta = 0.5 * t + np.random.default_rng(0).normal(0.0, 2e-5, len(t))
    steady = fd.Recording(t, {"voltage.swing": np.full(len(t), N * KT * 0.5), "theta.swing": theta})
    flywheel = model(tmp_path, motor={"resistance": "unknown"})
    words = r"^joints.swing.actuator.dc_motor.resistance: these data do not tell it, got 'unknown'; give it with a tol"
    with pytest.raises(fd.InputError, match=words):
        fd.diagnose(flywheel, [steady], progress=False)


def test_a_torque_constant_is_not_called_wrong_beside_an_unknown_resistance(tmp_path: Path) -> None:
    """Its tolerance is taken for right: a change of both numbers is the same as the viscous friction of this elbow."""
    motor = {"torque_constant": 0.05, "resistance": 2.0, "supply": 48.0}
    drive = {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5, "gear_ratio": 50.0}
    t = np.arange(3000) / RATE
    volts = np.stack([12.0 * np.sin(1.3 * t) + 3.0 * np.sin(9.3 * t), 8.0 * np.sin(1.7 * t) + 3.0 * np.sin(11.0 * t)])
    asked = {f"voltage.{joint}": each for joint, each in zip(("shoulder", "elbow"), volts, strict=True)}
    given = fd.load_model("scara_two_link").replace(
        joints={"*": {**drive, "actuator": {"dc_motor": motor}}}, effects=[], tolerance=0.03
    )
    rubbing = fd.effects.ViscousFriction("elbow", side="motor", coefficient=3.0)
    run = fd.simulate(given.replace(effects=[rubbing]), fd.Recording(t, asked), rate=RATE)
    seen, noise = run.to_recording(), np.random.default_rng(0)
    channels = [f"{signal}.{joint}" for signal in ("q", "theta") for joint in given.joint_names]
    noisy = {name: seen[name] + noise.normal(0.0, 5e-6, len(run.t)) for name in channels}
    record = fd.Recording(run.t, noisy | {name: each[: len(run.t)] for name, each in asked.items()})
    lacking = given.replace(joints={"elbow": {"actuator": {"dc_motor": {**motor, "resistance": "unknown"}}}})
    found = fd.diagnose(lacking, [record], progress=False)
    assert [(each.suspect.effect, each.suspect.joint) for each in found.findings] == [("viscous_friction", "elbow")]
    value, std = unknown(found)["resistance"]
    assert abs(value - 2.0) < 2.0 * std < 0.15 * 2.0
