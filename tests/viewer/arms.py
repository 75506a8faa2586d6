"""Short runs for the viewer's tests, and arms of every kind."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

import flexdyn as fd

DRIVE = {"rotor_inertia": 1e-4, "gear_ratio": 50.0, "stiffness": 200.0, "damping": 0.5}
SHAPELESS = """<robot name="{name}"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.15 0 0.1"/><mass value="1"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<link name="finger"><inertial><origin xyz="0 0.05 0"/><mass value="0.2"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
<link name="other_finger"><inertial><origin xyz="0 -0.05 0"/><mass value="0.2"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
<joint name="{joint}" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0 0 0.3" rpy="0.3 0.2 0.1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="10"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0" rpy="0 0.4 0"/>
<axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" effort="100" velocity="10"/></joint>
<joint name="grip" type="prismatic"><parent link="lower"/><child link="finger"/><origin xyz="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="100" velocity="10"/></joint>
<joint name="other_grip" type="prismatic"><parent link="lower"/><child link="other_finger"/><origin xyz="0.3 0 0"/>
<axis xyz="0 -1 0"/><limit lower="-1" upper="1" effort="100" velocity="10"/><mimic joint="grip"/></joint></robot>"""


def shapeless(folder: Path, joint: str = "shoulder", name: str = "shapeless") -> fd.FlexibleJointModel:
    """An arm without shapes: two skewed revolute joints and a gripper, whose second finger mimics the first."""
    path = folder / "shapeless.urdf"
    path.write_text(SHAPELESS.format(joint=joint, name=name), encoding="utf-8")
    stiff = {**DRIVE, "stiffness": 2e4, "damping": 20.0}
    return fd.FlexibleJointModel(fd.load_robot(path), {"*": DRIVE, "grip": stiff})


def swinging(model: fd.FlexibleJointModel, duration: float = 0.3, turn: float = 0.4) -> fd.Run:
    """The arm let go at a bent position."""
    return fd.simulate(model, duration=duration, q0=np.linspace(turn, 0.1, model.n))


@functools.cache
def two_link_run() -> fd.Run:
    """Two seconds of the paper's arm, pushed at the shoulder."""
    t = np.linspace(0.0, 2.0, 41)
    push = np.column_stack([0.4 * np.sin(2.0 * math.pi * t), np.zeros_like(t)])
    return fd.simulate(fd.load_model("scara_two_link"), fd.Samples(t, push, "linear"), rate=500.0)


@functools.cache
def rigid_run() -> fd.Run:
    """The same torques on the same arm with stiff gears."""
    model = two_link_run().model
    rigid = {name: replace(joint, stiffness=math.inf, damping=0.0) for name, joint in model.joints.items()}
    return fd.simulate(model.replace(joints=rigid), two_link_run().to_recording(), rate=500.0)
