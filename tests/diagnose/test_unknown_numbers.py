"""Numbers that nobody knows are estimated, with intervals that hold, and what else is missing is still named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.hypothesis.unknown_numbers import with_guesses
from flexdyn.diagnose.report.calibrated import estimate
from flexdyn.model.uncertain_parameters import file_numbers

MASS, REACH, LEVEL, RATIO, RATE, INSIDE = 1.5, 0.2, 0.6, 50.0, 200, 40
PENDULUM = """<mujoco><compiler angle="radian"/>
<option timestep="{step}" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody><body><inertial pos="0 0 -{reach}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
<joint type="hinge" axis="0 1 0" armature="{rotor}" frictionloss="{level}"/></body></worldbody></mujoco>"""
URDF = """<robot name="pendulum"><link name="base"/>
<link name="bob"><inertial><origin xyz="0 0 -{reach}"/><mass value="{mass}"/>
<inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint></robot>"""


def swung(rotor: float, inertia: float, seconds: float = 5.0) -> fd.Recording:
    """MuJoCo's pendulum with a rotor [kg m^2, reflected] and Coulomb friction, under PD control, with noise.

    Args:
        rotor: armature of its joint [kg m^2].
        inertia: of the bob about its centre of mass [kg m^2].
        seconds: of the record [s].
    """
    step = 1.0 / (RATE * INSIDE)
    text = PENDULUM.format(step=step, reach=REACH, mass=MASS, inertia=inertia, rotor=rotor, level=LEVEL)
    model = mujoco.MjModel.from_xml_string(text)
    data, noise = mujoco.MjData(model), np.random.default_rng(1)
    speeds, phases = noise.uniform(1.0, 7.0, 4), noise.uniform(0.0, 6.28, 4)
    t = np.arange(int(seconds * RATE)) / RATE
    wanted = 0.35 * np.sin(np.outer(t, speeds) + phases).sum(axis=1)
    data.qpos[0], rows = wanted[0], np.empty((len(t), 2))
    for k in range(len(t)):
        torque = 60.0 * (wanted[k] - data.qpos[0]) - 6.0 * data.qvel[0]
        rows[k] = data.qpos[0], torque
        data.qfrc_applied[0] = torque
        mujoco.mj_step(model, data, nstep=INSIDE)
    rows += noise.normal(0.0, (2e-5, 0.01), rows.shape)
    return fd.Recording(t, {"q.hinge": rows[:, 0], "tau.hinge": rows[:, 1]})


def pendulum(folder: Path, inertia: float, joint: dict[str, Any], **settings: Any) -> fd.FlexibleJointModel:
    """Flexdyn's model of it, without the friction."""
    path = folder / "pendulum.urdf"
    path.write_text(URDF.format(reach=REACH, mass=MASS, inertia=inertia), encoding="utf-8")
    return fd.FlexibleJointModel(fd.load_robot(path), {"hinge": joint}, **settings)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> tuple[fd.Diagnosis, Path]:
    """Of a pendulum whose rotor nobody knows."""
    folder = tmp_path_factory.mktemp("unknown")
    joint = {"gear_ratio": -RATIO, "rotor_inertia": "unknown"}
    found = fd.diagnose(pendulum(folder, 0.02, joint, tolerance=0.01), [swung(0.8, 0.02)], progress=False)
    found.save(folder / "answer")
    return found, folder / "answer"


def test_an_unknown_rotor_inertia_is_recovered_within_its_interval(answer: tuple[fd.Diagnosis, Path]) -> None:
    """0.8 kg m^2 in MuJoCo, on the motor side of a gear of 50; the interval is a few percent wide at most."""
    document = json.loads((answer[1] / "report.json").read_text(encoding="utf-8"))
    entry = next(each for each in document["calibration"] if each["parameter"] == "rotor_inertia")
    low, high = entry["estimate"]["interval"]
    assert low < 0.8 / RATIO**2 < high
    assert high - low < 0.03 * 0.8 / RATIO**2
    assert entry["estimate"]["unit"] == "kg m^2"
    assert any("rotor inertia of hinge was not known: it is estimated as 3." in note for note in document["notes"])
    page = (answer[1] / "report.html").read_text(encoding="utf-8")
    assert "not known" in page


def test_friction_is_named_beside_it(answer: tuple[fd.Diagnosis, Path]) -> None:
    """Coulomb friction, and nothing else; MuJoCo is of first order in its step, so that its level is 2 % off."""
    (finding,) = answer[0].findings
    assert (finding.suspect.effect, finding.suspect.joint) == ("coulomb_friction", "hinge")
    assert finding.suspect.parameters["level"].value == pytest.approx(LEVEL, rel=0.03)


def test_the_corrected_model_holds_the_estimate(answer: tuple[fd.Diagnosis, Path]) -> None:
    """As a number like any other: it simulates."""
    model = fd.load_model(answer[1] / "model.yaml")
    assert model.joints["hinge"].reflected_inertia == pytest.approx(0.8, rel=0.01)
    assert not model.joints["hinge"].tolerances
    assert fd.simulate(model, duration=0.1).q.shape == (101, 1)


