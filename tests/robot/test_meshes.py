"""Meshes are looked up without leaving their package or the disk, and what is missing is told once."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.records.apart import caller
from flexdyn.records.apart.messages import Lost
from flexdyn.robot import load_robot, meshes
from flexdyn.robot.meshes import MAX_MESH_BYTES, MeshWarning

TRIANGLE = (
    "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid t\n"
)


def arm_with(*addresses: str) -> str:
    """A one-joint arm whose moving link shows these meshes."""
    shapes = "".join(
        f'<visual><origin xyz="0 0 {k}"/><geometry><mesh filename="{address}" scale="2 2 2"/></geometry></visual>'
        for k, address in enumerate(addresses, start=1)
    )
    return (
        f'<link name="base"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
        f'<link name="moving">{shapes}</link><joint name="j" type="continuous"><parent link="base"/>'
        '<child link="moving"/><origin xyz="1 0 0"/></joint>'
    )


def put(path: Path) -> Path:
    """A small STL mesh at a path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(TRIANGLE)
    return path


def shown(path: Path, **options: object) -> list[str]:
    """Mesh files that a robot shows."""
    geometry = load_robot(path, **options).visual_model()  # type: ignore[arg-type]
    return [item.meshPath for item in geometry.geometryObjects if item.meshPath not in ("SPHERE", "BOX", "CYLINDER")]


def test_addresses_are_looked_up_where_people_keep_meshes(
    tmp_path: Path, write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside the URDF, in an ancestor's package, in package_dirs (holding a package or being one), by ROS variables."""
    spots = {
        "meshes/beside.stl": tmp_path / "meshes/beside.stl",
        f"package://{tmp_path.name}/own.stl": tmp_path / "own.stl",
        "package://near/m.stl": tmp_path / "near/m.stl",
        "package://held/m.stl": tmp_path / "elsewhere/held/m.stl",
        "package://renamed/sub/m.stl": tmp_path / "checkout/sub/m.stl",
        "package://ros/m.stl": tmp_path / "ws/ros/m.stl",
        "package:///ros2/m.stl": tmp_path / "install/share/ros2/m.stl",
        f"file://{tmp_path}/abs.STL": tmp_path / "abs.STL",
    }
    for spot in spots.values():
        put(spot)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path}/ws")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}/install")
    path = write(arm_with(*spots))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = shown(path, package_dirs=(tmp_path / "elsewhere", tmp_path / "checkout"))
    assert found == [str(spot) for spot in spots.values()]


def test_missing_meshes_are_told_once_and_the_rest_is_shown(tmp_path: Path, write: Callable[..., Path]) -> None:
    """One warning with their number and the first; the sphere and the mesh that is there remain."""
    good = put(tmp_path / "good.stl")
    path = write(arm_with("package://gone/a.stl", "good.stl", "package://gone/b.stl", "package://gone/a.stl"))
    with pytest.warns(MeshWarning, match=r"3 of 5 shapes.*'package://gone/a\.stl'.*package_dirs") as caught:
        robot = load_robot(path)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    geometry = robot.visual_model()
    assert [item.meshPath for item in geometry.geometryObjects] == ["SPHERE", str(good)]
    assert geometry.geometryObjects[1].placement.translation[2] == 2.0
    assert np.array_equal(geometry.geometryObjects[1].meshScale, [2, 2, 2])


@pytest.mark.parametrize(
    "address",
    [
        "package://pkg/../secret.stl",
        "package://pkg/sub/../../secret.stl",
        "package://../secret.stl",
        "package://./secret.stl",
        "package://pkg",
        "http://localhost/secret.stl",
        "ftp://localhost/secret.stl",
        "secret.txt",
        "file:///etc/passwd",
    ],
)
def test_an_address_never_leaves_its_package_or_the_disk(
    address: str, tmp_path: Path, write: Callable[..., Path]
) -> None:
    """Paths out of the package, networks and files that are no meshes are not followed."""
    put(tmp_path / "secret.stl")
    put(tmp_path / "secret.txt")
    put(tmp_path / "pkg/sub/inside.stl")
    with pytest.warns(MeshWarning, match="1 of 2"):
        load_robot(write(arm_with(address)), package_dirs=[tmp_path])


