"""The commands that meshcat gets, replayed here: every frame puts the arm where forward kinematics has it."""

from __future__ import annotations

import base64
import gzip
import json
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import umsgpack

import flexdyn as fd
from flexdyn.robot import frame_positions
from flexdyn.viewer import sources
from flexdyn.viewer.show import motion_page
from flexdyn.viewer.solids import tube
from tests.viewer.arms import rigid_run, shapeless, swinging, two_link_run


class Page:
    """A page taken apart again: what its script is told, and meshcat's commands."""

    def __init__(self, text: str) -> None:
        self.about = json.loads(re.findall(r'id="about">(.*?)</script>', text, re.S)[0])
        data = gzip.decompress(base64.b64decode(re.findall(r'id="scene">(.*?)</script>', text, re.S)[0]))
        self.commands: list[dict[str, Any]] = []
        while data:
            (length,) = struct.unpack(">I", data[:4])
            self.commands.append(umsgpack.unpackb(data[4 : 4 + length]))
            data = data[4 + length :]

    def place(self, path: str, frame: int | None = None) -> np.ndarray:
        """Where a node is in a frame, or at first (4, 4): the product of what sets it and the nodes above it."""
        here = np.eye(4)
        parts = path.strip("/").split("/")
        for k in range(len(parts)):
            here = here @ self._local("/" + "/".join(parts[: k + 1]), frame)
        return here

    def _local(self, path: str, frame: int | None) -> np.ndarray:
        # The second arm takes the fixed places of the first.
        fixed = path.replace("/ghost", "/arm")
        local = np.eye(4)
        for command in self.commands:
            if command["type"] == "set_transform" and command["path"] == fixed:
                local = np.array(command["matrix"]).reshape(4, 4).T
            if command["type"] == "set_property" and command["path"] == path:
                local = _matrix(command["property"], command["value"])
        for clip in [] if frame is None else self.clips:
            if clip["path"] == path:
                (track,) = clip["clip"]["tracks"]
                values = {key["time"]: key["value"] for key in track["keys"]}
                local = _matrix(track["name"].strip("."), values.get(frame, values[0]))
        return local

    @property
    def clips(self) -> list[dict[str, Any]]:
        """Of the one animation."""
        (animation,) = [command for command in self.commands if command["type"] == "set_animation"]
        found: list[dict[str, Any]] = animation["animations"]
        return found

    def node(self, ending: str) -> str:
        """The one node with an object whose path ends so."""
        found = {c["path"] for c in self.commands if c["type"] == "set_object" and c["path"].endswith(ending)}
        (path,) = found
        return str(path)

    def series(self, name: str) -> np.ndarray:
        """Numbers of the table, frame by frame."""
        return np.frombuffer(base64.b64decode(self.about["series"][name]), dtype="<f4")


def _matrix(name: str, value: list[float]) -> np.ndarray:
    matrix = np.eye(4)
    if name == "position":
        matrix[:3, 3] = value
    else:
        x, y, z, w = value
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        matrix[:3, :3] += 2.0 * w * cross + 2.0 * cross @ cross
    return matrix


def page_of(run: Any, compare: Any = None, magnify: float | None = None) -> Page:
    """The page of a run, taken apart."""
    shown = sources.first(run, None)
    ghost = None if compare is None else sources.second(compare, None, shown)
    return Page(motion_page(shown.model, shown.motion, ghost, magnify))


