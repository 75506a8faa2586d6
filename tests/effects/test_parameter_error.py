"""A wrong number: the model with the error moves as the model with the true number."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect, JointElasticity, ParameterError, Payload, SensorGain
from tests.effects.arms import ELASTIC, RIGID, model_of, states
from tests.effects.reference import Arm

START: dict[str, Any] = {"q0": [-0.4, 0.7], "v0": [0.6, -0.5]}
URDF = """<robot name="rod"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0.1 0" rpy="0 0 0.3"/>
<mass value="{mass}"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<dynamics damping="{damping}" friction="{friction}"/></joint></robot>"""


def same_motion(one: fd.FlexibleJointModel, two: fd.FlexibleJointModel) -> None:
    """Both move alike to rounding."""
    runs = [fd.simulate(model, [0.4] * one.n, 0.3, q0=[0.1] * one.n, rate=200) for model in (one, two)]
    np.testing.assert_allclose(states(runs[0]), states(runs[1]), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(runs[0].energy.mechanical, runs[1].energy.mechanical, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("number", "factor"), [("stiffness", 1.2), ("damping", 0.5), ("rotor_inertia", 3.0)])
def test_a_number_of_a_joint(number: str, factor: float) -> None:
    """Stiffness, damping, inertia; the model's own numbers stay what was given."""
    wrong = model_of(ELASTIC, [ParameterError("elbow", parameter=number, factor=factor)])
    field = {"rotor_inertia": "rotor"}.get(number, number)
    first, second = getattr(ELASTIC, field)
    changed: dict[str, Any] = {field: (first, second * factor)}
    true = model_of(dataclasses.replace(ELASTIC, **changed))
    same_motion(wrong, true)
    assert wrong.joints == model_of(ELASTIC).joints
    assert wrong.resolved().joints == true.joints


def test_a_gear_ratio() -> None:
    """It enters the reflected inertia squared."""
    error = ParameterError("elbow", parameter="gear_ratio", factor=1.5)
    assert model_of(ELASTIC, [error]).resolved().rotor_inertia[1] == pytest.approx(0.1 * 2.25)


def test_numbers_of_effects() -> None:
    """A level, a payload's mass, a stiffness that is itself an effect, a sensor's gain; places count in the list."""
    given: list[Effect] = [
        ParameterError("effects[1]", parameter="level", factor=2.0),
        CoulombFriction("elbow", side="motor", level=0.1),
        ParameterError("effects[3]", parameter="mass", factor=0.5),
        Payload(mass=1.0),
        ParameterError("effects[5]", parameter="stiffness", factor=1.5),
        JointElasticity("elbow", stiffness=200.0),
        ParameterError("effects[7]", parameter="gain", factor=3.0),
        SensorGain("q.elbow", gain=0.1),
    ]
    true: list[Effect] = [
        CoulombFriction("elbow", side="motor", level=0.2),
        Payload(mass=0.5),
        JointElasticity("elbow", stiffness=300.0),
        SensorGain("q.elbow", gain=0.1 * 3.0),
    ]
    one, two = model_of(RIGID, given), model_of(RIGID, true)
    same_motion(one, two)
    assert one.resolved().effects == two.resolved().effects
    run = fd.simulate(one, None, 0.1, **START)
    np.testing.assert_allclose(run.to_recording()["q.elbow"], 1.3 * run.q[:, 1], rtol=1e-14)


def test_errors_on_one_number_multiply() -> None:
    """1.2 and 1.5 make 1.8; a neutral one makes no model anew."""
    errors = [ParameterError("elbow", parameter="stiffness", factor=f) for f in (1.2, 1.0, 1.5)]
    assert model_of(ELASTIC, errors).resolved().stiffness[1] == pytest.approx(1.8 * 200.0)
    neutral = model_of(ELASTIC, [errors[1]])
    assert neutral.resolved() is neutral


