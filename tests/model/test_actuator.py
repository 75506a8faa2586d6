"""Actuators in the model file: written, read back, replaced, refused, calibrated."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import repickled
from tests.simulation.test_dc_motor import KT, N, R, model

HEAD = "flexdyn: 1\nrobot: {urdf: pendulum.urdf}\njoints:\n  swing: {gear_ratio: 8, rotor_inertia: 3.0e-5, actuator: "


def read(folder: Path, actuator: str, rest: str = "") -> fd.FlexibleJointModel:
    """A model file with an actuator."""
    model(folder)  # writes the URDF
    (folder / "arm.yaml").write_text(f"{HEAD}{actuator}}}\n{rest}")
    return fd.load_model(folder / "arm.yaml")


def test_there_and_back(tmp_path: Path) -> None:
    """Numbers that are left out are not written."""
    arm = read(tmp_path, "{dc_motor: {torque_constant: 0.04, resistance: 2.5, supply: 12}}")
    assert arm.joints["swing"].actuator == fd.Actuator(
        dc_motor=fd.DCMotor(torque_constant=KT, resistance=R, supply=12.0)
    )
    fd.save_model(arm, tmp_path / "again.yaml")
    assert "current_limit" not in (tmp_path / "again.yaml").read_text()
    assert fd.load_model(tmp_path / "again.yaml").joints == arm.joints
    assert repickled(arm) == arm


def test_with_firmware(tmp_path: Path) -> None:
    """Its settings are the servo's."""
    text = (
        "{dc_motor: {torque_constant: 0.04, resistance: 2.5}, firmware: {kp: 2, counts_per_turn: 4096, full_pwm: 885}}"
    )
    arm = read(tmp_path, text)
    actuator = arm.joints["swing"].actuator
    assert actuator is not None
    assert actuator.firmware == fd.Firmware(kp=2.0, counts_per_turn=4096, full_pwm=885)
    fd.save_model(arm, tmp_path / "again.yaml")
    assert fd.load_model(tmp_path / "again.yaml").joints == arm.joints


@pytest.mark.parametrize(
    ("actuator", "said"),
    [
        ("{dc_motr: {}}", "joints.swing.actuator.dc_motr: no such key; did you mean 'dc_motor'?"),
        ("{dc_motor: 3}", "joints.swing.actuator.dc_motor: a mapping is needed, got 3; its keys are torque_constant,"),
        ("{dc_motor: {resistance: 2}}", "joints.swing.actuator.dc_motor.torque_constant: the key is missing"),
        (
            "{dc_motor: {torque_constant: 0.04, resistance: 0}}",
            "joints.swing.actuator.dc_motor.resistance: a number above 0 is needed, got 0",
        ),
        ("{dc_motor: {torque_constant: 1, resistance: 2, suply: 3}}", "dc_motor.suply: no such key; did you"),
        ("{}", "joints.swing.actuator.dc_motor: the key is missing"),
    ],
)
def test_mistakes_are_one_line(tmp_path: Path, actuator: str, said: str) -> None:
    """With file, key and remedy."""
    with pytest.raises(InputError) as caught:
        read(tmp_path, actuator)
    line = str(caught.value)
    assert said in line
    assert "arm.yaml" in line
    assert "\n" not in line


def test_its_numbers_have_a_tolerance(tmp_path: Path) -> None:
    """By path, for one joint or for all; a path that leads nowhere is refused."""
    text = "{dc_motor: {torque_constant: 0.04, resistance: 2.5}}"
    rest = "tolerance: {'*': 0.03, joints.*.actuator.dc_motor.resistance: 0.1}\n"
    found = {number.parameter: number.tolerance for number in file_numbers(read(tmp_path, text, rest))}
    assert (found["torque_constant"], found["resistance"]) == (0.03, 0.1)
    with pytest.raises(InputError, match="no such number"):
        read(tmp_path, text, "tolerance: {joints.swing.actuator.dc_motor.supply: 0.1}\n")


def test_a_wrong_number_is_folded(tmp_path: Path) -> None:
    """Volts become the torque asked for by the file's numbers, before as after."""
    arm = model(tmp_path, [fd.effects.ParameterError("swing", parameter="torque_constant", factor=1.1)])
    true = arm.resolved().joints["swing"].actuator
    assert true is not None
    assert true.dc_motor.torque_constant == pytest.approx(1.1 * KT)
    assert true.per_volt(N) == arm.joints["swing"].actuator.per_volt(N) == pytest.approx(N * KT / R)
    (law,) = arm.resolved().motor_laws
    assert law.values == pytest.approx((1.1, (1.1 * N * KT) ** 2 / R, float("inf")))


def test_a_joint_can_lose_it(tmp_path: Path) -> None:
    """And is then driven by a torque."""
    bare = model(tmp_path).replace(joints={"swing": {"actuator": None}})
    assert bare.motor_laws == ()
    assert bare.joints["swing"].actuator is None
    with pytest.raises(InputError, match="the joint has no actuator"):
        bare.replace(effects=[fd.effects.ParameterError("swing", parameter="resistance", factor=1.1)])
