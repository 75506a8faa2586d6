"""The KUKA's files: they are those of the published table, whose chain is multiplied out here by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kuka_robot import AXES, PAYLOAD, write
from numpy.typing import NDArray

import flexdyn as fd

STUDY = Path(__file__).parents[2] / "benchmarks" / "measured" / "kuka_kr300"

Array = NDArray[np.float64]


def chain(q: Array) -> list[Array]:
    """Transforms of the links' frames by standard Denavit-Hartenberg, base turned by 180 deg about x."""
    place, found = np.diag([1.0, -1.0, -1.0, 1.0]), []
    for angle, axis in zip(q, AXES, strict=True):
        c, s = np.cos(angle + np.radians(axis.offset)), np.sin(angle + np.radians(axis.offset))
        ca, sa = np.cos(np.radians(axis.alpha)), np.sin(np.radians(axis.alpha))
        step = [
            [c, -s * ca, s * sa, axis.a * c],
            [s, c * ca, -c * sa, axis.a * s],
            [0.0, sa, ca, axis.d],
            [0.0, 0.0, 0.0, 1.0],
        ]
        place = place @ np.array(step)
        found.append(place)
    return found


def test_files_are_those_that_the_script_writes(tmp_path: Path) -> None:
    """Nobody edited them."""
    write(tmp_path)
    for name in ("arm.urdf", "rigid.yaml", "elastic.yaml"):
        assert (tmp_path / name).read_text(encoding="utf-8") == (STUDY / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("seed", range(4))
def test_gravity_is_that_of_the_table(seed: int) -> None:
    """The potential energy of the table's masses at the chain's places, differentiated."""
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, 6)

    def energy(at: Array) -> float:
        heights = [(place @ np.array([*axis.com, 1.0]))[2] for place, axis in zip(chain(at), AXES, strict=True)]
        return float(sum(9.81 * axis.mass * z for axis, z in zip(AXES, heights, strict=True)))

    steps = 1e-6 * np.eye(6)
    wanted = [(energy(q + step) - energy(q - step)) / 2e-6 for step in steps]
    links = fd.LinkSide(fd.load_model(STUDY / "rigid.yaml"))
    assert links.bias(q, np.zeros(6)) == pytest.approx(wanted, abs=1e-3)


def test_inertia_is_that_of_the_table() -> None:
    """Kinetic energy of links by the chain's velocities, and of rotors by N^2 J."""
    draw = np.random.default_rng(7)
    q, v = draw.uniform(-1.0, 1.0, (2, 6))
    before, at, after = chain(q - 1e-6 * v), chain(q), chain(q + 1e-6 * v)
    total = 0.5 * sum(axis.ratio**2 * axis.rotor * speed**2 for axis, speed in zip(AXES, v, strict=True))
    for low, mid, high, axis in zip(before, at, after, AXES, strict=True):
        velocity = (high - low)[:3] @ np.array([*axis.com, 1.0]) / 2e-6
        turn = (high - low)[:3, :3] @ mid[:3, :3].T / 2e-6
        omega = mid[:3, :3].T @ np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
        xx, yy, zz, xy, yz, xz = axis.inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        total += 0.5 * (axis.mass * velocity @ velocity + omega @ inertia @ omega)
    M = fd.LinkSide(fd.load_model(STUDY / "rigid.yaml")).mass_matrix(q)
    assert 0.5 * v @ M @ v == pytest.approx(total, rel=1e-6)


def test_the_elastic_one_has_springs_where_the_authors_give_them() -> None:
    """Axes 1 to 3; the payload is class 3.048."""
    model = fd.load_model(STUDY / "elastic.yaml")
    assert model.elastic.tolist() == [True] * 3 + [False] * 3
    assert pytest.approx(75.0 + 25.0 * 3.048, abs=0.5) == PAYLOAD
