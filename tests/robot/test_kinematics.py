"""Forward kinematics by arrays, against Pinocchio's, position by position."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.errors import InputError
from flexdyn.robot import Robot, frame_positions, load_robot


def by_pinocchio(robot: Robot, q: np.ndarray, frame: str) -> np.ndarray:
    """Origin of a frame at positions q (samples, n)."""
    model = robot.pin_model
    data, place = model.createData(), robot.frame(frame)
    found = []
    for q_tree in robot.expand(q):
        pin.forwardKinematics(model, data, q_tree)
        found.append(data.oMi[place.joint + 1].act(place.translation))
    return np.array(found)


def places(robot: Robot) -> list[str]:
    """All its links' and joints' frames."""
    return [name for name in robot.frame_names if name != "universe"]


def test_every_frame_of_every_kind_of_joint(zoo: Path) -> None:
    """Turning, sliding and endless joints about crooked axes, a fixed one, one that mimics: every frame is in place."""
    robot = load_robot(zoo)
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (20, robot.n))
    for frame in places(robot):
        np.testing.assert_allclose(frame_positions(robot, q, frame), by_pinocchio(robot, q, frame), atol=1e-13)


@pytest.mark.parametrize("name", ["scara_two_link", "scara", "ur5"])
def test_the_tip_of_known_arms(name: str) -> None:
    """The last frame is taken where none is named, and none moves with no joint."""
    robot = load_robot(name)
    q = np.random.default_rng(2).uniform(-3.0, 3.0, (30, robot.n))
    np.testing.assert_allclose(frame_positions(robot, q), by_pinocchio(robot, q, robot.tip), atol=1e-13)
    assert np.ptp(frame_positions(robot, q, robot.frame_names[1]), axis=0).max() == 0.0


@pytest.mark.parametrize("name", ["scara_two_link", "ur5"])
def test_positions_do_not_know_of_each_other(name: str) -> None:
    """However many are computed at once and in whatever shape, each is the same to the last bit."""
    robot = load_robot(name)
    q = np.random.default_rng(3).uniform(-3.0, 3.0, (5, 7, robot.n))
    together = frame_positions(robot, q)
    assert together.shape == (5, 7, 3)
    for i, j in np.ndindex(5, 7):
        np.testing.assert_array_equal(frame_positions(robot, q[i, j]), together[i, j])
        np.testing.assert_array_equal(frame_positions(robot, q[i, j:])[0], together[i, j])


def test_a_frame_that_is_not_there() -> None:
    """It is named, with the near miss."""
    with pytest.raises(InputError, match="no such frame, got 'tol'; did you mean 'tool'"):
        frame_positions(load_robot("scara_two_link"), np.zeros((1, 2)), "tol")
