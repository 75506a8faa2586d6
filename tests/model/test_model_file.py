"""model.yaml reads and writes without loss: every shipped model, and whatever numbers and names a user may have."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Payload, TorqueSpeedLimit
from flexdyn.model.model_file import model_to_dict
from tests.arms import slider

NAMES = ("panda", "scara", "scara_two_link", "ur5")
TWO_LINK = fd.load_robot("scara_two_link")


def test_shipped_models_are_found_by_name() -> None:
    """All four that come with flexdyn, from any folder."""
    assert fd.shipped_models() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_shipped_models_survive_a_round_trip(name: str, tmp_path: Path) -> None:
    """Saved elsewhere and loaded again, a model is the same, effects of its URDF uncounted, and moves alike."""
    model = fd.load_model(name)
    folder = tmp_path / name
    folder.mkdir()
    fd.save_model(model, folder / "model.yaml")
    again = fd.load_model(folder / "model.yaml")
    assert again == model
    assert again.all_effects == model.all_effects
    runs = [fd.simulate(each, None, 0.02) for each in (model, again)]
    np.testing.assert_array_equal(runs[0].theta, runs[1].theta)


def test_a_model_is_named_by_its_file_or_folder(tmp_path: Path) -> None:
    """model.yaml takes its folder's name, any other file its own."""
    model = fd.load_model("scara_two_link")
    fd.save_model(model, tmp_path / "mine.yaml")
    assert fd.load_model(tmp_path / "mine.yaml").name == "mine"
    assert fd.load_model(str(tmp_path / "mine.yaml")).replace(name="scara_two_link") == model


POSITIVE = st.floats(min_value=5e-324, max_value=1e300, exclude_min=False)
ANY = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    stiffness=st.one_of(st.just(math.inf), POSITIVE),
    inertia=st.floats(1e-300, 1e280),
    damping=st.floats(0, 1e300),
    gear=st.floats(1e-3, 1e6),
    q=ANY,
    gravity=st.tuples(ANY, ANY, ANY),
    level=st.floats(0, 1e300),
    stall=st.one_of(st.just(math.inf), st.floats(0, 1e300)),
    tolerance=st.one_of(st.floats(0, 1e300), st.dictionaries(st.just("*"), st.floats(0, 1e300))),
)
def test_every_number_survives(tmp_path: Path, **drawn: Any) -> None:
    """Bit for bit, from the smallest to the largest, integers of a power of ten and infinity included."""
    model = fd.FlexibleJointModel(
        TWO_LINK,
        {
            "elbow": {
                "stiffness": drawn["stiffness"],
                "rotor_inertia": drawn["inertia"],
                "damping": drawn["damping"],
                "gear_ratio": drawn["gear"],
            }
        },
        [
            CoulombFriction("elbow", side="link", level=drawn["level"]),
            TorqueSpeedLimit("elbow", stall_torque=drawn["stall"], no_load_speed=drawn["inertia"]),
            Payload(mass=drawn["level"]),
        ],
        initial={"q": {"elbow": drawn["q"]}},
        gravity=drawn["gravity"],
        tolerance=drawn["tolerance"],
        name="model",
    )
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").replace(name="model") == model


# What XML may hold in a name, and YAML would read as something else.
ODD_NAMES = [
    "null",
    "yes",
    "1",
    "4e-05",
    ".inf",
    "~",
    "a: b",
    "# c",
    "- d",
    "{e}",
    "'f'",
    '"g"',
    "*h",
    "&i",
    "J ö",
    "%k",
    "<<",
    "=",
    "1:30",
    "2001-01-01",
]