def test_a_link_inside_a_package_may_lead_to_its_sources(tmp_path: Path, write: Callable[..., Path]) -> None:
    """ROS workspaces install by symbolic links."""
    target = put(tmp_path / "src/m.stl")
    (tmp_path / "pkg").mkdir()
    (tmp_path / "pkg/m.stl").symlink_to(target)
    assert shown(write(arm_with("package://pkg/m.stl"))) == [str(tmp_path / "pkg/m.stl")]


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        ("not a mesh", "no mesh that can be read"),
        (TRIANGLE.replace("vertex 1 0 0", "vertex 1e30 0 0"), "not finite, or farther than 1e[+]06 m"),
        (TRIANGLE.replace("vertex 1 0 0", "vertex inf 0 0"), "not finite, or farther than 1e[+]06 m"),
    ],
    ids=["text", "far", "infinite"],
)
def test_meshes_that_cannot_be_read_are_left_out_when_shown(
    broken: str, why: str, tmp_path: Path, write: Callable[..., Path]
) -> None:
    """Loading does not open meshes; showing leaves a broken one out with one warning."""
    put(tmp_path / "good.stl")
    (tmp_path / "broken.stl").write_text(broken)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = load_robot(write(arm_with("broken.stl", "good.stl")))
    with pytest.warns(MeshWarning, match=rf"1 meshes cannot be read.*broken\.stl.*{why}") as caught:
        geometry = robot.visual_model()
    assert len(caught) == 1
    assert [Path(item.meshPath).name for item in geometry.geometryObjects] == ["SPHERE", "good.stl"]
    assert np.array_equal(geometry.geometryObjects[1].geometry.vertices().max(axis=0), [2, 2, 2])


def test_a_reader_that_crashes_leaves_its_mesh_out(
    tmp_path: Path, write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process reads meshes; where it ends without an answer, the arm is shown without that mesh."""

    def lost(*_: object) -> None:
        raise Lost

    put(tmp_path / "good.stl")
    robot = load_robot(write(arm_with("good.stl")))
    monkeypatch.setattr(caller._Server, "table", lost)
    with pytest.warns(MeshWarning, match=r"1 meshes cannot be read.*good\.stl.*the library that reads it crashed"):
        geometry = robot.visual_model()
    assert [item.meshPath for item in geometry.geometryObjects] == ["SPHERE"]


def test_meshes_that_are_too_large_are_not_opened(
    tmp_path: Path, write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One by itself, and those that exceed the limit of all; what fits is shown."""
    size = put(tmp_path / "small.stl").stat().st_size
    with (tmp_path / "large.stl").open("wb") as stream:
        stream.truncate(MAX_MESH_BYTES + 1)
    robot = load_robot(write(arm_with("large.stl", "small.stl", "small.stl")))
    for most, left_out in ((2 * size, 1), (size, 2)):
        monkeypatch.setattr(meshes, "MAX_MESHES_BYTES", most)
        with pytest.warns(MeshWarning, match=rf"{left_out} meshes are larger than .*large\.stl.*reduce") as caught:
            geometry = robot.visual_model()
        assert len(caught) == 1
        assert len(geometry.geometryObjects) == 4 - left_out


def test_shapes_move_with_the_normalised_model(zoo: Path, tmp_path: Path) -> None:
    """With joints locked and unwrapped, every shape is where Pinocchio puts it on the model of the file."""
    box = (
        '<visual><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><geometry><box size="1 2 3"/></geometry></visual></link>'
    )
    path = tmp_path / "boxes.urdf"
    path.write_text(zoo.read_text().replace("</link>", box))
    robot = load_robot(path, lock={"slide": 0.3, "elbow": 0.0})
    whole = pin.buildModelFromUrdf(str(path))
    state = pin.neutral(whole)
    for name, value in {"slide": 0.3, "side": 0.2, "far": -0.03}.items():
        state[whole.idx_qs[whole.getJointId(name)]] = value
    expected = pin.buildGeomFromUrdf(whole, str(path), pin.GeometryType.VISUAL)
    poses, whole_data = expected.createData(), whole.createData()
    pin.updateGeometryPlacements(whole, whole_data, expected, poses, state)
    geometry, model = robot.visual_model(), robot.pin_model
    data, placed = model.createData(), geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, placed, robot.expand(np.zeros(robot.n)))
    assert [item.name for item in geometry.geometryObjects] == [item.name for item in expected.geometryObjects]
    for one, two in zip(placed.oMg, poses.oMg, strict=True):
        assert np.allclose(one.homogeneous, two.homogeneous, atol=1e-12)


def test_colours_come_from_shared_and_own_materials(write: Callable[..., Path]) -> None:
    """A material defined elsewhere in the file counts by its name; none is grey."""
    boxes = "".join(
        f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'
        for material in ('<material name="red"/>', '<material name="x"><color rgba="0 1 0 0.5"/></material>', "")
    )
    text = arm_with().replace('<link name="moving">', f'<link name="moving">{boxes}')
    robot = load_robot(write('<material name="red"><color rgba="1 0 0 1"/></material>' + text))
    colors = np.array([item.meshColor for item in robot.visual_model().geometryObjects][1:], dtype=float)
    expected = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.5], [0.7, 0.7, 0.7, 1.0]])
    assert np.allclose(colors, expected)


def test_shapes_that_pinocchio_does_not_know_are_left_out(write: Callable[..., Path]) -> None:
    """An unknown shape would make its reader refuse the whole file."""
    text = arm_with().replace('<sphere radius="0.1"/>', '<cone radius="1"/>')
    with pytest.warns(MeshWarning, match="<cone> of link 'base'"):
        robot = load_robot(write(text))
    assert robot.visual_model().ngeoms == 0
