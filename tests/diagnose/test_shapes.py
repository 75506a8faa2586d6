"""A number that no fit moves: the exponent of a Stribeck curve is one of two, and the data choose."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.diagnose.inference.shapes import likeliest_shapes

EXCESS, VELOCITY = 1.0, 0.08


def _arm() -> fd.FlexibleJointModel:
    """An arm with dry friction and stiff springs."""
    joints = {"*": {"stiffness": 9000.0, "damping": 3.0, "rotor_inertia": 4e-5}}
    known = [fd.effects.CoulombFriction(joint, side="motor", level=0.6) for joint in ("shoulder", "elbow")]
    return fd.load_model("scara_two_link").replace(joints=joints, effects=known, tolerance=0.03)


def _compared(exponent: float) -> Posterior:
    """What is compared where the elbow has a Stribeck curve that the file lacks."""
    model, t = _arm(), np.linspace(0.0, 10.0, 1001)
    sway = np.stack([0.3 * np.cos(1.1 * t), 0.3 * np.cos(1.4 * t) + 0.05 * np.cos(4.0 * t)], axis=1)
    law = fd.effects.StribeckFriction("elbow", side="motor", excess=EXCESS, velocity=VELOCITY, exponent=exponent)
    robot = model.replace(effects=[*model.effects, law])
    log = fd.simulate(robot, fd.PD(fd.Samples(t, sway, "cubic"), kp=900, kd=40), q0=sway[0]).to_recording()
    noise, sigma = np.random.default_rng(1), {"q": 1e-6, "theta": 1e-7, "tau": 0.05}
    names = [f"{signal}.{joint}" for signal in sigma for joint in model.joint_names]
    seen = {x: log[x] + noise.normal(0.0, sigma[x.split(".")[0]], log.t.size) for x in names}
    return posterior(*prepared(model, (measured(model, fd.Recording(log.t, seen)),)))


def _curve(there: Hypothesis) -> fd.effects.StribeckFriction:
    """Its Stribeck curve."""
    (found,) = (each for each in there.effects if isinstance(each, fd.effects.StribeckFriction))
    return found


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_the_data_choose_the_exponent(exponent: float) -> None:
    """The curve is found with its exponent; and a fit with the other exponent comes back to it."""
    compared = _compared(exponent)
    found = _curve(compared.fitted.hypothesis)
    assert found.exponent == exponent
    assert found.excess == pytest.approx(EXCESS, rel=0.1)
    assert found.velocity == pytest.approx(VELOCITY, rel=0.1)

    here = compared.fitted.hypothesis
    wrong = found.replace(exponent=3.0 - exponent)
    other = dataclasses.replace(here, effects=tuple(wrong if each is found else each for each in here.effects))
    begun = dataclasses.replace(
        compared.fitted, hypothesis=other, equations=compared.fitted.space.equations.of(other.model())
    )
    assert _curve(likeliest_shapes(compared.space, compared.best, begun).hypothesis).exponent == exponent
