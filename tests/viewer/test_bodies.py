"""What links look like where no file says so: bodies with the inertia that the model has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.robot.meshes import MeshWarning
from flexdyn.viewer.bodies import bodies_of, box_of
from tests.viewer.arms import SHAPELESS, shapeless

BOX = '<box size="0.3 0.05 0.05"/>'


def test_the_box_has_the_inertia() -> None:
    """Integrated over the box with even density, mass and inertia tensor come back, turned axes included."""
    rng = np.random.default_rng(1)
    edges, mass = np.array([0.1, 0.4, 0.9]), 3.0
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    second = turn @ np.diag(mass * edges**2 / 12.0) @ turn.T
    inertia = np.trace(second) * np.eye(3) - second
    found, axes = box_of(mass, inertia, 0.0, np.inf)
    assert sorted(found) == pytest.approx(edges)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    # Each edge lies along the direction that the box has it in, either way.
    assert np.abs(axes.T @ turn)[np.argsort(found)] == pytest.approx(np.eye(3), abs=1e-9)


def test_a_point_and_a_nonsense_inertia_are_drawn_with_bounded_edges() -> None:
    """A point mass is still seen, and moments that fit no body do not fill the picture."""
    assert box_of(1.0, np.zeros((3, 3)), 0.02, 0.8)[0].tolist() == [0.02] * 3
    assert box_of(1e-3, 1e3 * np.eye(3), 0.02, 0.8)[0].tolist() == [0.8] * 3


def test_every_joint_of_an_arm_without_shapes_moves_a_body(tmp_path: Path) -> None:
    """Mimic joints too, and the arm stands on something; a note says where the bodies come from."""
    model = shapeless(tmp_path)
    bodies, notes = bodies_of(model.robot, 1.0)
    assert {body.joint for body in bodies} == {-1, 0, 1, 2, 3}
    assert "bodies are drawn from the inertias" in notes[0]


def test_a_pin_model_is_drawn() -> None:
    """A robot that came as a pin.Model has no shapes either."""
    robot = fd.load_robot(fd.load_model("ur5").robot.pin_model)
    assert {body.joint for body in bodies_of(robot, 1.0)[0]} >= set(range(6))


def test_a_missing_mesh_is_replaced_by_the_body_of_its_inertia(tmp_path: Path) -> None:
    """The link is drawn all the same, and a note names its joint."""
    text = SHAPELESS.format(joint="shoulder", name="arm")
    for link, shape in (("base", BOX), ("upper", BOX), ("lower", '<mesh filename="gone.stl"/>'), ("finger", BOX)):
        shown = f'<link name="{link}"><visual><geometry>{shape}</geometry></visual>'
        text = text.replace(f'<link name="{link}"/>', f"{shown}</link>").replace(f'<link name="{link}">', shown)
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.warns(MeshWarning, match=r"gone\.stl"):
        robot = fd.load_robot(path)
    bodies, notes = bodies_of(robot, 2.0)
    assert notes == ("no shapes, drawn from its inertia: what moves with elbow, other_grip",)
    assert {body.joint for body in bodies} == {-1, 0, 1, 2, 3}


@pytest.mark.parametrize("name", ["scara_two_link", "scara", "panda", "ur5"])
def test_shipped_arms_are_drawn_with_their_own_shapes(name: str) -> None:
    """Every link has shapes, meshes among them, and there is nothing to note."""
    robot = fd.load_model(name).robot
    bodies, notes = bodies_of(robot, 1.0)
    assert notes == ()
    assert {body.joint for body in bodies} == set(range(-1, robot.tree.m))
