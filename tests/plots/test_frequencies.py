"""Frequencies over a path as a picture: the lines are the frequencies, in the modes' order."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.plots import draw_frequencies


def lines_of(path: Path) -> list[NDArray[np.float64]]:
    """Points of the long lines of an SVG, those that are curves."""
    found = []
    for data in re.findall(r'<path d="([^"]*)"[^>]*fill: none', path.read_text(encoding="utf-8")):
        numbers = [float(number) for number in re.findall(r"-?\d+\.?\d*", data)]
        if set(re.findall("[A-Za-z]", data)) <= {"M", "L"} and len(numbers) > 12:
            found.append(np.array(numbers).reshape(-1, 2))
    return found


@pytest.fixture(scope="module")
def found() -> fd.PathFrequencies:
    """The elbow of the UR5 bends a quarter turn."""
    poses = np.zeros((40, 6))
    poses[:, 2] = np.linspace(0.0, np.pi / 2, 40)
    return fd.frequencies_over_path(fd.load_model("ur5"), poses)


def test_every_curve_is_a_mode(found: fd.PathFrequencies, tmp_path: Path) -> None:
    """Six springs give six curves, swings under gravity are left out; the ends of all lie where the axis puts them."""
    draw_frequencies(found, tmp_path / "f.svg")
    curves = lines_of(tmp_path / "f.svg")
    kept = found.frequencies[:, np.median(found.frequencies, axis=0) > found.frequencies.max() / 200.0]
    assert len(curves) == kept.shape[1] == 6
    ends = np.array([[curve[0, 1], curve[-1, 1]] for curve in curves])
    level = np.log(kept[[0, -1]].T) if kept.max() > 12.0 * kept.min() else kept[[0, -1]].T
    slope, offset = np.polyfit(level.ravel(), ends.ravel(), 1)
    assert slope < 0.0  # an SVG counts downwards
    np.testing.assert_allclose(ends, slope * level + offset, atol=0.01)


def test_what_cannot_be_drawn(found: fd.PathFrequencies, tmp_path: Path) -> None:
    """Another suffix is refused, and so is an arm on which nothing vibrates."""
    with pytest.raises(fd.InputError, match=r"unknown suffix of a picture, got '\.gif'; known: \.png, \.pdf, \.svg"):
        draw_frequencies(found, tmp_path / "f.gif")
    rigid = fd.load_model("scara_two_link").rigid().replace(gravity=[0.0, 0.0, -9.81])
    with pytest.raises(fd.InputError, match=r"nothing vibrates along the path; give joints a stiffness"):
        draw_frequencies(fd.frequencies_over_path(rigid, [[0.0, 0.5]]), tmp_path / "f.svg")
    assert not list(tmp_path.iterdir())


def test_one_pose_is_a_row_of_points(found: fd.PathFrequencies, tmp_path: Path) -> None:
    """A path of one pose has no lines to draw, so every mode is a marker."""
    draw_frequencies(fd.frequencies_over_path(fd.load_model("ur5"), found.q[:1]), tmp_path / "f.svg")
    text = (tmp_path / "f.svg").read_text(encoding="utf-8")
    assert not lines_of(tmp_path / "f.svg")
    assert "1 poses of" not in text
