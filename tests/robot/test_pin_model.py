"""A robot made from a Pinocchio model: normalised like a URDF, refused where it is no fixed-base arm."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.errors import InputError
from flexdyn.robot import load_robot

BODY = pin.Inertia(1.0, np.array([0.1, 0.0, 0.2]), np.diag([0.1, 0.2, 0.15]))


def chain(*joints: object) -> pin.Model:
    """A serial model of these joints."""
    model = pin.Model()
    for k, joint in enumerate(joints):
        placement = pin.SE3(pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), np.array([0.1, 0.2, 0.3]))
        index = model.addJoint(k, joint, placement, f"j{k + 1}")
        model.appendBodyToJoint(index, BODY, pin.SE3.Identity())
    return model


def test_a_model_gives_the_robot_of_its_file(zoo: Path) -> None:
    """The same arrays, apart from mimics, which Pinocchio's reader leaves out."""
    model = pin.buildModelFromUrdf(str(zoo))
    from_file, from_model = load_robot(zoo), load_robot(model)
    assert from_model.source is None
    assert from_model.joint_names == ("turn", "elbow", *list(model.names)[3:])
    one, two = from_file.tree, from_model.tree
    for name in ("parent", "prismatic", "axis", "rotation", "translation", "mass", "com", "inertia", "armature"):
        assert np.allclose(getattr(one, name), getattr(two, name), atol=1e-14), name
    both = [from_model.joint_names.index(name) for name in from_file.joint_names]
    assert np.array_equal(from_model.lower[both], from_file.lower)
    assert np.array_equal(from_model.effort_limit[both], from_file.effort_limit)
    assert from_model.friction[from_model.joint_index("side")] == 0.6
    assert from_model.damping[from_model.joint_index("turn")] == 0.3
    assert from_model.continuous[from_model.joint_index("spin")]
    assert from_model.visual_model().ngeoms == 0


def test_the_model_given_is_not_changed_nor_held() -> None:
    """Later changes of it do not reach the robot."""
    model = pin.buildSampleModelManipulator()
    before = model.copy()
    robot = load_robot(model)
    assert model == before
    model.armature = np.ones(model.nv)
    assert not robot.tree.armature.any()


def test_fields_of_a_model_reach_the_robot() -> None:
    """Armature, damping, gravity and limits; friction set as model.friction = ... counts for both directions."""
    model = chain(pin.JointModelRX(), pin.JointModelRUBY(), pin.JointModelPrismaticUnaligned(0.0, 0.6, 0.8))
    model.armature, model.damping = np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3])
    model.friction = np.array([4.0, 5.0, 6.0])
    model.gravity = pin.Motion(np.array([0, 1.0, 2.0, 0, 0, 0]))
    robot = load_robot(model, name="mine")
    assert robot.name == "mine"
    assert np.array_equal(robot.tree.armature, [1, 2, 3])
    assert np.array_equal(robot.damping, [0.1, 0.2, 0.3])
    assert np.array_equal(robot.friction, [4, 5, 6])
    assert np.array_equal(robot.upper, [np.inf] * 3)
    assert np.array_equal(robot.lower, [-np.inf] * 3)
    assert np.array_equal(robot.pin_model.gravity.linear, [0, 1, 2])
    assert robot.continuous == (False, True, False)
    assert np.array_equal(load_robot(model, lock={"j1": 0.5}).tree.armature, [2, 3])
    assert robot.tip == "j3"


@pytest.mark.parametrize(
    "joint",
    [
        pin.JointModelFreeFlyer(),
        pin.JointModelSpherical(),
        pin.JointModelSphericalZYX(),
        pin.JointModelPlanar(),
        pin.JointModelTranslation(),
        pin.JointModelHX(0.1),
        pin.JointModelComposite(pin.JointModelRX()),
        pin.JointModelUniversal(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])),
    ],
    ids=lambda joint: joint.shortname(),
)
def test_joints_of_no_fixed_base_arm_are_refused(joint: object) -> None:
    """By name and kind, with the remedy."""
    with pytest.raises(InputError, match=r"joint 'j2': a joint of kind \w+; flexdyn models fixed-base arms"):
        load_robot(chain(pin.JointModelRX(), joint))


