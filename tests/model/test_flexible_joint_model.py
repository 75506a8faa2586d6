"""FlexibleJointModel: immutable data that fits its robot, or one line on why not."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Payload, TransmissionDamping, ViscousFriction
from tests.arms import repickled


@pytest.fixture
def robot() -> fd.Robot:
    """The paper's two-link arm."""
    return fd.load_robot("scara_two_link")


ELASTIC = {"*": {"stiffness": 50.0, "rotor_inertia": 0.1}}


def test_numbers_stand_in_the_order_of_q(robot: fd.Robot) -> None:
    """K, D, J as locked arrays, one entry a joint."""
    joints = {"elbow": {"gear_ratio": 10.0, "rotor_inertia": 2e-3, "stiffness": 30.0, "damping": 0.5}}
    model = fd.FlexibleJointModel(robot, joints)
    np.testing.assert_array_equal(model.stiffness, [math.inf, 30.0])
    np.testing.assert_array_equal(model.damping, [0.0, 0.5])
    np.testing.assert_allclose(model.rotor_inertia, [0.0, 0.2])
    np.testing.assert_array_equal(model.elastic, [False, True])
    assert (model.n, model.joint_names, model.index("elbow")) == (2, ("shoulder", "elbow"), 1)


def test_a_model_does_not_change(robot: fd.Robot) -> None:
    """No attribute, mapping or array of it can be written to."""
    model = fd.FlexibleJointModel(robot, ELASTIC, initial={"q": {"elbow": 1.0}}, tolerance={"*": 0.1})
    with pytest.raises(AttributeError, match=r"use model\.replace\(gravity=\.\.\.\)"):
        model.gravity = (0.0, 0.0, 0.0)
    with pytest.raises(AttributeError):
        del model.robot
    for mapping in (model.joints, model.initial, model.initial["q"], model.tolerance):
        with pytest.raises(TypeError):
            mapping["elbow"] = 1.0  # type: ignore[index]
    with pytest.raises(ValueError, match="read-only"):
        model.stiffness[0] = 1.0


def test_what_it_was_made_of_may_change_afterwards(robot: fd.Robot) -> None:
    """Mappings and lists are copied at the border."""
    joints, initial, effects = {"elbow": {"damping": 1.0}}, {"q": {"elbow": 1.0}}, [Payload(mass=1.0)]
    model = fd.FlexibleJointModel(robot, joints, effects, initial=initial)
    joints["elbow"]["damping"], initial["q"]["elbow"] = 2.0, 2.0
    effects.clear()
    assert model.joints["elbow"].damping == 1.0
    assert model.initial["q"]["elbow"] == 1.0
    assert model.effects == (Payload(mass=1.0),)


