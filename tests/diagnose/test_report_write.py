"""The files of a report: all or nothing, the corrected model with its numbers put right, and when there is none."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from tests.arms import repickled
from tests.diagnose import report_cases as cases

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
ALL = ["model.yaml", "report.html", "report.json"]


def test_a_report_is_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the new one cannot be finished, the old one is untouched and nothing else is left behind."""
    cases.explained().save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fails(*arguments: Any, **settings: Any) -> str:
        raise MemoryError

    monkeypatch.setattr(sys.modules["flexdyn.diagnose.report.write"], "report_page", fails)
    with pytest.raises(MemoryError):
        cases.no_discrepancy().save(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_corrected_model_that_is_worse_is_not_written(tmp_path: Path) -> None:
    """One of an earlier report goes; page and JSON say that there is none, and why."""
    cases.explained().save(tmp_path)
    assert _names(tmp_path) == ALL
    cases.not_converged().save(tmp_path)
    assert _names(tmp_path) == ALL[1:]
    said = "model.yaml was not written: on the data of the fit the corrected model is worse than the model as it was"
    assert (tmp_path / "report.html").read_text(encoding="utf-8").count(said) == 2, "at the top and at the foot"
    assert [note for note in _notes(tmp_path) if note.startswith(said)]


def test_a_model_file_of_somebody_else_stays(tmp_path: Path) -> None:
    """Only what a diagnosis wrote is removed."""
    fd.save_model(fd.load_model("scara_two_link"), tmp_path / "model.yaml")
    before = (tmp_path / "model.yaml").read_bytes()
    cases.not_converged().save(tmp_path)
    assert (tmp_path / "model.yaml").read_bytes() == before


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    """A file where the folder should be is one clear line."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(fd.InputError, match="file: it is a file; give a folder"):
        cases.no_discrepancy().save(tmp_path / "file")


def test_without_plotly_nothing_is_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra that is missing is named."""
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(fd.MissingExtra, match=r"flexdyn\[plot\]"):
        cases.explained().save(tmp_path)
    assert not list(tmp_path.iterdir())


def test_an_interrupt_is_one_that_carries_what_is_known() -> None:
    """Uncaught it ends a program as Ctrl-C does."""
    diagnosis = cases.interrupted()
    assert isinstance(Interrupted(diagnosis), KeyboardInterrupt)
    assert Interrupted(diagnosis).diagnosis is diagnosis
    assert Interrupted().diagnosis is None


def test_a_diagnosis_travels_between_processes() -> None:
    """Pickled and back it says the same."""
    diagnosis = cases.explained()
    assert repickled(diagnosis).to_dict() == diagnosis.to_dict()


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
    assert _names(tmp_path) == ALL
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
    assert _names(tmp_path) == ALL[1:]
    said = "model.yaml was not written: the robot came from a pin.Model and has no URDF to name."
    assert _notes(tmp_path) == [said]
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert said in text
    assert "is worse" not in text


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
    return dataclasses.replace(cases.no_discrepancy(), model=model, calibration=())


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def _notes(folder: Path) -> list[str]:
    notes: list[str] = json.loads((folder / "report.json").read_text(encoding="utf-8"))["notes"]
    return notes
