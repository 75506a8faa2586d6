"""Friction of one motor of a differential is named at that motor, although both joints feel it.

Also where the model has what acts on both motors: a spring on a joint, or motors that rub on each other.
"""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

import flexdyn as fd
from tests.physics.test_axes import TENDONS, WRIST

LEVEL, RATE, INSIDE, SECONDS = 0.5, 200, 40, 3.0
A = np.array([[1.0, 1.0], [1.0, -1.0]])
AXES = {"left": {"pitch": 1.0, "roll": 1.0}, "right": {"pitch": 1.0, "roll": -1.0}}


def moved(*more: tuple[str, str]) -> fd.Recording:
    """MuJoCo's wrist under PD control of its axes, dry friction on the left tendon; what its motors see, with noise.

    Args:
        more: what else is replaced in its XML.
    """
    text = TENDONS.replace('armature="0.3"', f'armature="0.3" frictionloss="{LEVEL}"')
    for old, new in more:
        assert old in text
        text = text.replace(old, new)
    text = text.replace(
        'integrator="RK4" timestep="0.0005"', f'integrator="implicitfast" timestep="{1 / RATE / INSIDE}"'
    )
    model = mujoco.MjModel.from_xml_string(text)
    data, noise = mujoco.MjData(model), np.random.default_rng(1)
    t = np.arange(int(SECONDS * RATE)) / RATE
    speeds, phases = noise.uniform(1.0, 7.0, (2, 4, 1)), noise.uniform(0.0, 6.28, (2, 4, 1))
    wanted = 0.3 * np.sin(speeds * t + phases).sum(axis=1).T
    data.qpos[:] = np.linalg.solve(A, wanted[0])
    rows = np.empty((len(t), 4))
    for k in range(len(t)):
        torque = 60.0 * (wanted[k] - A @ data.qpos) - 6.0 * (A @ data.qvel)
        rows[k] = *(A @ data.qpos), *torque
        data.ctrl[:] = torque
        mujoco.mj_step(model, data, nstep=INSIDE)
    rows += noise.normal(0.0, (2e-5, 2e-5, 0.01, 0.01), rows.shape)
    return fd.Recording(t, dict(zip(("q.left", "q.right", "tau.left", "tau.right"), rows.T, strict=True)))


def wrist(folder: Path, *effects: fd.effects.Effect) -> fd.FlexibleJointModel:
    """The same wrist without dry friction of its motors."""
    path = folder / "wrist.urdf"
    path.write_text(WRIST, encoding="utf-8")
    drives = {"left": {"rotor_inertia": 0.3}, "right": {"rotor_inertia": 0.4}}
    viscous = [
        fd.effects.ViscousFriction(name, side="motor", coefficient=c) for name, c in (("left", 0.2), ("right", 0.1))
    ]
    arm = fd.load_robot(path).with_axes(AXES)
    return fd.FlexibleJointModel(arm, drives, [*viscous, *effects], tolerance=0.02)


def told(found: fd.Diagnosis) -> None:
    """The friction of the left motor, and nothing else."""
    (finding,) = found.findings
    assert (finding.suspect.effect, finding.suspect.joint) == ("coulomb_friction", "left")
    assert finding.suspect.parameters["level"].value == pytest.approx(LEVEL, rel=0.03)


@pytest.mark.slow
def test_dry_friction_of_one_motor_is_named_there(tmp_path: Path) -> None:
    """And nothing else, as in the tests below, where more acts on the wrist."""
    told(fd.diagnose(wrist(tmp_path), [moved()], progress=False))


def test_beside_a_spring_on_a_joint_that_both_motors_move(tmp_path: Path) -> None:
    """MuJoCo's spring on the pitch: its stiffness is off by two tolerances, and calibrated; the axes are kept."""
    spring = fd.effects.ParallelSpring("pitch", stiffness=20.0, rest=0.1)
    stiffer = 'name="pitch" type="hinge" stiffness="20.8" springref="5.729577951308232"'
    record = moved(('name="pitch" type="hinge"', stiffer), ('angle="radian"', 'angle="degree"'))
    found = fd.diagnose(wrist(tmp_path, spring), [record], progress=False)
    told(found)
    factors = {each.parameter: each.factor for each in found.calibration if each.of == "effects[2]"}
    assert factors["stiffness"] == pytest.approx(1.04, abs=0.005)
    found.save(tmp_path / "answer")
    corrected = fd.load_model(tmp_path / "answer" / "model.yaml")
    assert corrected.robot.axes == AXES
    (kept,) = [e for e in corrected.effects if isinstance(e, fd.effects.ParallelSpring)]
    assert kept.stiffness == pytest.approx(20.8, rel=0.005)


@pytest.mark.slow
def test_beside_motors_that_rub_on_each_other(tmp_path: Path) -> None:
    """MuJoCo's third tendon turns with ``left - 0.6 right`` and rubs; the level is off by two tolerances as well."""
    rubbing = fd.effects.JointCoupling("left", other="right", level=1.0, ratio=0.6)
    tendon = (
        '<fixed frictionloss="1.04"><joint joint="pitch" coef="0.4"/><joint joint="roll" coef="1.6"/></fixed></tendon>'
    )
    found = fd.diagnose(wrist(tmp_path, rubbing), [moved(("</tendon>", tendon))], progress=False)
    told(found)
    factors = {each.parameter: each.factor for each in found.calibration if each.of == "effects[2]"}
    assert factors["level"] == pytest.approx(1.04, abs=0.01)
