"""What a path of a study points at: the same number that one would change in the files by hand."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.batch.cases import Cases
from flexdyn.batch.studyfile import read_study
from flexdyn.model.model_file import model_from_dict
from tests.batch.studies import ARM, write_study

FULL = ARM | {"initial": {"q": {"elbow": 1.0}, "v": {"shoulder": 0.5}}, "tolerance": 0.05}
PD = {"pd": {"reference": "path.csv", "kp": 20.0, "kd": [0.4, 0.3]}}


def cases(folder: Path, **changes: Any) -> Cases:
    """The cases of a study."""
    return Cases(read_study(write_study(folder, **changes)))


def by_hand(path: str, value: float) -> dict[str, Any]:
    """The model file with one number changed, as an editor would change it."""
    content = copy.deepcopy(FULL)
    content["robot"]["gravity"] = [0.0, 0.0, -9.81]
    effect = re.fullmatch(r"effects\[(\d)\]\.(\w+)", path)
    gravity = re.fullmatch(r"robot\.gravity\[(\d)\]", path)
    if effect:
        content["effects"][int(effect[1])][effect[2]] = value
    elif gravity:
        content["robot"]["gravity"][int(gravity[1])] = value
    else:
        group, one, other = path.split(".")
        outer = ("shoulder", "elbow") if (group, one) == ("joints", "*") else (one,)
        inner = ("shoulder", "elbow") if (group, other) == ("initial", "*") else (other,)
        for name in outer:
            content[group].setdefault(name, {}).update(dict.fromkeys(inner, value))
    return content


def test_every_number_of_the_model_file(tmp_path: Path) -> None:
    """Each path gives the model that its file gives with that number written into it, and no path is missing."""
    made = cases(tmp_path, command=None)
    model_paths = [path for path in made.places if not path.startswith("command")]
    numbers = {"joints": 3 * 4, "initial": 3 * 4, "effects": 3, "robot": 3}
    assert {key: sum(path.startswith(key) for path in model_paths) for key in numbers} == numbers
    for path in model_paths:
        expected = model_from_dict(by_hand(path, 0.75), tmp_path, name="arm")
        found = made.case_of({path: 0.75}).model
        assert found == expected.replace(name=found.name), path
        assert found != made.model, path


def test_one_joint_stands_over_all_joints(tmp_path: Path) -> None:
    """``joints.*`` is every joint, except where a joint of its own name is drawn too, in whatever order."""
    made = cases(tmp_path, command=None)
    for values in ({"joints.elbow.damping": 0.2, "joints.*.damping": 0.1}, {"joints.*.damping": 0.1}):
        found = made.case_of(values).model.joints
        assert found["shoulder"].damping == 0.1
        assert found["elbow"].damping == values.get("joints.elbow.damping", 0.1)


def test_two_numbers_of_one_effect(tmp_path: Path) -> None:
    """Both are changed at once: a stop whose ends both move past where they were is no mistake in between."""
    stop = {"effect": "end_stop", "joint": "elbow", "lower": 0.0, "upper": 2.0, "stiffness": 10.0, "damping": 0.1}
    model = ARM | {"effects": [stop], "robot": {"urdf": "scara_two_link"}}
    vary = {"effects[0].lower": {"grid": [0.5]}, "effects[0].upper": {"grid": [1.5]}}
    found = cases(tmp_path, model=model, vary=vary, runs=None)
    moved = found.case_of({"effects[0].lower": 2.5, "effects[0].upper": 3.5}).model.effects[0].to_dict()
    assert (moved["lower"], moved["upper"]) == (2.5, 3.5)


def test_what_does_not_change_is_shared(tmp_path: Path) -> None:
    """Where only the command varies, all runs have the very same model, whose plant is then built once."""
    made = cases(tmp_path, vary={"command.scale": {"uniform": [0.5, 1.5]}})
    assert made.case(0).model is made.case(1).model is made.model
    assert cases(tmp_path / "b").case(0).command is not None


def test_the_scale_of_a_command(tmp_path: Path) -> None:
    """``command.scale`` multiplies the torques and nothing else of the recording."""
    made = cases(tmp_path, vary={"command.scale": {"grid": [-2]}}, runs=None)
    given, found = fd.read_recording(tmp_path / "torque.csv"), made.case(0).command
    np.testing.assert_array_equal(found.signal("tau", ["shoulder", "elbow"]), -2 * given.signal("tau", given.joints))
    np.testing.assert_array_equal(found.t, given.t)


def test_the_gains_of_a_controller(tmp_path: Path) -> None:
    """All joints' gain, one joint's, and the control rate: the run is that of a PD with these numbers."""
    vary = {
        "command.pd.kd.elbow": {"grid": [0.7]},
        "command.pd.kp": {"grid": [33.0]},
        "command.pd.rate": {"grid": [500.0]},
    }
    made = cases(tmp_path, command=PD, vary=vary, runs=None)
    case = made.case(0)
    reference = fd.read_recording(tmp_path / "path.csv")
    expected = fd.PD(reference, kp=33.0, kd=[0.4, 0.7], rate=500.0)
    found, wanted = (fd.simulate(made.model, each, 0.2, made.solver).tau for each in (case.command, expected))
    np.testing.assert_array_equal(found, wanted)
    assert case.command.kd == {"shoulder": 0.4, "elbow": 0.7}


def test_a_first_state_over_the_one_that_was_recorded(tmp_path: Path) -> None:
    """A recording's first row hides the model's initial; a number that is drawn stands over both."""
    path = write_study(tmp_path, vary={"initial.q.elbow": {"grid": [0.3]}}, runs=None)
    t = np.linspace(0.0, 0.2, 21)
    columns = {"tau.elbow": 0 * t, "q.elbow": 0.8 + t, "q.shoulder": 0.1 + t}
    fd.write_recording(fd.Recording(t, columns), tmp_path / "torque.csv")
    made = Cases(read_study(path))
    case = made.case(0)
    run = fd.simulate(case.model, case.command, 0.2, made.solver, **case.starts)
    assert run.q[0].tolist() == [0.1, 0.3]
    assert run.theta[0].tolist() == [0.1, 0.3]


def test_where_a_locked_joint_is_held(tmp_path: Path) -> None:
    """``robot.lock.J`` moves a joint that the model file locks: the arm is that of a file with the other value."""
    model = {"flexdyn": 1, "robot": {"urdf": "panda", "lock": {"panda_joint2": 0.1}}}
    vary = {"robot.lock.panda_joint2": {"grid": [0.6]}}
    made = cases(tmp_path, model=model, command=None, vary=vary, runs=None, metrics=None)
    expected = fd.load_robot("panda", lock={"panda_joint2": 0.6})
    q = np.full(expected.n, 0.4)
    found, wanted = (fd.LinkSide(each).mass_matrix(q) for each in (made.case(0).model, fd.FlexibleJointModel(expected)))
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("joints.shoulder.stiffness", "N m/rad"),
        ("joints.*.gear_ratio", "1"),
        ("effects[1].level", "N m"),
        ("effects[2].mass", "kg"),
        ("initial.v.elbow", "rad/s"),
        ("robot.gravity[2]", "m/s^2"),
        ("command.scale", "1"),
    ],
)
def test_every_place_has_a_unit(tmp_path: Path, path: str, unit: str) -> None:
    """The unit that the store writes beside the number."""
    assert cases(tmp_path).places[path].unit == unit
