"""A diagnosis of a small arm with one hidden effect, made once for all tests that read it."""

from __future__ import annotations

import functools

import numpy as np

import flexdyn as fd
from flexdyn.diagnose import Diagnosis

LEVEL = 0.6
"""Coulomb friction that the model lacks [N m]."""


def dry_model() -> fd.FlexibleJointModel:
    """A planar arm with elastic joints and no friction."""
    drives = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
    return fd.load_model("scara_two_link").replace(joints=drives, effects=[], tolerance=0.03)


@functools.cache
def dry_recording() -> fd.Recording:
    """Eight seconds of the arm whose elbow has Coulomb friction, with noise."""
    model = dry_model()
    t = np.linspace(0.0, 8.0, 801)
    sway = np.stack([0.6 * np.cos(1.1 * t) + 0.2 * np.cos(5 * t), 0.5 * np.cos(1.4 * t)], axis=1)
    robot = model.replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=LEVEL)])
    run = fd.simulate(robot, fd.PD(fd.Samples(t, sway, "cubic"), kp=400, kd=20), q0=sway[0])
    noise, log = np.random.default_rng(0), run.to_recording()
    sigma = {"q": 2e-6, "theta": 2e-6, "tau": 0.02}
    names = [f"{signal}.{joint}" for signal in sigma for joint in model.joint_names]
    seen = {x: log[x] + noise.normal(0.0, sigma[x.split(".")[0]], run.t.size) for x in names}
    return fd.Recording(run.t, seen, name="sway")


@functools.cache
def dry_elbow() -> Diagnosis:
    """The diagnosis of it; the last fifth is test data."""
    return fd.diagnose(dry_model(), [dry_recording()])
