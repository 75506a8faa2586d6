"""Friction of one motor of a differential is named at that motor, although both joints feel it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

import flexdyn as fd
from tests.physics.test_axes import TENDONS, WRIST

LEVEL, RATE, INSIDE, SECONDS = 0.5, 200, 40, 5.0
A = np.array([[1.0, 1.0], [1.0, -1.0]])
AXES = {"left": {"pitch": 1.0, "roll": 1.0}, "right": {"pitch": 1.0, "roll": -1.0}}


def moved() -> fd.Recording:
    """MuJoCo's wrist under PD control of its axes, dry friction on the left tendon; what its motors see, with noise."""
    text = TENDONS.replace('armature="0.3"', f'armature="0.3" frictionloss="{LEVEL}"')
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


def test_dry_friction_of_one_motor_is_named_there(tmp_path: Path) -> None:
    """And nothing else; the corrected model keeps the axes."""
    path = tmp_path / "wrist.urdf"
    path.write_text(WRIST, encoding="utf-8")
    drives = {"left": {"rotor_inertia": 0.3}, "right": {"rotor_inertia": 0.4}}
    viscous = [
        fd.effects.ViscousFriction(name, side="motor", coefficient=c) for name, c in (("left", 0.2), ("right", 0.1))
    ]
    arm = fd.load_robot(path).with_axes(AXES)
    found = fd.diagnose(fd.FlexibleJointModel(arm, drives, viscous, tolerance=0.02), [moved()], progress=False)
    (finding,) = found.findings
    assert (finding.suspect.effect, finding.suspect.joint) == ("coulomb_friction", "left")
    assert finding.suspect.parameters["level"].value == pytest.approx(LEVEL, rel=0.03)
    found.save(tmp_path / "answer")
    assert fd.load_model(tmp_path / "answer" / "model.yaml").robot.axes == AXES
