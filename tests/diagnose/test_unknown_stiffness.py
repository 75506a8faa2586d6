"""A stiffness that nobody knows is estimated where both encoders show the deflection; elsewhere the report says so."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.report.calibrated import estimate
from tests.diagnose.test_unknown_numbers import URDF

MASS, REACH, INERTIA, ROTOR, RATE, INSIDE = 1.5, 0.2, 0.02, 0.1, 500, 20
LINK = MASS * REACH**2 + INERTIA
DAMPING_RATIO = 0.025
PENDULUM = """<mujoco><compiler angle="radian"/>
<option timestep="{step}" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody><body><inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/>
<joint type="hinge" axis="0 1 0" armature="{rotor}" frictionloss="{level}"/>
<body><inertial pos="0 0 -{reach}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
<joint type="hinge" axis="0 1 0" stiffness="{stiffness}" damping="{damping}"/></body></body></worldbody></mujoco>"""


def stiffness_of(hertz: float) -> float:
    """Of the spring with which the link behind a held rotor vibrates at this frequency [N m/rad]."""
    return (math.tau * hertz) ** 2 * LINK


def swung(hertz: float, level: float = 0.0, signals: tuple[str, ...] = ("q", "theta")) -> fd.Recording:
    """MuJoCo's pendulum behind a spring, its rotor under PD control, with noise.

    Args:
        hertz: frequency of the spring and the link [Hz].
        level: Coulomb friction of the rotor [N m].
        signals: encoders that there are.
    """
    K, step = stiffness_of(hertz), 1.0 / (RATE * INSIDE)
    numbers = {"stiffness": K, "damping": 2.0 * DAMPING_RATIO * math.sqrt(K * LINK), "level": level, "step": step}
    text = PENDULUM.format(reach=REACH, mass=MASS, inertia=INERTIA, rotor=ROTOR, **numbers)
    model = mujoco.MjModel.from_xml_string(text)
    data, draw = mujoco.MjData(model), np.random.default_rng(1)
    speeds, phases = draw.uniform(1.0, 9.0, 5), draw.uniform(0.0, 6.28, 5)
    t = np.arange(6 * RATE) / RATE
    wanted = 0.3 * np.sin(np.outer(t, speeds) + phases).sum(axis=1)
    data.qpos[0], rows = wanted[0], np.empty((len(t), 3))
    for k in range(len(t)):
        torque = 30.0 * (wanted[k] - data.qpos[0]) - 2.0 * data.qvel[0]
        rows[k] = data.qpos[0] + data.qpos[1], data.qpos[0], torque
        data.qfrc_applied[0] = torque
        mujoco.mj_step(model, data, nstep=INSIDE)
    rows += draw.normal(0.0, (2e-6, 2e-6, 0.01), rows.shape)
    columns = dict(zip(("q", "theta", "tau"), rows.T, strict=True))
    return fd.Recording(t, {f"{signal}.hinge": columns[signal] for signal in (*signals, "tau")})


def pendulum(folder: Path, joint: dict[str, Any], **settings: Any) -> fd.FlexibleJointModel:
    """Flexdyn's model of it, without friction, whose stiffness nobody knows."""
    path = folder / "pendulum.urdf"
    path.write_text(URDF.format(reach=REACH, mass=MASS, inertia=INERTIA), encoding="utf-8")
    joints = {"hinge": {"rotor_inertia": ROTOR, "stiffness": "unknown", **joint}}
    return fd.FlexibleJointModel(fd.load_robot(path), joints, tolerance=0.03, **settings)


@pytest.mark.parametrize(("hertz", "level"), [(6.0, 0.0), (25.0, 0.4), (100.0, 0.0), (200.0, 0.0)])
def test_a_stiffness_is_recovered_within_its_interval(tmp_path: Path, hertz: float, level: float) -> None:
    """A thousandfold range of stiffness, with an unknown damping, beside friction that is named."""
    found = fd.diagnose(pendulum(tmp_path, {"damping": "unknown"}), [swung(hertz, level)], progress=False)
    assert [each.suspect.effect for each in found.findings] == (["coulomb_friction"] if level else [])
    entry = next(each for each in found.calibration if each.parameter == "stiffness")
    number = estimate(found.model, entry)
    assert abs(number.value - stiffness_of(hertz)) < 3.0 * number.std < 0.06 * stiffness_of(hertz)
    assert any("The stiffness of hinge was not known: it is estimated as" in note for note in found.notes)
    found.save(tmp_path / "answer")
    joint = fd.load_model(tmp_path / "answer" / "model.yaml").joints["hinge"]
    assert joint.stiffness == pytest.approx(number.value)
    assert not joint.tolerances


@pytest.mark.parametrize(("signals", "hertz"), [(("theta",), 6.0), pytest.param(("q",), 12.0, marks=pytest.mark.slow)])
def test_with_one_encoder_it_is_sought_like_a_missing_effect(
    tmp_path: Path, signals: tuple[str, ...], hertz: float
) -> None:
    """A finding, where the data show it; the note says that the model had the joint rigid."""
    found = fd.diagnose(pendulum(tmp_path, {}), [swung(hertz, 0.0, signals)], progress=False)
    elastic = next(each.suspect for each in found.findings if each.suspect.effect == "joint_elasticity")
    number = elastic.parameters["stiffness"]
    assert abs(number.value - stiffness_of(hertz)) < 3.0 * number.std < 0.1 * stiffness_of(hertz)
    assert any("was not known, and only one encoder shows it. The joint is taken for rigid" in n for n in found.notes)


def test_a_joint_that_is_too_stiff_for_its_encoders(tmp_path: Path) -> None:
    """At 2 kHz the deflection is a tenth of the noise: the report says how stiff it is at least."""
    found = fd.diagnose(pendulum(tmp_path, {}), [swung(2000.0)], progress=False)
    note = next(each for each in found.notes if "its encoders hardly show a deflection: it is about" in each)
    least = float(note.partition("it is about ")[2].split()[0])
    assert 0.01 * stiffness_of(2000.0) < least < stiffness_of(2000.0)
    assert not any(each.is_open for each in found.calibration)


def test_an_effect_of_the_spring_needs_both_encoders(tmp_path: Path) -> None:
    """A joint that is taken for rigid has no spring that could harden."""
    spring = fd.effects.HardeningSpring("hinge", cubic=10.0)
    model = pendulum(tmp_path, {}, effects=[spring])
    with pytest.raises(fd.InputError, match=r"effects\[0\].joint: hardening_spring needs an elastic joint"):
        fd.diagnose(model, [swung(25.0, 0.0, ("theta",))], progress=False)
