"""Unknown offsets of encoders, which every fit has: what they do to the rows depends on the springs they wind."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.catalogue import everything
from flexdyn.diagnose.inference.linearisation import Linearisation
from flexdyn.diagnose.inference.weights import for_fit

STEP = 1e-7


@pytest.fixture(scope="module")
def hard() -> tuple[fd.FlexibleJointModel, fd.effects.HardeningSpring, fd.Recording]:
    """A model, and an elbow whose spring is twice as hard at the largest deflection."""
    joints = {"shoulder": {"stiffness": 12000.0, "damping": 2.0}, "elbow": {"stiffness": 4000.0, "damping": 1.0}}
    joints = {name: {**numbers, "rotor_inertia": 4e-5} for name, numbers in joints.items()}
    model, t = fd.load_model("scara_two_link").replace(joints=joints, effects=[], tolerance=0.1), np.arange(1500) / 500
    sway = 1.0 - np.cos(np.outer(t, [3.0, 9.0, 4.0]))
    turns = np.stack([0.3 * sway[:, 0] + 0.1 * sway[:, 1], 1.5 + 0.4 * sway[:, 2]], axis=1)
    run = fd.simulate(model, fd.PD(fd.Samples(t, turns, "cubic"), kp=2000, kd=100), q0=turns[0])
    easy = run.to_recording()
    wound = float(np.abs(easy["theta.elbow"] - easy["q.elbow"]).max())
    spring = fd.effects.HardeningSpring("elbow", cubic=4000.0 / wound**2)
    true = model.replace(effects=[spring])
    run = fd.simulate(true, fd.PD(fd.Samples(t, turns, "cubic"), kp=2000, kd=100), q0=turns[0])
    names = [f"{signal}.{joint}" for signal in ("q", "theta", "tau") for joint in model.joint_names]
    rng, log = np.random.default_rng(1), run.to_recording()
    noise = {"q": 1e-6, "theta": 1e-6, "tau": 0.02}
    seen = {name: log[name] + rng.normal(0.0, noise[name.split(".")[0]], run.t.size) for name in names}
    return model, spring, fd.Recording(run.t, seen)


def test_a_fit_has_the_slopes_of_its_own_springs(
    hard: tuple[fd.FlexibleJointModel, fd.effects.HardeningSpring, fd.Recording],
) -> None:
    """By differences of the whole model, for each encoder, in a fit and in the linear equations near it."""
    model, spring, log = hard
    bare, start = prepared(model, (measured(model, log),))
    there = dataclasses.replace(start, effects=(spring,))
    at = bare.equations.of(there.model())
    bare = dataclasses.replace(bare, mask=np.zeros(at.residual.size, bool))
    work = for_fit(bare, there)
    near = Linearisation.of(bare, there, everything(bare.equations), None)
    for k, channel in enumerate(bare.channels):
        sides = [
            at.of(at.model.replace(effects=[*at.model.effects, fd.effects.SensorOffset(channel, offset=way)])).residual
            for way in (STEP, -STEP)
        ]
        slope = (sides[0] - sides[1]) / (2.0 * STEP)
        assert _apart(work.nuisance[:, k], work.whiten(slope)) < 0.03
        assert _apart(near.near.unknown[:, k], slope) < 0.03


def _apart(one: Array, other: Array) -> float:
    """Distance over length."""
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))
