"""The corrected model that a diagnosis writes: numbers put right where they stand, and the same motion."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.result import Diagnosis, Finding, Gap
from tests.diagnose import answers

ARM = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0.01 0" rpy="0 0.3 0"/><mass value="2.0"/>
<inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.05" iyz="0" izz="0.06"/></inertial>
<visual><geometry><mesh filename="meshes/upper.stl"/></geometry></visual></link>
<link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="1.0"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="10"/><dynamics damping="0.7" friction="0.2"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="100" velocity="10"/></joint></robot>"""


def test_the_corrected_model_is_folded_and_moves_alike(tmp_path: Path) -> None:
    """Errors of joints, effects, links and <dynamics>: none is left in model.yaml, and the arm moves as it should."""
    model = _wrong_arm(tmp_path)
    _diagnosis(model).save(tmp_path / "out" / "deeper")
    saved = fd.load_model(tmp_path / "out" / "deeper" / "model.yaml")
    assert [effect.name for effect in saved.effects] == ["coulomb_friction", "sensor_offset"]
    assert saved.joints["shoulder"].stiffness == 1.31 * 900.0
    assert saved.joints["elbow"].stiffness == 700.0, "the elasticity that was found"
    assert saved.effects[0].to_dict()["level"] == 0.9 * 0.5
    assert dict(saved.tolerance) == {"*": 0.03, "effects[0].level": 0.2}  # type: ignore[arg-type]
    assert saved.robot.damping == pytest.approx([1.5 * 0.7, 0.0], rel=1e-15)
    q, v = np.array([0.3, -0.8]), np.array([1.0, 2.0])
    one, two = (fd.LinkSide(each.resolved()).mass_matrix(q) for each in (model, saved))
    np.testing.assert_allclose(one, two, rtol=1e-13)
    runs = [fd.simulate(each, [4.0, 1.0], duration=0.3, q0=q, v0=v) for each in (model, saved)]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-10)


def test_a_model_whose_joints_alone_are_wrong_moves_bit_for_bit(tmp_path: Path) -> None:
    """Then the URDF stays the one that it was."""
    error = fd.effects.ParameterError("elbow", parameter="stiffness", factor=1.1)
    model = fd.load_model("scara_two_link")
    model = model.replace(effects=[*model.effects, error])
    _diagnosis(model).save(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.yaml", "report.html", "report.json"]
    saved = fd.load_model(tmp_path / "model.yaml")
    assert saved.robot.source == model.robot.source
    runs = [fd.simulate(each, [0.4, 0.1], duration=0.2) for each in (model, saved)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_the_corrected_urdf_finds_its_meshes(tmp_path: Path) -> None:
    """It lies elsewhere than the one that it comes from, which stays as it was."""
    model = _wrong_arm(tmp_path)
    before = (tmp_path / "arm.urdf").read_text(encoding="utf-8")
    _diagnosis(model).save(tmp_path / "out")
    assert (tmp_path / "arm.urdf").read_text(encoding="utf-8") == before
    text = (tmp_path / "out" / "arm_corrected.urdf").read_text(encoding="utf-8")
    assert 'filename="../meshes/upper.stl"' in text


def test_a_robot_without_a_urdf_has_a_report_all_the_same(tmp_path: Path) -> None:
    """The page and the JSON say that there is no model file, and why."""
    robot = fd.load_robot(fd.load_robot("scara_two_link").pin_model)
    _diagnosis(fd.FlexibleJointModel(robot)).save(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "report.json"]
    notes = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["notes"]
    assert notes == ["model.yaml was not written: the robot came from a pin.Model and has no URDF to name."]


def test_an_urdf_that_is_gone_leaves_parameter_errors(tmp_path: Path) -> None:
    """What cannot be folded into a file is told in model.yaml, none of it lost."""
    model = _wrong_arm(tmp_path)
    (tmp_path / "arm.urdf").unlink()
    _diagnosis(model).save(tmp_path / "out")
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")
    saved = fd.load_model(tmp_path / "out" / "model.yaml")
    left = {(e.of, e.parameter): e.factor for e in saved.effects if isinstance(e, fd.effects.ParameterError)}
    assert left == {("lower", "link_mass"): 1.1, ("upper", "link_com"): 0.95, ("upper", "link_inertia"): 1.2} | {
        ("shoulder", "urdf_damping"): 1.5
    }


def _wrong_arm(folder: Path) -> fd.FlexibleJointModel:
    """An arm with something wrong of every kind."""
    (folder / "meshes").mkdir()
    (folder / "meshes" / "upper.stl").write_bytes(b"solid\nendsolid\n")
    (folder / "arm.urdf").write_text(ARM, encoding="utf-8")

    def wrong(of: str, parameter: str, factor: float) -> fd.effects.ParameterError:
        return fd.effects.ParameterError(of, parameter=parameter, factor=factor)

    return fd.FlexibleJointModel(
        fd.load_robot(folder / "arm.urdf"),
        {"shoulder": {"rotor_inertia": 0.1, "stiffness": 900.0, "damping": 1.0}, "elbow": {"rotor_inertia": 0.05}},
        [
            fd.effects.JointElasticity("elbow", stiffness=700.0),
            wrong("shoulder", "stiffness", 1.31),
            fd.effects.CoulombFriction("elbow", side="motor", level=0.5),
            wrong("effects[2]", "level", 0.9),
            wrong("lower", "link_mass", 1.1),
            wrong("upper", "link_com", 0.95),
            wrong("upper", "link_inertia", 1.2),
            wrong("shoulder", "urdf_damping", 1.5),
            fd.effects.SensorOffset("q.elbow", offset=0.01),
        ],
        tolerance={"*": 0.03, "effects[2].level": 0.2, "effects[0].stiffness": 0.1},
    )


def _diagnosis(model: fd.FlexibleJointModel) -> Diagnosis:
    gap = Gap(3.0, 2.0, 1.0, 1.0)
    return Diagnosis("explained", (Finding(answers.WRONG, 50.0, 0.9),), (), gap, gap, (), model)
