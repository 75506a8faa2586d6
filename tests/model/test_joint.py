"""One joint's drive: defaults, reflection through the gear, and numbers that make no sense."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

from flexdyn import InputError, Joint
from flexdyn.model.joint import resolve_joints
from tests.arms import repickled

NAMES = ("shoulder", "elbow")


def test_defaults_are_a_rigid_joint_without_rotor() -> None:
    """Gear ratio 1, no rotor, infinite stiffness, no damping (contract, section 2)."""
    joint = Joint()
    assert (joint.gear_ratio, joint.rotor_inertia, joint.stiffness, joint.damping) == (1.0, 0.0, math.inf, 0.0)
    assert not joint.elastic


def test_inertia_is_reflected_by_the_square_of_the_gear() -> None:
    """J = N^2 J_r."""
    assert Joint(gear_ratio=100.0, rotor_inertia=1e-5, stiffness=10.0).reflected_inertia == pytest.approx(0.1)


@pytest.mark.parametrize("kind", [int, np.float32, np.int64, float])
def test_any_real_number_is_a_number(kind: Any) -> None:
    """NumPy's numbers and whole ones are stored as plain floats."""
    joint = Joint(stiffness=kind(3), rotor_inertia=kind(1))
    assert type(joint.stiffness) is float
    assert joint == Joint(stiffness=3.0, rotor_inertia=1.0)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"gear_ratio": 0.0}, "gear_ratio: it must be finite and not 0"),
        ({"gear_ratio": math.inf}, "gear_ratio: it must be finite and not 0"),
        ({"gear_ratio": -math.inf}, "gear_ratio: it must be finite and not 0"),
        ({"rotor_inertia": -1e-4}, "rotor_inertia: it must be finite and at least 0"),
        ({"rotor_inertia": math.inf}, "rotor_inertia: it must be finite"),
        ({"rotor_inertia": 10**400}, "rotor_inertia: it must be finite"),
        ({"stiffness": 0.0}, "stiffness: it must be above 0"),
        ({"stiffness": -5}, "stiffness: it must be above 0"),
        ({"stiffness": math.nan}, "stiffness: a number is needed"),
        ({"stiffness": "4e3"}, "stiffness: a number is needed"),
        ({"stiffness": None}, "stiffness: a number is needed"),
        ({"stiffness": True}, "stiffness: a number is needed"),
        ({"stiffness": 1 + 2j}, "stiffness: a number is needed"),
        ({"damping": -0.1}, "damping: it must be finite and at least 0"),
        ({"damping": [1.0]}, "damping: a number is needed"),
        ({"gear_ratio": 1e200, "rotor_inertia": 1.0}, "rotor_inertia: gear_ratio^2 rotor_inertia is too large"),
        ({"gear_ratio": 1e-200, "rotor_inertia": 1.0}, "rotor_inertia: gear_ratio^2 rotor_inertia is too large"),
        ({"stiffness": 4000.0}, "rotor_inertia: an elastic joint needs it above 0"),
    ],
)
def test_a_number_without_sense_is_refused(numbers: dict[str, Any], words: str) -> None:
    """One line that begins with the number's name."""
    with pytest.raises(InputError) as caught:
        Joint(**numbers)
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value)


def test_a_joint_does_not_change_and_pickles() -> None:
    """It is a frozen value: equal ones hash alike."""
    joint = Joint(stiffness=5.0, rotor_inertia=0.1)
    with pytest.raises(FrozenInstanceError):
        joint.stiffness = 6.0  # type: ignore[misc]
    again = repickled(joint)
    assert again == joint
    assert hash(again) == hash(joint)


def test_own_numbers_stand_over_the_default_joint() -> None:
    """The joint "*" fills in what a named joint leaves out."""
    joints = resolve_joints({"*": {"rotor_inertia": 0.1, "damping": 2.0}, "elbow": {"stiffness": 50.0}}, NAMES)
    assert joints["elbow"] == Joint(rotor_inertia=0.1, damping=2.0, stiffness=50.0)
    assert joints["shoulder"] == Joint(rotor_inertia=0.1, damping=2.0)


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"elbo": {}}, "joints.elbo: the robot has no such joint; did you mean 'elbow'?"),
        ({3: {}}, "joints.3: the robot has no such joint; known: shoulder, elbow"),
        ({"elbow": {"stifness": 1.0}}, "joints.elbow.stifness: a joint has no such key; did you mean 'stiffness'?"),
        ({"elbow": {None: 1.0}}, "joints.elbow.None: a joint has no such key"),
        ({"elbow": 5.0}, "joints.elbow: a joint is a mapping of its numbers, got 5.0; write {stiffness: 4000.0, ...}"),
        ({"*": [1.0]}, "joints.*: a joint is a mapping of its numbers"),
        ({"elbow": {"stiffness": -1.0}}, "joints.elbow.stiffness: it must be above 0, got -1.0"),
        ({"*": {"damping": -1.0}, "elbow": {"stiffness": 1.0}}, "joints.*.damping: it must be finite and at least 0"),
        ({"*": {"damping": 1.0}, "elbow": {"stiffness": 1.0}}, "joints.elbow.rotor_inertia: an elastic joint needs it"),
        ({"*": {"stiffness": 5.0}}, "joints.*.rotor_inertia: an elastic joint needs it above 0"),
        ([], "joints: joints are a mapping by name"),
    ],
)
def test_a_mistake_names_its_place(entries: Any, words: str) -> None:
    """The line begins with the dotted path of the mistake and ends with the remedy."""
    with pytest.raises(InputError) as caught:
        resolve_joints(entries, NAMES)
    assert str(caught.value).startswith(words)
