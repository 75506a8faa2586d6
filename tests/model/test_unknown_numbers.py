"""Numbers that are unknown or known to an absolute tolerance: read, written, refused where one is needed."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import repickled

ARM = """<robot name="rod"><link name="base"/>
<link name="rod"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/></joint></robot>"""
STRIBECK = {"effect": "stribeck_friction", "joint": "hinge", "side": "motor"}
UNKNOWN = {"hinge": {"rotor_inertia": "unknown"}}


def rod(folder: Path, joints: Any = None, **settings: Any) -> fd.FlexibleJointModel:
    """A point mass of 2 kg at 0.3 m on a hinge: its URDF gives no inertia."""
    path = folder / "rod.urdf"
    path.write_text(ARM, encoding="utf-8")
    return fd.FlexibleJointModel(fd.load_robot(path), joints, **settings)


def test_what_is_unknown_is_written_and_read_again(tmp_path: Path) -> None:
    """A model file holds the word, and the tolerance, as they were given; pickles and copies too."""
    joints = {"hinge": {"gear_ratio": -50.0, "rotor_inertia": "unknown", "damping": {"value": 0.0, "tolerance": 0.2}}}
    model = rod(tmp_path, joints, links={"rod": {"inertia": {"value": 0.01, "tolerance": 0.02}}})
    fd.save_model(model, tmp_path / "model.yaml")
    again = fd.load_model(tmp_path / "model.yaml").replace(name=model.name)
    assert again == model == repickled(model) == model.replace(joints={"hinge": {"gear_ratio": -50.0}})
    assert again.joints["hinge"].given("rotor_inertia").is_unknown
    assert again.joints["hinge"].given("damping").tolerance == 0.2
    text = (tmp_path / "model.yaml").read_text(encoding="utf-8")
    assert "rotor_inertia: unknown" in text
    assert "links:" in text


@pytest.mark.parametrize(
    "use",
    [
        lambda model: fd.simulate(model, duration=0.1),
        fd.LinkSide,
        fd.modes,
    ],
)
def test_nothing_is_computed_without_the_number(tmp_path: Path, use: Callable[[Any], Any]) -> None:
    """One line with the key, the unit and how to estimate it; a number given after all is taken."""
    model = rod(tmp_path, {"hinge": {"rotor_inertia": "unknown", "stiffness": 100.0}})
    words = r"^joints.hinge.rotor_inertia: the number is unknown.*kg m\^2.*flexdyn diagnose$"
    with pytest.raises(fd.InputError, match=words):
        use(model)
    use(model.replace(joints={"hinge": {"rotor_inertia": 0.1}}))
    with pytest.raises(fd.InputError, match=r"^links.rod.inertia: the number is unknown"):
        use(model.replace(joints={"hinge": {"rotor_inertia": 0.1}}, links={"rod": {"inertia": "unknown"}}))


def test_an_unknown_stiffness(tmp_path: Path) -> None:
    """The joint is elastic; nothing is computed without the number, and a file holds the word."""
    model = rod(tmp_path, {"hinge": {"rotor_inertia": 0.1, "stiffness": "unknown"}})
    assert model.elastic.all()
    with pytest.raises(fd.InputError, match=r"^joints.hinge.stiffness: the number is unknown.*; write it in N m/rad, "):
        fd.simulate(model, duration=0.1)
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").replace(name=model.name) == model == repickled(model)
    known = model.replace(joints={"hinge": {"stiffness": 50.0}})
    assert fd.simulate(known, duration=0.1).q.shape == (101, 1)


def test_an_inertia_of_a_link_stands_in_place_of_the_urdfs(tmp_path: Path) -> None:
    """M = m r^2 + I about the hinge; the resolved model has it in its robot."""
    model = rod(tmp_path, links={"rod": {"inertia": 0.05}})
    assert fd.LinkSide(model).mass_matrix([0.0])[0, 0] == pytest.approx(2.0 * 0.3**2 + 0.05, rel=1e-14)
    assert not model.resolved().links
    error = fd.effects.ParameterError("rod", parameter="link_inertia", factor=2.0)
    heavier = model.replace(effects=[error])
    assert fd.LinkSide(heavier).mass_matrix([0.0])[0, 0] == pytest.approx(2.0 * 0.3**2 + 0.1, rel=1e-14)


def test_an_absolute_tolerance_is_the_one_that_holds(tmp_path: Path) -> None:
    """As a share of the value, and before a relative one of the same number."""
    joints = {"hinge": {"rotor_inertia": {"value": 0.1, "tolerance": 0.02}}}
    links = {"rod": {"inertia": {"value": 0.05, "tolerance": 0.1}}}
    model = rod(tmp_path, joints, links=links, tolerance={"*": 0.03, "joints.hinge.rotor_inertia": 0.5})
    found = {(number.of, number.parameter): number.tolerance for number in file_numbers(model)}
    assert found["hinge", "rotor_inertia"] == pytest.approx(0.2)
    assert found["rod", "link_inertia"] == pytest.approx(2.0)
    assert found["rod", "link_mass"] == 0.03


def known_roughly(folder: Path, **changes: Any) -> fd.FlexibleJointModel:
    """The rod with a motor and friction, and absolute tolerances of the numbers of both and of its mass."""
    motor = {"torque_constant": {"value": 0.05, "tolerance": 0.01}, "resistance": 2.0, "supply": 24.0}
    friction = {"effect": "viscous_friction", "joint": "hinge", "side": "motor"}
    content = {
        "joints": {"*": {"rotor_inertia": 0.1, "actuator": {"dc_motor": motor}}},
        "links": {"rod": {"mass": {"tolerance": 0.3}, "inertia": {"value": 0.05, "tolerance": 0.1}}},
        "effects": [friction | {"coefficient": {"value": 3.0, "tolerance": 1.5}}],
    }
    return rod(folder, **{**content, **changes})


def test_numbers_of_motors_effects_and_masses_have_absolute_tolerances_too(tmp_path: Path) -> None:
    """Each as a share of its value, before a relative one of the same number; a file holds the shares."""
    model = known_roughly(tmp_path, tolerance={"*": 0.03, "effects[0].coefficient": 0.9})
    found = {(number.of, number.parameter): number.tolerance for number in file_numbers(model)}
    assert found["hinge", "torque_constant"] == pytest.approx(0.2)
    assert found["hinge", "resistance"] == 0.03
    assert found["effects[0]", "coefficient"] == pytest.approx(0.5)
    assert found["rod", "link_mass"] == pytest.approx(0.15)
    assert found["rod", "link_inertia"] == pytest.approx(2.0)
    assert model.effects[0].values == (3.0,)
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").replace(name=model.name) == model == repickled(model)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"joints": {"hinge": {"actuator": {"dc_motor": {"supply": "unknown"}}}}},
            "joints.hinge.actuator.dc_motor.supply: this number cannot be unknown, got 'unknown'; write the number",
        ),
        (
            {"joints": {"hinge": {"actuator": {"dc_motor": {"supply": {"value": 24, "tolerance": 1}}}}}},
            "joints.hinge.actuator.dc_motor.supply: no diagnosis estimates this number; write the number alone",
        ),
        (
            {"effects": [{"effect": "torque_offset", "joint": "hinge", "offset": {"value": 0, "tolerance": 0.2}}]},
            "effects[0].offset: a tolerance here is a share of the value, got 0.0; give a value other than 0, or leave",
        ),
        (
            {"effects": [{"effect": "torque_constant_error", "joint": "hinge", "gain": "unknown"}]},
            "effects[0].gain: this number cannot be unknown, got 'unknown'; leave the effect out: a diagnosis finds",
        ),
        (
            {"effects": [{"effect": "torque_saturation", "joint": "hinge", "scale": "unknown"}]},
            "effects[0].scale: this number cannot be unknown, got 'unknown'; leave the effect out: a",
        ),
        (
            {"effects": [{"effect": "torque_ripple", "joint": "hinge", "harmonic": "unknown"}]},
            "effects[0].harmonic: this number cannot be unknown, got 'unknown'; leave the effect out: a",
        ),
        (
            {"effects": [{"effect": "payload", "mass": {"value": 1.0, "tolerance": 0.2}}]},
            "effects[0].mass: no diagnosis estimates this number; write the number alone",
        ),
        ({"links": {"rod": {"mass": 3.0}}}, "links.rod.mass: the URDF gives it as 2 kg, got 3.0; change it there"),
        ({"links": {"base": {"mass": "unknown"}}}, "links.base: the link does not move: its mass has no effect"),
        ({"links": {"rodd": {"mass": 2.0}}}, "links.rodd: no such link; did you mean 'rod'?"),
        ({"links": {"rod": {"com": {"tolerance": 0.1}}}}, "links.rod.com: a link has no such key; known: "),
    ],
)
def test_a_tolerance_that_no_diagnosis_can_use_is_refused(tmp_path: Path, changes: Any, words: str) -> None:
    """One line with its key and what would be right."""
    with pytest.raises(fd.InputError) as caught:
        known_roughly(tmp_path, **changes)
    assert str(caught.value).startswith(words)


def test_unknown_sizes_and_masses_are_written_and_refused(tmp_path: Path) -> None:
    """A file holds the word; a simulation names key and unit; a number given after all is taken."""
    friction = {"effect": "coulomb_friction", "joint": "hinge", "side": "motor", "level": "unknown"}
    effects = [STRIBECK | {"excess": 2.0, "velocity": 0.1}, friction]
    model = rod(tmp_path, {"hinge": {"rotor_inertia": 0.1}}, effects=effects, links={"rod": {"mass": "unknown"}})
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").replace(name=model.name) == model == repickled(model)
    text = (tmp_path / "model.yaml").read_text(encoding="utf-8")
    assert "level: unknown" in text
    assert "mass: unknown" in text
    assert "inf" not in text.replace("stiffness: .inf", "")
    with pytest.raises(fd.InputError, match=r"^links.rod.mass: the number is unknown.*; write it in kg, or estimate"):
        fd.simulate(model, duration=0.1)
    told = model.replace(links={"rod": {"mass": {"tolerance": 0.2}}})
    with pytest.raises(fd.InputError, match=r"^effects\[1\].level: the number is unknown.*; write it in N m, or"):
        fd.simulate(told, duration=0.1)
    known = told.replace(effects=[model.effects[0], model.effects[1].replace(level=0.5)])
    assert fd.simulate(known, duration=0.1).q.shape == (101, 1)
    assert {each.parameter: each.tolerance for each in file_numbers(known)}["level"] == 0.05


def test_unknown_numbers_of_either_sign_of_shapes_and_of_motors(tmp_path: Path) -> None:
    """Likewise; the placeholders are not in the file."""
    offset = {"effect": "torque_offset", "joint": "hinge", "offset": "unknown"}
    effects = [STRIBECK | {"excess": 2.0, "velocity": "unknown"}, offset]
    motor = {"torque_constant": 0.05, "resistance": "unknown"}
    drive = {"rotor_inertia": 0.1, "actuator": {"dc_motor": motor}}
    for joint in ("hinge", "*"):
        model = rod(tmp_path, {joint: drive}, effects=effects)
        fd.save_model(model, tmp_path / "model.yaml")
        text = (tmp_path / "model.yaml").read_text(encoding="utf-8")
        assert [f"{key}: unknown" in text for key in ("velocity", "offset", "resistance")] == [True] * 3
        assert "e-1" not in text
        assert fd.load_model(tmp_path / "model.yaml").replace(name=model.name) == model == repickled(model)
    with pytest.raises(
        fd.InputError, match=r"^joints.hinge.actuator.dc_motor.resistance: the number is .*write it in ohm"
    ):
        fd.simulate(model, duration=0.1)
    told = model.replace(joints={"hinge": {"actuator": {"dc_motor": {"torque_constant": 0.05, "resistance": 2.0}}}})
    with pytest.raises(fd.InputError, match=r"^effects\[0\].velocity: the number is unknown.*; write it in rad/s, or"):
        fd.simulate(told, duration=0.1)


def test_a_file_says_unknown_and_not_an_infinite_tolerance(tmp_path: Path) -> None:
    """In one line."""
    rod(tmp_path)
    (tmp_path / "model.yaml").write_text(
        "flexdyn: 1\nrobot: {urdf: rod.urdf}\ntolerance: {links.rod.mass: .inf}\n", encoding="utf-8"
    )
    with pytest.raises(fd.InputError, match=r"tolerance.links.rod.mass: a finite number .*; write unknown for the num"):
        fd.load_model(tmp_path / "model.yaml")


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        ({"stiffness": "unknown"}, "joints.hinge.rotor_inertia: an elastic joint needs it above 0; give the rotor's"),
        ({"stiffness": 0.0}, "joints.hinge.stiffness: it must be above 0, got 0.0; use .inf for a rigid joint"),
        ({"gear_ratio": "unknown"}, "joints.hinge.gear_ratio: it must be a number, got 'unknown'; all signals"),
        ({"gear_ratio": {"value": 5, "tolerance": 1}}, "joints.hinge.gear_ratio: it must be a number"),
        ({"rotor_inertia": "unknwon"}, "joints.hinge.rotor_inertia: a number is needed, got 'unknwon'"),
        ({"rotor_inertia": {"value": 0.0}}, "joints.hinge.rotor_inertia.tolerance: it is missing; write {value"),
        ({"rotor_inertia": {"tolerance": 1.0}}, "joints.hinge.rotor_inertia.value: it is missing"),
        ({"rotor_inertia": {"value": 0, "tolerence": 1}}, "joints.hinge.rotor_inertia.tolerence: no such key"),
        ({"rotor_inertia": {"value": 0, "tolerance": 0}}, "joints.hinge.rotor_inertia.tolerance: a number above 0"),
        ({"rotor_inertia": {"value": math.inf, "tolerance": 1}}, "joints.hinge.rotor_inertia.value: a finite number"),
        ({"rotor_inertia": {"value": -1, "tolerance": 1}}, "joints.hinge.rotor_inertia: it must be finite and at"),
        (
            {"stiffness": 10.0, "rotor_inertia": {"value": 0, "tolerance": 1}},
            "joints.hinge.rotor_inertia: an elastic joint needs it above 0; give the rotor's inertia",
        ),
    ],
)
def test_a_number_that_is_neither_is_refused(tmp_path: Path, joint: Any, words: str) -> None:
    """One line with its key and what would be right."""
    with pytest.raises(fd.InputError) as caught:
        rod(tmp_path, {"hinge": joint})
    assert str(caught.value).startswith(words)


@pytest.mark.parametrize(
    ("links", "words"),
    [
        ([], "links: links are a mapping by name"),
        ({"rod": 0.1}, "links.rod: a link's inertia is needed, got 0.1; write {inertia: 0.01}"),
        ({"rod": {"inertia": 0.1, "com": 2.0}}, "links.rod.com: a link has no such key"),
        ({"rodd": {"inertia": 0.1}}, "links.rodd: no such link; did you mean 'rod'?"),
        ({"base": {"inertia": 0.1}}, "links.base: the link does not move"),
        ({"rod": {"inertia": -0.1}}, "links.rod.inertia: it must be finite and at least 0, got -0.1"),
        ({"rod": {"inertia": None}}, "links.rod.inertia: a number is needed; write unknown"),
    ],
)
def test_a_link_that_cannot_have_it_is_refused(tmp_path: Path, links: Any, words: str) -> None:
    """One line with its key and what would be right."""
    with pytest.raises(fd.InputError) as caught:
        rod(tmp_path, links=links)
    assert str(caught.value).startswith(words)


def test_no_factor_changes_what_is_unknown(tmp_path: Path) -> None:
    """A parameter error multiplies a number that is there."""
    error = fd.effects.ParameterError("hinge", parameter="rotor_inertia", factor=2.0)
    with pytest.raises(fd.InputError, match=r"effects\[0\].parameter: the number is unknown"):
        rod(tmp_path, UNKNOWN, effects=[error])


def test_a_motor_that_turns_the_other_way(tmp_path: Path) -> None:
    """Everything is reflected: a negative gear ratio changes nothing but the rotor's spin, which has its sign."""
    numbers = {"rotor_inertia": 1e-3, "stiffness": 40.0, "damping": 0.1}
    there, back = (rod(tmp_path, {"hinge": {**numbers, "gear_ratio": ratio}}) for ratio in (20.0, -20.0))
    runs = [fd.simulate(model, [0.5], duration=0.5) for model in (there, back)]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert np.array_equal(runs[0].theta, runs[1].theta)
    assert back.joints["hinge"].reflected_inertia == there.joints["hinge"].reflected_inertia