@pytest.mark.parametrize("arm", ["scara_two_link", "scara", "ur5", "shapeless"])
def test_every_frame_is_forward_kinematics(arm: str, tmp_path: Path) -> None:
    """Revolute, prismatic, skewed and mimic joints: the tip is where Pinocchio has it, to the float's digits."""
    run = swinging(shapeless(tmp_path) if arm == "shapeless" else fd.load_model(arm), duration=0.1)
    page = page_of(run)
    count = round(page.about["duration"] * page.about["rate"]) + 1
    times = np.linspace(run.t[0], run.t[-1], count)
    q = np.column_stack([np.interp(times, run.t, column) for column in run.q.T])
    expected = frame_positions(run.model.robot, q, run.model.robot.last_frame)
    for frame in (0, count // 3, count - 1):
        assert page.place(page.node("/tip"), frame)[:3, 3] == pytest.approx(expected[frame], abs=1e-6)
    assert page.place(page.node("/tip"))[:3, 3] == pytest.approx(expected[0], abs=1e-6)


def test_the_second_arm_follows_its_own_motion() -> None:
    """Its nodes carry the positions of the other run, and the table the differences and the distance of the tips."""
    run, rigid = two_link_run(), rigid_run()
    page = page_of(run, rigid)
    last = len(page.series("gap")) - 1
    expected = [each.frame_positions()[-1] for each in (run, rigid)]
    tip = page.node("/tip")
    assert page.place(tip, last)[:3, 3] == pytest.approx(expected[0], abs=1e-6)
    assert page.place(tip.replace("/arm", "/ghost"), last)[:3, 3] == pytest.approx(expected[1], abs=1e-6)
    assert page.series("gap")[last] == pytest.approx(np.linalg.norm(expected[1] - expected[0]), rel=1e-5)
    assert page.series("difference").reshape(-1, 2)[last] == pytest.approx(rigid.q[-1] - run.q[-1], rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("magnify", [None, 7.5])
def test_the_needle_shows_the_deflection_times_the_factor_on_the_page(magnify: float | None) -> None:
    """Relative to the dial, which turns with the link: factor * (theta - q) about the joint's axis."""
    run = two_link_run()
    page = page_of(run, magnify=magnify)
    (factor,) = re.findall(r"magnified ([0-9.e+]+)\u00d7", page.about["magnified"])
    assert magnify is None or float(factor) == magnify
    frame = int(np.argmax(np.abs(page.series("deflection").reshape(-1, 2)[:, 0])))
    deflection = page.series("deflection").reshape(-1, 2)[frame, 0]
    assert abs(deflection) == pytest.approx(np.abs(run.deflection[:, 0]).max(), rel=1e-2)
    dial = page.about["legend"][1]["paths"][0]
    turned = page.place(f"{dial}/needle", frame)
    link = page.place(dial, frame)
    between = link[:3, :3].T @ turned[:3, :3]
    assert np.arctan2(between[1, 0], between[0, 0]) == pytest.approx(float(factor) * deflection, abs=1e-5)
    assert between[2, 2] == pytest.approx(1.0)


def test_a_prismatic_needle_slides_along_the_axis(tmp_path: Path) -> None:
    """By its own factor, which the page shows with its unit."""
    run = swinging(shapeless(tmp_path))
    page = page_of(run)
    found = dict(re.findall(r"([0-9.e+]+)\u00d7 \[(rad|m)\]", page.about["magnified"]))
    factors = {unit: float(factor) for factor, unit in found.items()}
    frame = 20
    deflection = page.series("deflection").reshape(-1, 3)[frame, 2]
    dial = page.about["legend"][1]["paths"][2]
    slid = page.place(f"{dial}/needle", frame)[:3, 3] - page.place(dial, frame)[:3, 3]
    axis = page.place(dial.removesuffix("/dial"), frame)[:3, :3] @ [0.0, 1.0, 0.0]
    assert slid == pytest.approx(factors["m"] * deflection * axis, abs=1e-6)
    assert abs(deflection) > 0.0


def test_a_model_alone_stands_where_it_starts() -> None:
    """No animation, the initial position in the table."""
    model = fd.load_model("scara")
    page = page_of(model)
    assert not [command for command in page.commands if command["type"] == "set_animation"]
    assert page.about["duration"] == 0.0
    q0 = [model.initial["q"].get(joint, 0.0) for joint in model.joint_names]
    assert page.series("q") == pytest.approx(q0, rel=1e-6)
    assert page.place(page.node("/tip"))[:3, 3] == pytest.approx(
        frame_positions(model.robot, np.array([q0]))[0], abs=1e-6
    )


def test_long_motions_make_small_pages() -> None:
    """A minute of two joints at 1 kHz: a page of less than 2 MB."""
    t = np.linspace(0.0, 60.0, 60_001)
    recording = fd.Recording(t, {"q.shoulder": np.sin(t), "q.elbow": np.cos(7 * t), "theta.elbow": np.cos(7.01 * t)})
    shown = sources.first(recording, "scara_two_link")
    assert len(motion_page(shown.model, shown.motion)) < 2e6


def test_a_tube_is_closed_and_as_thick_as_asked() -> None:
    """Every edge belongs to two triangles, and every vertex but the two on the axis lies a radius from the line."""
    along = np.linspace(0.0, 3.0, 40)
    points = np.column_stack([np.cos(along), np.sin(along), 0.2 * along])
    geometry = tube(points, 0.01)
    faces = np.asarray(geometry.faces)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    distance = np.linalg.norm(geometry.vertices[:, None] - points[None], axis=2).min(axis=1)
    assert distance[:-2] == pytest.approx(0.01, rel=1e-4)
    assert tube(np.zeros((5, 3)), 0.01) is None