@pytest.mark.slow
@pytest.mark.parametrize("given", ["unknown", {"value": 0.0, "tolerance": 0.05}])
def test_a_link_whose_inertia_the_urdf_gives_as_0(tmp_path: Path, given: Any) -> None:
    """0.1 kg m^2 in MuJoCo, found beside a rotor that is known; the corrected model holds it."""
    tolerance = {"*": 0.002, "joints.hinge.rotor_inertia": 0.001}
    model = pendulum(tmp_path, 0.0, {"rotor_inertia": 0.8}, links={"bob": {"inertia": given}}, tolerance=tolerance)
    found = fd.diagnose(model, [swung(0.8, 0.1)], progress=False)
    found.save(tmp_path / "answer")
    document = json.loads((tmp_path / "answer" / "report.json").read_text(encoding="utf-8"))
    entry = next(each for each in document["calibration"] if each["parameter"] == "link_inertia")
    low, high = entry["estimate"]["interval"]
    assert low < 0.1 < high
    assert high - low < 0.01
    assert [each.suspect.effect for each in found.findings] == ["coulomb_friction"]
    assert fd.load_model(tmp_path / "answer" / "model.yaml").links["bob"].value == pytest.approx(0.1, rel=0.05)


def test_where_a_diagnosis_starts(tmp_path: Path) -> None:
    """The rotor as large as what the joint turns, give or take a hundred times; 0 with a tolerance near 0."""
    turned = MASS * REACH**2 + 0.02
    joint = {"gear_ratio": 10.0, "rotor_inertia": "unknown", "damping": "unknown", "stiffness": 400.0}
    started = with_guesses(pendulum(tmp_path, 0.02, joint))
    numbers = {each.parameter: each for each in file_numbers(started)}
    assert numbers["rotor_inertia"].value == pytest.approx(turned / 100.0, rel=1e-12)
    assert numbers["rotor_inertia"].tolerance == pytest.approx(100.0, rel=1e-12)
    critical = 2.0 * np.sqrt(400.0 * turned)
    assert numbers["damping"].value * numbers["damping"].tolerance == pytest.approx(critical, rel=1e-12)
    zero = with_guesses(pendulum(tmp_path, 0.02, {"rotor_inertia": {"value": 0.0, "tolerance": 2e-3}}))
    number = next(each for each in file_numbers(zero) if each.parameter == "rotor_inertia")
    assert [number.value, number.tolerance] == pytest.approx([2e-5, 100.0])
    assert number.is_open


def test_a_model_without_unknown_numbers_is_left_alone() -> None:
    """The very same one."""
    model = fd.load_model("ur5")
    assert with_guesses(model) is model


def test_nothing_says_how_large_a_rotor_may_be(tmp_path: Path) -> None:
    """A joint that turns no inertia: one line that asks for a tolerance."""
    text = URDF.format(reach=0.0, mass=MASS, inertia=0.0)
    (tmp_path / "point.urdf").write_text(text, encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(tmp_path / "point.urdf"), {"hinge": {"rotor_inertia": "unknown"}})
    with pytest.raises(fd.InputError, match=r"joints.hinge.rotor_inertia: its links move no inertia; give .* tol"):
        with_guesses(model)


@pytest.mark.slow
def test_rotors_and_dampings_of_elastic_joints() -> None:
    """All four of a two-link arm within 3 standard deviations, beside friction that is named."""
    known = {"gear_ratio": 1.0, "stiffness": 900.0, "damping": 1.5, "rotor_inertia": 0.3}
    arm = fd.load_model("scara_two_link").replace(joints={"*": known}, effects=[], tolerance=0.03)
    t = np.linspace(0.0, 5.0, 1001)
    sway = np.stack([0.6 * np.cos(1.1 * t) + 0.2 * np.cos(5 * t), 0.5 * np.cos(1.4 * t) + 0.1 * np.sin(7 * t)], axis=1)
    truth = arm.replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=0.6)])
    run = fd.simulate(truth, fd.PD(fd.Samples(t, sway, "cubic"), kp=400, kd=20), q0=sway[0], rate=200)
    noise, log, sigma = np.random.default_rng(0), run.to_recording(), {"q": 2e-6, "theta": 2e-6, "tau": 0.02}
    names = [f"{signal}.{joint}" for signal in sigma for joint in arm.joint_names]
    seen = {name: log[name] + noise.normal(0.0, sigma[name.split(".")[0]], run.t.size) for name in names}
    unknown = arm.replace(joints={"*": {"rotor_inertia": "unknown", "damping": "unknown"}})
    found = fd.diagnose(unknown, [fd.Recording(run.t, seen)], progress=False)
    assert [(each.suspect.effect, each.suspect.joint) for each in found.findings] == [("coulomb_friction", "elbow")]
    entries = [each for each in found.calibration if each.parameter in ("rotor_inertia", "damping")]
    assert len(entries) == 4
    for entry in entries:
        number = estimate(found.model, entry)
        assert abs(number.value - known[entry.parameter]) < 3.0 * number.std < 0.1 * number.value
