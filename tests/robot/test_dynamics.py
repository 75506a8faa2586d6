"""The normalised tree moves as the robot that Pinocchio reads from the same file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flexdyn.robot import Robot, Tree, load_robot

SOURCES = ("zoo", "kinova", "double_pendulum_continuous", "pr2")


def original_state(model: pin.Model, robot: Robot, q: np.ndarray) -> np.ndarray:
    """The configuration of Pinocchio's own model: cosine and sine for an unbounded joint."""
    made = robot.pin_model
    state: np.ndarray = np.asarray(pin.neutral(model))
    for index in range(1, model.njoints):
        angle = q[made.idx_qs[made.getJointId(model.names[index])]]
        at = model.idx_qs[index]
        if model.nqs[index] == 2:
            state[at : at + 2] = np.cos(angle), np.sin(angle)
        else:
            state[at] = angle
    return state


def urdf_of(robot: Robot) -> str:
    """The file that a known name means."""
    from flexdyn.robot.names import find_robot

    return str(find_robot(robot.source)[0]) if robot.source else ""


@pytest.mark.parametrize("source", SOURCES)
def test_unwrapped_continuous_joints_have_the_dynamics_of_wrapped_ones(source: str, zoo: Path) -> None:
    """M and inverse dynamics at an angle of several turns equal Pinocchio's at its cosine and sine."""
    robot = load_robot(zoo if source == "zoo" else source)
    original, model = pin.buildModelFromUrdf(urdf_of(robot)), robot.pin_model
    rng = np.random.default_rng(1)
    assert original.nq > original.nv == model.nq == model.nv
    assert list(original.names) == list(model.names)
    data, wrapped = model.createData(), original.createData()
    for _ in range(20):
        q, v, a = rng.uniform(-9, 9, model.nv), rng.normal(size=model.nv), rng.normal(size=model.nv)
        state = original_state(original, robot, q)
        assert np.allclose(pin.crba(model, data, q), pin.crba(original, wrapped, state), rtol=1e-11, atol=1e-12)
        assert np.allclose(pin.rnea(model, data, q, v, a), pin.rnea(original, wrapped, state, v, a), rtol=1e-10)


def test_mimic_map_projects_to_pinocchios_own_mimic_joints() -> None:
    """G^T M G and G^T tau of the Panda's gripper equal Pinocchio's model built with mimic joints."""
    robot = load_robot("panda")
    model, own = robot.pin_model, pin.buildModelFromUrdf(urdf_of(robot), mimic=True)
    assert own.nv == robot.n == 8
    assert robot.followers == {"panda_finger_joint2": ("panda_finger_joint1", 1.0, 0.0)}
    data, peer, gain = model.createData(), own.createData(), robot.tree.gain
    rng = np.random.default_rng(2)
    for _ in range(20):
        q, v, a = rng.normal(size=8), rng.normal(size=8), rng.normal(size=8)
        mass = gain.T @ pin.crba(model, data, robot.expand(q)) @ gain
        own_mass = pin.crba(own, peer, q)
        own_mass = np.triu(own_mass) + np.triu(own_mass, 1).T
        assert np.allclose(mass, own_mass, rtol=1e-11, atol=1e-12)
        torque = gain.T @ pin.rnea(model, data, robot.expand(q), gain @ v, gain @ a)
        assert np.allclose(torque, pin.rnea(own, peer, q, v, a), rtol=1e-10)


def test_chains_of_mimics_resolve_to_their_leader(zoo: Path) -> None:
    """Far = 0.1 (-1.5 elbow + 0.2) - 0.05, for one state and for many."""
    robot = load_robot(zoo)
    assert robot.joint_names == ("turn", "elbow", "slide", "spin")
    leader, *numbers = robot.followers["far"]
    assert leader == "elbow"
    assert numbers == pytest.approx([-0.15, -0.03])
    names = list(robot.pin_model.names)[1:]
    q = np.array([0.3, 0.7, -0.2, 9.0])
    expected = {"turn": 0.3, "elbow": 0.7, "slide": -0.2, "spin": 9.0, "side": -0.85, "far": -0.135}
    assert np.allclose(robot.expand(q), [expected[name] for name in names])
    assert np.allclose(robot.expand(np.stack([q, q])), [[expected[name] for name in names]] * 2)