def test_numbers_of_the_urdf(tmp_path: Path) -> None:
    """Mass of a link, <dynamics damping friction>: as if the file had been written so."""
    robots = {}
    for name, numbers in {
        "given": {"mass": 2.0, "damping": 0.3, "friction": 0.2},
        "true": {"mass": 3.0, "damping": 0.15, "friction": 0.5},
    }.items():
        path = tmp_path / f"{name}.urdf"
        path.write_text(URDF.format(**numbers), encoding="utf-8")
        robots[name] = fd.load_robot(path)
    errors = [
        ParameterError("arm", parameter="link_mass", factor=1.5),
        ParameterError("turn", parameter="urdf_damping", factor=0.5),
        ParameterError("turn", parameter="urdf_friction", factor=2.5),
    ]
    gravity = [0.0, -9.81, 0.0]
    wrong = fd.FlexibleJointModel(robots["given"], effects=errors, gravity=gravity)
    same_motion(wrong, fd.FlexibleJointModel(robots["true"], gravity=gravity))
    with pytest.raises(fd.InputError, match=r"^robot\.urdf: "):  # its URDF has the wrong numbers
        fd.save_model(wrong.resolved(), tmp_path / "true.yaml")
    fd.save_model(wrong, tmp_path / "wrong.yaml")
    same_motion(fd.load_model(tmp_path / "wrong.yaml"), wrong)


@pytest.mark.parametrize(
    ("of", "number", "words"),
    [
        ("elbo", "stiffness", r"of: no such joint, link or effect, got 'elbo'; did you mean 'elbow'"),
        ("elbow", "stifness", r"parameter: a joint has no such number, got 'stifness'; did you mean 'stiffness'"),
        ("effects[2]", "level", r"of: no such effect in the model, got 'effects\[2\]'; they count from 0 to 1"),
        ("effects[x]", "level", r"of: no such effect in the model, got 'effects\[x\]'"),
        ("effects[0]", "factor", r"of: a parameter error has none itself"),
        ("effects[1]", "lvl", r"parameter: coulomb_friction has no such number, got 'lvl'; did you mean 'level'"),
        ("link9", "link_mass", r"link: no such link, got 'link9'; did you mean"),
        ("base", "link_mass", r"link: the link does not move"),
    ],
)
def test_a_number_that_is_not_there(of: str, number: str, words: str) -> None:
    """Refused when the model is made, in one line."""
    effects: list[Effect] = [
        ParameterError(of, parameter=number, factor=2.0),
        CoulombFriction("elbow", side="link", level=0.1),
    ]
    with pytest.raises(fd.InputError, match=rf"^effects\[0\]\.{words}"):
        model_of(ELASTIC, effects)


def test_a_rigid_joint_has_no_stiffness_to_be_wrong() -> None:
    """Infinity times a factor says nothing."""
    error = ParameterError("elbow", parameter="stiffness", factor=2.0)
    with pytest.raises(fd.InputError, match=r"^effects\[0\]\.parameter: the joint is rigid"):
        model_of(RIGID, [error])


@pytest.mark.parametrize("entry", [{"of": "", "parameter": "level"}, {"of": "elbow", "parameter": 3}])
def test_names_are_names(entry: Any) -> None:
    """Both are text."""
    with pytest.raises(fd.InputError, match=r"^parameter_error\.(of|parameter): a name is needed"):
        ParameterError(factor=1.0, **entry)


def test_a_corrected_number_can_be_saved(tmp_path: Path) -> None:
    """The resolved model is a model: it saves and reads back without the errors."""
    error = ParameterError("elbow", parameter="stiffness", factor=1.25)
    true = model_of(Arm((300.0, 250.0), (0.5, 0.3), (0.1, 0.1)))
    resolved = model_of(ELASTIC, [error]).resolved()
    fd.save_model(resolved, tmp_path / "true.yaml")
    assert fd.load_model(tmp_path / "true.yaml").joints == true.joints