@pytest.mark.parametrize("odd", ODD_NAMES)
def test_every_name_survives(tmp_path: Path, odd: str) -> None:
    """Names that YAML would take for numbers, truth values or syntax are written so that they stay names."""
    escaped = odd.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    text = (
        f'<robot name="r"><link name="base"/><link name="{escaped}"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        f'<joint name="{escaped}" type="continuous"><parent link="base"/><child link="{escaped}"/></joint></robot>'
    )
    (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
    robot = fd.load_robot(tmp_path / "arm.urdf")
    effects = [Payload(mass=1.0, frame=odd), CoulombFriction(odd, side="link", level=1.0)]
    model = fd.FlexibleJointModel(robot, {odd: {"damping": 1.0}}, effects, initial={"q": {odd: 1.0}}, name="model")
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").replace(name="model") == model


def test_the_files_own_settings_survive(tmp_path: Path) -> None:
    """Locked joints, folders of packages, gravity and the treatment of <dynamics>."""
    (tmp_path / "meshes").mkdir()
    robot = fd.load_robot(
        "panda", lock={"panda_finger_joint1": 0.01, "panda_joint7": 0.5}, package_dirs=tmp_path / "meshes"
    )
    model = fd.FlexibleJointModel(robot, gravity=[1.0, 2.0, 3.0], urdf_dynamics="ignore", name="out")
    fd.save_model(model, tmp_path / "out.yaml")
    again = fd.load_model(tmp_path / "out.yaml")
    assert again == model
    assert again.robot.lock == {"panda_finger_joint1": 0.01, "panda_joint7": 0.5}
    assert again.robot.package_dirs == robot.package_dirs


def test_paths_are_relative_to_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with model and URDF can be moved as a whole; the working folder does not matter."""
    (tmp_path / "a" / "sub").mkdir(parents=True)
    robot = slider(tmp_path / "a")
    monkeypatch.chdir(tmp_path / "a")
    fd.save_model(fd.FlexibleJointModel(robot), "sub/model.yaml")
    monkeypatch.chdir("/")
    (tmp_path / "a").rename(tmp_path / "b")
    again = fd.load_model(tmp_path / "b" / "sub" / "model.yaml")
    assert again.joint_names == ("lift",)
    assert again.name == "sub"
    assert str(tmp_path) not in (tmp_path / "b" / "sub" / "model.yaml").read_text(encoding="utf-8")


def test_effects_of_the_urdf_are_not_saved() -> None:
    """They stay in the URDF; effects[i] counts the file's own (contract, section 2)."""
    panda = fd.FlexibleJointModel(fd.load_robot("panda"), effects=[Payload(mass=1.0, frame="panda_link7")])
    assert len(panda.urdf_effects) > 0
    assert len(model_to_dict(panda)["effects"]) == 1


def test_a_name_cannot_write_into_the_file(tmp_path: Path) -> None:
    """A model's name stands in a comment, line breaks and all."""
    model = fd.FlexibleJointModel(TWO_LINK, name="a\nflexdyn: 2\u2028b\x00\x85c")
    fd.save_model(model, tmp_path / "m.yaml")
    assert fd.load_model(tmp_path / "m.yaml").replace(name=model.name) == model


def test_a_robot_without_urdf_cannot_be_named(tmp_path: Path) -> None:
    """One line with the remedy, and no file."""
    model = fd.FlexibleJointModel(fd.load_robot(TWO_LINK.pin_model))
    with pytest.raises(fd.InputError, match=r"^robot\.urdf: the robot came from a pin\.Model"):
        fd.save_model(model, tmp_path / "m.yaml")
    with pytest.raises(fd.InputError, match="no such folder"):
        fd.save_model(fd.load_model("scara"), tmp_path / "nowhere" / "m.yaml")
    assert list(tmp_path.iterdir()) == []


def test_numbers_as_yaml_1_2_reads_them(tmp_path: Path) -> None:
    """4e-05 is a number, also without a point; .inf is a rigid joint; whole numbers will do."""
    text = "flexdyn: 1\nrobot: {urdf: scara_two_link, gravity: [0, 0, -981e-2]}\njoints:\n"
    text += "  shoulder: {rotor_inertia: 4e-05, stiffness: 5E3, damping: 0x10}\n  elbow: {stiffness: .inf}\n"
    text += "tolerance: 3e-2\ninitial:\neffects:\n"
    (tmp_path / "m.yaml").write_text(text, encoding="utf-8")
    model = fd.load_model(tmp_path / "m.yaml")
    assert model.joints["shoulder"] == fd.Joint(rotor_inertia=4e-5, stiffness=5000.0, damping=16.0)
    assert (model.joints["elbow"].elastic, model.gravity[2], model.tolerance) == (False, -9.81, 0.03)


def test_anchors_may_save_typing(tmp_path: Path) -> None:
    """Aliases and merge keys that stay small are read."""
    text = "flexdyn: 1\nrobot: {urdf: scara_two_link}\njoints:\n"
    text += "  shoulder: &drive {rotor_inertia: 0.1, stiffness: 50.0}\n  elbow: {<<: *drive, damping: 1.0}\n"
    (tmp_path / "m.yaml").write_text(text, encoding="utf-8")
    assert fd.load_model(tmp_path / "m.yaml").joints["elbow"] == fd.Joint(
        rotor_inertia=0.1, stiffness=50.0, damping=1.0
    )


@pytest.mark.parametrize(
    ("path", "remedy"),
    [
        ("joints.elbw.stiffness", "did you mean 'joints.elbow.stiffness'?"),
        ("effects[0].stall_torqe", "did you mean 'effects[0].stall_torque'?"),
        ("links.link1.mas", "did you mean 'links.link1.mass'?"),
    ],
)
def test_a_tolerance_of_a_number_that_is_not_there(path: str, remedy: str, tmp_path: Path) -> None:
    """A tolerance is set by the dotted path of a number; a path that leads nowhere is refused with the near miss."""
    model = fd.load_model("scara_two_link")
    fd.save_model(model.replace(tolerance={"*": 0.1, path: 0.2}), tmp_path / "model.yaml")
    with pytest.raises(fd.InputError) as caught:
        fd.load_model(tmp_path / "model.yaml")
    assert remedy in str(caught.value)
    assert f"tolerance.{path}" in str(caught.value)