@settings(max_examples=30, deadline=None)
@given(q=arrays(float, 8, elements=st.floats(-3, 3)), v=arrays(float, 8, elements=st.floats(-2, 2)))
def test_velocity_map_is_the_derivative_of_the_position_map(q: np.ndarray, v: np.ndarray) -> None:
    """Kinetic energy from G v equals that of a tree displaced along the mimic map."""
    robot = PANDA
    model, step = robot.pin_model, 1e-6
    data = model.createData()
    speed = (robot.expand(q + step * v) - robot.expand(q - step * v)) / (2 * step)
    projected = robot.tree.gain.T @ pin.crba(model, data, robot.expand(q)) @ robot.tree.gain
    energy = pin.computeKineticEnergy(model, data, robot.expand(q), speed)
    assert energy == pytest.approx(0.5 * v @ projected @ v, rel=1e-6, abs=1e-9)


PANDA = load_robot("panda")


@pytest.mark.parametrize("locked", [{"slide": 0.4}, {"turn": 7.0, "spin": -4.0}, {"elbow": 0.6}])
def test_a_locked_joint_is_held_still_and_carried_along(zoo: Path, locked: dict[str, float]) -> None:
    """M and gravity of the reduced arm are the rows of the full arm's that are still free; followers of a locked
    leader are held where it puts them.
    """
    full, robot = load_robot(zoo), load_robot(zoo, lock=locked)
    assert robot.joint_names == tuple(name for name in full.joint_names if name not in locked)
    assert robot.lock == locked
    whole, model = full.pin_model, robot.pin_model
    rng = np.random.default_rng(3)
    keep = [full.joint_names.index(name) for name in robot.joint_names]
    for _ in range(10):
        q, v, a = (rng.normal(size=robot.n) for _ in range(3))
        q_full, v_full, a_full = (np.zeros(full.n) for _ in range(3))
        q_full[keep], v_full[keep], a_full[keep] = q, v, a
        for name, value in locked.items():
            q_full[full.joint_names.index(name)] = value
        big, small = full.tree.gain, robot.tree.gain
        torque = small.T @ pin.rnea(model, model.createData(), robot.expand(q), small @ v, small @ a)
        whole_q = full.expand(q_full)
        whole_torque = big.T @ pin.rnea(whole, whole.createData(), whole_q, big @ v_full, big @ a_full)
        assert np.allclose(torque, whole_torque[keep], rtol=1e-10, atol=1e-11)


def test_the_arrays_alone_rebuild_the_arm(zoo: Path, rebuild: Callable[[Tree], pin.Model]) -> None:
    """A model built from nothing but the Tree gives the same M, bias and gravity."""
    robot = load_robot(zoo)
    model, again = robot.pin_model, rebuild(robot.tree)
    rng = np.random.default_rng(4)
    q, v, a = (rng.normal(size=robot.tree.m) for _ in range(3))
    assert np.allclose(pin.crba(model, model.createData(), q), pin.crba(again, again.createData(), q), rtol=1e-11)
    one, two = pin.rnea(model, model.createData(), q, v, a), pin.rnea(again, again.createData(), q, v, a)
    assert np.allclose(one, two, rtol=1e-10)


@pytest.mark.parametrize("frame", ["tool", "upper"])
def test_a_payload_is_a_point_mass_on_its_frame(arm: Path, frame: str, rebuild: Callable[[Tree], pin.Model]) -> None:
    """Parallel axis theorem: the same M and gravity as Pinocchio with the body appended."""
    robot = load_robot(arm)
    placement = robot.frame(frame)
    loaded = rebuild(robot.tree.with_point_mass(placement, 2.5))
    expected = robot.pin_model
    body = pin.Inertia(2.5, np.zeros(3), np.zeros((3, 3)))
    expected.appendBodyToJoint(placement.joint + 1, body, pin.SE3(placement.rotation, placement.translation))
    q = np.array([0.4, -1.1])
    for algorithm in (pin.crba, pin.computeGeneralizedGravity):
        one, two = algorithm(loaded, loaded.createData(), q), algorithm(expected, expected.createData(), q)
        assert np.allclose(one, two, rtol=1e-11)
    assert robot.tree.mass[placement.joint] == pytest.approx(expected.inertias[placement.joint + 1].mass - 2.5)


def test_armature_reaches_the_arrays_and_the_mass_matrix(rebuild: Callable[[Tree], pin.Model]) -> None:
    """Armature set on a Pinocchio model stands on the diagonal of M."""
    model = pin.buildSampleModelManipulator()
    plain = pin.crba(model, model.createData(), pin.neutral(model))
    model.armature = np.arange(1.0, model.nv + 1)
    robot = load_robot(model)
    again = rebuild(robot.tree)
    heavy = pin.crba(again, again.createData(), np.zeros(robot.n))
    assert np.allclose(np.triu(heavy - plain), np.diag(model.armature))
