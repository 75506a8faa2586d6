"""Encoders whose readings change regularly, on a stiff spring: their errors stay, and are large torques."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

import flexdyn as fd
from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import weighed
from tests.arms import slider

RATE, LOAD, ROTOR, STIFFNESS = 500.0, 2.5, 0.5, 2e6
STEP, ROTOR_STEP = 1e-6, 0.83e-6  # of the encoders [m]: on this spring a step of the link is 2 N
TORQUE_NOISE = 0.05


def _recording() -> fd.Recording:
    """A load behind a spring at speeds of nearly whole numbers of steps per sample, in closed form, as it is read."""
    t = np.arange(10000) / RATE
    x, a, a2 = (np.zeros(len(t)) for _ in range(3))
    ahead = np.zeros(len(t))  # acceleration half a sample later, for a torque that is held
    for begin, change in ((1.0, 40.0007), (5.0, -70.0), (9.0, 91.0), (13.0, -123.0), (17.0, 83.0)):
        v, width = change * STEP * RATE, 0.05
        u = (t - begin) / width
        s, later = (1.0 / (1.0 + np.exp(-np.clip(each, -700.0, 700.0))) for each in (u, u + 0.5 / RATE / width))
        x += v * width * np.logaddexp(0.0, u)
        a += v / width * s * (1.0 - s)
        a2 += v / width**3 * s * (1.0 - s) * (1.0 - 6.0 * s + 6.0 * s**2)
        ahead += v / width * later * (1.0 - later)
    force = (LOAD + ROTOR) * ahead + ROTOR * LOAD / STIFFNESS * a2
    force += TORQUE_NOISE * np.random.default_rng(3).standard_normal(len(t))
    seen = {"q.lift": _read(x, STEP), "theta.lift": _read(x + LOAD / STIFFNESS * a, ROTOR_STEP), "tau.lift": force}
    return fd.Recording(t, seen, meta={"units": {"q.lift": "m", "theta.lift": "m", "tau.lift": "N"}})


def _read(x: Array, step: float) -> Array:
    return np.asarray(step * np.round(x / step))


def test_what_a_right_model_leaves_is_noise(tmp_path: Path) -> None:
    """Taken for white noise, errors that stay would be a model error many times as large as noise."""
    drive = {"lift": {"rotor_inertia": ROTOR, "stiffness": STIFFNESS}}
    model = fd.FlexibleJointModel(slider(tmp_path), drive, gravity=[0.0] * 3)
    bare, _ = prepared(model, (measured(model, _recording()),))
    white = weighed(bare).white(bare.equations.residual).reshape(-1, 2)
    count = (~bare.mask).reshape(-1, 2).sum(axis=0)
    assert (count > 300).all()
    assert ((white**2).sum(axis=0) < 1.3 * count).all()

    data = tuple(dataclasses.replace(each, q_stays=0.0, theta_stays=0.0) for each in bare.equations.data)
    as_white = dataclasses.replace(bare, equations=bare.equations.along(data))
    white = weighed(as_white).white(as_white.equations.residual).reshape(-1, 2)
    assert ((white**2).sum(axis=0) > 3.0 * count).any()
