"""A link's numbers multiplied: the same arm as from a URDF that has them so."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexdyn.errors import InputError
from flexdyn.robot import Robot, Tree, load_robot


def edited(text: str, link: str, mass: float, com: float, inertia: float) -> str:
    """The URDF with one link's numbers multiplied in the text."""

    def times(factor: float) -> Callable[[re.Match[str]], str]:
        return lambda found: found[1] + " ".join(repr(factor * float(x)) for x in found[2].split()) + '"'

    def change(found: re.Match[str]) -> str:
        body = re.sub(r'(<mass value=")([^"]*)"', times(mass), found[0])
        body = re.sub(r'(<origin xyz=")([^"]*)"', times(com), body)
        return re.sub(r'(i[xyz][xyz]=")([^"]*)"', times(inertia), body)

    changed, count = re.subn(rf'<link name="{link}">.*?</inertial>', change, text, flags=re.DOTALL)
    assert count == 1
    return changed


def same_dynamics(one: Robot, two: Robot, rebuild: Callable[[Tree], pin.Model]) -> None:
    """Torques and energies of both, from tree and Pinocchio model alike."""
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, one.tree.m))
    models = [one.pin_model, two.pin_model, rebuild(one.tree), rebuild(two.tree)]
    torques = [pin.rnea(model, model.createData(), q, v, a) for model in models]
    for torque in torques[1:]:
        np.testing.assert_allclose(torque, torques[0], rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("link", ["a", "b", "plate", "c", "e", "f"])
@pytest.mark.parametrize("lock", [{}, {"slide": 0.4}])
def test_as_if_the_file_had_been_written_so(
    zoo: Path, link: str, lock: dict[str, float], rebuild: Callable[[Tree], pin.Model]
) -> None:
    """On moving links, welded ones, branches, followers of a mimic and links behind a locked joint."""
    factors = {"mass": 1.3, "com": 0.7, "inertia": 1.6}
    given = load_robot(zoo, lock=lock)
    written = zoo.with_name("written.urdf")
    written.write_text(edited(zoo.read_text(encoding="utf-8"), link, **factors), encoding="utf-8")
    scaled = given.with_link_scaled(link, **factors)
    assert scaled.source is None
    same_dynamics(scaled, load_robot(written, lock=lock), rebuild)
    again = scaled.with_link_scaled(link, **{key: 1.0 / value for key, value in factors.items()})
    same_dynamics(again, given, rebuild)
    same_dynamics(pickle.loads(pickle.dumps(scaled)), scaled, rebuild)  # noqa: S301 - our own bytes


@pytest.mark.parametrize("number", ["mass", "com", "inertia"])
def test_each_number_by_itself(zoo: Path, number: str, rebuild: Callable[[Tree], pin.Model]) -> None:
    """The others stay; the robot that was given stays as it was."""
    given = load_robot(zoo)
    before = given.tree.mass.copy()
    factors = {"mass": 1.0, "com": 1.0, "inertia": 1.0} | {number: 2.0}
    written = zoo.with_name("written.urdf")
    written.write_text(edited(zoo.read_text(encoding="utf-8"), "d", **factors), encoding="utf-8")
    same_dynamics(given.with_link_scaled("d", **{number: 2.0}), load_robot(written), rebuild)
    np.testing.assert_array_equal(given.tree.mass, before)


def test_links_that_have_no_such_numbers(arm: Path) -> None:
    """An unknown link, one without mass, the base, and a robot whose links are not known."""
    robot = load_robot(arm)
    for link, words in (
        ("uper", r"^link: no such link, got 'uper'; did you mean 'upper'"),
        ("tool", r"^link: the link has no mass, got 'tool'"),
        ("base", r"^link: the link does not move: its mass has no effect, got 'base'"),
    ):
        with pytest.raises(InputError, match=words):
            robot.with_link_scaled(link, mass=2.0)
    with pytest.raises(InputError, match=r"load the robot from a URDF"):
        load_robot(pin.buildSampleModelManipulator()).with_link_scaled("upper", mass=2.0)