@pytest.mark.parametrize("name", ["scara_two_link", "scara", "panda", "ur5"])
def test_shipped_models_pickle(name: str) -> None:
    """A model and what it simulates are the same after a trip to another process."""
    model = fd.load_model(name)
    again = repickled(model)
    assert again == model
    assert hash(again) == hash(model)
    assert again.name == model.name
    runs = [fd.simulate(each, None, 0.02) for each in (model, again)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_equality_is_by_content(robot: fd.Robot) -> None:
    """Models of equal content are equal; one number makes them differ."""
    model = fd.FlexibleJointModel(robot, ELASTIC)
    assert model == fd.FlexibleJointModel(fd.load_robot("scara_two_link"), dict(ELASTIC))
    assert model != model.replace(joints={"elbow": {"damping": 0.1}})
    assert model != model.replace(gravity=[0, 0, 0])
    assert model != model.replace(effects=[Payload(mass=0.1)])
    assert model != "a model"


def test_replace_merges_joints_number_by_number(robot: fd.Robot) -> None:
    """The name "*" changes every joint, a name one; everything else stays."""
    model = fd.FlexibleJointModel(robot, ELASTIC, [Payload(mass=0.2)], tolerance=0.1, name="mine")
    other = model.replace(joints={"*": {"damping": 1.0}, "elbow": {"stiffness": 80.0}})
    np.testing.assert_array_equal(other.stiffness, [50.0, 80.0])
    np.testing.assert_array_equal(other.damping, [1.0, 1.0])
    assert (other.effects, other.tolerance, other.name) == (model.effects, 0.1, "mine")
    np.testing.assert_array_equal(model.damping, [0.0, 0.0])
    with pytest.raises(fd.InputError, match=r"joints\.wrist: the robot has no such joint"):
        model.replace(joints={"wrist": {"damping": 1.0}})


def test_the_rigid_arm(robot: fd.Robot) -> None:
    """Every joint rigid with its J, transmissions' effects and rotors' first states gone; it simulates."""
    effects = [TransmissionDamping("elbow", coefficient=1.0), Payload(mass=0.2)]
    initial = {"q": {"elbow": 1.0}, "theta": {"elbow": 1.1}, "omega": {"elbow": 0.5}}
    rigid = fd.FlexibleJointModel(robot, ELASTIC, effects, initial=initial).rigid()
    assert not rigid.elastic.any()
    np.testing.assert_array_equal(rigid.rotor_inertia, [0.1, 0.1])
    assert rigid.effects == (Payload(mass=0.2),)
    assert fd.simulate(rigid, None, 0.01).q[0].tolist() == [0.0, 1.0]


def test_urdf_dynamics_become_effects(tmp_path: Path) -> None:
    """<dynamics damping friction> are link-side effects that come last and can be ignored."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="w"><link name="base"/><link name="w"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="2"/></inertial></link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="w"/>'
        '<dynamics damping="0.5" friction="0.2"/></joint></robot>',
        encoding="utf-8",
    )
    model = fd.FlexibleJointModel(fd.load_robot(path), effects=[Payload(mass=1.0)])
    assert model.effects == (Payload(mass=1.0),)
    assert model.all_effects[1:] == (
        ViscousFriction("turn", side="link", coefficient=0.5),
        CoulombFriction("turn", side="link", level=0.2),
    )
    assert model.replace(urdf_dynamics="ignore").all_effects == model.effects


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"robot": "scara"}, "robot: a Robot is needed"),
        ({"gravity": [0, 0]}, "robot.gravity: three numbers are needed"),
        ({"gravity": "123"}, "robot.gravity: three numbers are needed"),
        ({"gravity": 9.81}, "robot.gravity: three numbers are needed"),
        ({"gravity": {1.0: 0, 2.0: 0, 3.0: 0}}, "robot.gravity: three numbers are needed"),
        ({"gravity": [0, 0, math.nan]}, "robot.gravity: three numbers are needed"),
        ({"gravity": [0, 0, 10**400]}, "robot.gravity: three numbers are needed"),
        ({"urdf_dynamics": "yes"}, "robot.urdf_dynamics: no such choice, got 'yes'; it is use or ignore"),
        ({"rotor_coupling": 1}, "robot.rotor_coupling: no such choice"),
        ({"initial": [1]}, "initial: a mapping is needed"),
        ({"initial": {"p": {}}}, "initial.p: no such signal"),
        ({"initial": {"thta": {}}}, "initial.thta: no such signal; did you mean 'theta'?"),
        ({"initial": {"q": 1.0}}, "initial.q: a mapping by joint is needed"),
        ({"initial": {"q": {"elbw": 1.0}}}, "initial.q.elbw: the robot has no such joint; did you mean 'elbow'?"),
        ({"initial": {"q": {"elbow": math.inf}}}, "initial.q.elbow: a finite number is needed"),
        ({"initial": {"q": {"elbow": 10**400}}}, "initial.q.elbow: a finite number is needed"),
        ({"tolerance": -0.1}, "tolerance: a number of at least 0 is needed"),
        ({"tolerance": "3 %"}, "tolerance: a number of at least 0 is needed"),
        ({"tolerance": math.inf}, "tolerance: a number of at least 0 is needed"),
        ({"tolerance": {"joints.elbow.stiffness": -1}}, "tolerance.joints.elbow.stiffness: a number of at least 0"),
        ({"effects": [3]}, "effects[0]: an effect is a mapping, got 3"),
        ({"effects": [Payload(mass=1.0, frame="tol")]}, "effects[0].frame: no such frame, got 'tol'"),
        ({"effects": [Payload(mass=1.0, frame="base")]}, "effects[0].frame: a mass on the base has no effect"),
        ({"effects": [Payload(mass=1.0, frame="")]}, "effects[0].frame: no such frame"),
        ({"effects": [TransmissionDamping("elbow", coefficient=1.0)]}, "effects[0].joint: transmission_damping needs"),
        ({"effects": [ViscousFriction("elbw", side="link", coefficient=1.0)]}, "effects[0].joint: no such joint"),
    ],
)
def test_a_mistake_is_one_line(robot: fd.Robot, settings: dict[str, Any], words: str) -> None:
    """It names the key, and the near miss where there is one."""
    with pytest.raises(fd.InputError) as caught:
        fd.FlexibleJointModel(**({"robot": robot} | settings))
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value)


def test_a_link_without_inertia_is_refused(tmp_path: Path) -> None:
    """A joint that turns nothing has no acceleration: a clear line, not a NaN."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="w"><link name="base"/><link name="w"/>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="w"/></joint></robot>',
        encoding="utf-8",
    )
    robot = fd.load_robot(path)
    with pytest.raises(fd.InputError, match=r"^joints\.turn: the joint moves no inertia"):
        fd.simulate(fd.FlexibleJointModel(robot), [1.0], 0.1)
    carried = fd.FlexibleJointModel(robot, {"turn": {"rotor_inertia": 0.5}})
    assert fd.simulate(carried, [1.0], 1.0).q[-1, 0] == pytest.approx(1.0)