SPRUNG = """flexdyn: 1
robot: {urdf: scara_two_link}
joints: {shoulder: {stiffness: 400, rotor_inertia: 0.1}, elbow: {stiffness: 300, rotor_inertia: 0.1}}
effects:
  - {effect: transmission_damping, joint: shoulder, coefficient: 1.0}
  - {effect: parameter_error, of: elbow, parameter: stiffness, factor: 1.1}
  - {effect: viscous_friction, joint: shoulder, side: motor, coefficient: unknown}
  - {effect: coulomb_friction, joint: elbow, side: motor, level: {value: 0.2, tolerance: 0.1}}
"""


def test_tolerances_stay_with_their_effects(tmp_path: Path) -> None:
    """Where effects before them are left out; what is unknown is refused there, and not taken for 0."""
    (tmp_path / "model.yaml").write_text(SPRUNG, encoding="utf-8")
    model = fd.load_model(tmp_path / "model.yaml")
    for fewer, first in ((model.resolved(), 1), (model.rigid(), 0)):
        assert [each.name for each in fewer.effects[first:]] == ["viscous_friction", "coulomb_friction"]
        own = {f"effects[{first}].coefficient": math.inf, f"effects[{first + 1}].level": pytest.approx(0.5)}
        assert fewer.tolerance == {"*": 0.05, **own}
        with pytest.raises(fd.InputError, match=rf"^effects\[{first}\]\.coefficient: the number is unknown"):
            fd.simulate(fewer, duration=0.01)
