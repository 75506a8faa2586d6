"""The user's arm: its URDF, what its drives are by the data sheet, and what it really does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

Array = NDArray[np.float64]
JOINTS = ("shoulder", "elbow")
GEAR_RATIO, ROTOR_INERTIA, TORQUE_CONSTANT = 80.0, 5e-5, 0.09
"""By the data sheet: [1], [kg m^2], [N m/A]."""
RATE, SECONDS = 200.0, 5.0
ENCODER, TORQUE = 2e-5, 0.02
"""Noise: standard deviations of positions [rad] and torques [N m]."""

URDF = """<?xml version="1.0"?>
<robot name="bench_arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.15 0 0"/><mass value="2.0"/>
      <inertia ixx="0.002" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0.12 0 0"/><mass value="1.2"/>
      <inertia ixx="0.001" iyy="0.008" izz="0.008" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" velocity="5" effort="60"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2.0" upper="2.0" velocity="6" effort="30"/>
  </joint>
</robot>
"""


def truth(folder: Path) -> fd.FlexibleJointModel:
    """The arm as it is: dry friction in the elbow, of which no data sheet tells.

    Args:
        folder: with arm.urdf.
    """
    drives = {"*": {"gear_ratio": GEAR_RATIO, "rotor_inertia": ROTOR_INERTIA}}
    friction = fd.effects.CoulombFriction("elbow", side="motor", level=0.6)
    return fd.FlexibleJointModel(fd.load_robot(folder / "arm.urdf"), joints=drives, effects=[friction])


def measured(arm: fd.FlexibleJointModel, day: int) -> tuple[Array, Array, Array]:
    """A motion as encoders and drives told it: times (samples,) [s], positions [rad] and torques [N m] (samples, 2)."""
    t = np.arange(round(RATE * SECONDS) + 1) / RATE
    shoulder = 0.5 * np.sin((1.1 + 0.2 * day) * t) + 0.15 * np.sin((4.1 - 0.3 * day) * t + day)
    elbow = 0.6 * np.sin((1.5 + 0.2 * day) * t + 1.0) + 0.15 * np.sin((5.0 + 0.3 * day) * t)
    wanted = np.column_stack([shoulder, elbow])
    start = np.gradient(wanted, t, axis=0, edge_order=2)[0]
    command = fd.PD(fd.Samples(t, wanted, "cubic"), kp=300.0, kd=20.0, rate=RATE)
    run = fd.simulate(arm, command, q0=wanted[0], v0=start, rate=RATE)
    rng = np.random.default_rng(day)
    noise = [rng.normal(0.0, sigma, run.q.shape) for sigma in (ENCODER, TORQUE)]
    return t, run.q + noise[0], run.tau + noise[1]