def test_a_free_flying_base_is_refused() -> None:
    """As Pinocchio's reader puts it on a robot."""
    with pytest.raises(InputError, match=r"root_joint.*FreeFlyer.*fixed-base"):
        load_robot(pin.buildSampleModelHumanoid())


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_mimic_joints_of_pinocchio_become_followers(
    write: Callable[..., Path], text: Callable[..., str], kind: str
) -> None:
    """A model read with mimic=True has the projected dynamics that Pinocchio gives it, and its leader's order."""
    mimic = '<limit effort="1" velocity="1" lower="0" upper="1"/><mimic joint="{}" multiplier="{}" offset="{}"/>'
    inside = "".join(text("link", name) for name in "abcd") + text("joint", "one", kind, "a", "b", "0 0.6 0.8")
    inside += text("joint", "two", kind, "b", "c", "0 0 -1", mimic.format("one", -2, 0.1))
    inside += text("joint", "three", "prismatic", "c", "d", "2 0 0")
    path = write(inside)
    own = pin.buildModelFromUrdf(str(path), mimic=True)
    robot, from_file = load_robot(own), load_robot(path)
    assert robot.joint_names == from_file.joint_names == ("one", "three")
    assert robot.followers == {"two": ("one", -2.0, 0.1)}
    model, gain, data = robot.pin_model, robot.tree.gain, own.createData()
    rng = np.random.default_rng(6)
    q, v, a = rng.normal(size=2), rng.normal(size=2), rng.normal(size=2)
    state = q if kind == "revolute" else np.array([np.cos(q[0]), np.sin(q[0]), q[1]])
    torque = gain.T @ pin.rnea(model, model.createData(), robot.expand(q), gain @ v, gain @ a)
    assert np.allclose(torque, pin.rnea(own, data, state, v, a), rtol=1e-10)
    assert np.allclose(robot.tree.axis, from_file.tree.axis)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("armature", -1.0, "joint 'j1'/armature.*-1"),
        ("damping", np.nan, "joint 'j1'/damping.*nan"),
        ("friction", -2.0, "joint 'j1'/friction"),
        ("lowerDryFrictionLimit", -2.0, "friction differs by direction.*asymmetric_friction"),
        ("upperPositionLimit", np.nan, "joint 'j1'/limit"),
    ],
)
def test_numbers_no_joint_can_have_are_refused(field: str, value: float, words: str) -> None:
    """With the joint and the field."""
    model = chain(pin.JointModelRX())
    setattr(model, field, np.array([value]))
    with pytest.raises(InputError, match=words):
        load_robot(model)


def test_branches_that_are_not_together_are_refused() -> None:
    """Two arms side by side, their joints added in turns: Pinocchio's M(q) mixes them up, and nothing would say so."""

    def pair(parents: tuple[int, ...]) -> pin.Model:
        model = pin.Model()
        for k, parent in enumerate(parents):
            joint = model.addJoint(parent, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.1, 0.0, 0.5])), f"j{k}")
            model.appendBodyToJoint(joint, BODY, pin.SE3.Identity())
        return model

    mixed, together = pair((0, 0, 1, 2)), pair((0, 1, 0, 3))
    masses = np.linalg.eigvalsh(pin.crba(together, together.createData(), np.zeros(4)))
    assert not np.allclose(np.linalg.eigvalsh(pin.crba(mixed, mixed.createData(), np.zeros(4))), masses)
    assert load_robot(together).n == 4
    with pytest.raises(InputError, match=r"joint 'j2'.*'j0' after another branch"):
        load_robot(mixed)


def test_bodies_that_cannot_be_are_refused() -> None:
    """Negative mass, an inertia that is not positive, a placement that is not finite."""
    for field, value in (("mass", -1.0), ("lever", np.full(3, np.nan)), ("inertia", np.diag([-1.0, 1.0, 1.0]))):
        model = chain(pin.JointModelRX())
        setattr(model.inertias[1], field, value)
        with pytest.raises(InputError, match="joint 'j1'"):
            load_robot(model)
    model = pin.Model()
    model.addJoint(0, pin.JointModelRX(), pin.SE3(np.eye(3), np.full(3, np.inf)), "j1")
    with pytest.raises(InputError, match="joint 'j1': its placement is not finite"):
        load_robot(model)


def test_an_empty_model_has_nothing_to_move() -> None:
    """One line."""
    with pytest.raises(InputError, match="no joint that moves"):
        load_robot(pin.Model())
