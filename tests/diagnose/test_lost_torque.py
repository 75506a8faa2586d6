"""Motors that give less torque than was recorded, and gains of encoders, where one of two positions is computed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.hypothesis import moved
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.proposal import extent_of
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, Levels, two_link_recording

RATE, SWING, PACE = 500.0, 0.2, 4.0


def swinging(asked: float) -> fd.Recording:
    """The shoulder's rotor on a sine, seen by its encoder, under a recorded torque that has nothing to do with it."""
    t = np.arange(2000) / RATE
    channels = {f"theta.{joint}": np.zeros(len(t)) for joint in JOINTS}
    channels |= {f"tau.{joint}": np.zeros(len(t)) for joint in JOINTS}
    channels["theta.shoulder"] = SWING * np.sin(PACE * t)
    channels["tau.shoulder"] = asked * np.sign(np.sin(7.0 * t))
    return fd.Recording(t, channels)


@pytest.mark.parametrize("asked", [100.0, 1000.0])
def test_limits_are_sought_about_the_torque_that_the_motion_needs(asked: float) -> None:
    """``(M_11 + J) a``, however much was asked for: a motor that is cut off gives no more."""
    model = two_link(ARM)
    data = measured(model, swinging(asked))
    equations = Equations(model, (data,), Filters.of_rate(data.dt))
    assert equations.computed.all()
    inertia = equations.links.mass_matrix(np.zeros((1, 2)))[0, 0, 0] + ARM.rotor[0]
    assert extent_of(equations, 0).given == pytest.approx(inertia * SWING * PACE**2, rel=0.02)


def test_slopes_by_the_files_numbers_are_those_of_the_torque_that_was_given() -> None:
    """A limit cuts half of the torque off, which then winds no spring: differences of the residual say so."""
    model = two_link(ARM).replace(tolerance=0.05)
    recording = two_link_recording(Levels(), 0, ["theta"])
    bare, start = prepared(model, (measured(model, recording),))
    limit = fd.effects.TorqueSpeedLimit("shoulder", stall_torque=1.0, no_load_speed=1e3)
    space = dataclasses.replace(weighed(bare), anew=None)
    made = linearised(dataclasses.replace(start, effects=(limit,)), space)
    names = [(number.of, number.parameter) for number in start.factors]
    for which in (("shoulder", "stiffness"), ("elbow", "stiffness")):
        k = names.index(which)
        step = np.zeros(made.regression.X.shape[1])
        step[k] = 1e-4
        there = space.equations.of(moved(made.hypothesis, step, made.scales).model())
        change = (space.whiten(there.residual) - space.whiten(made.equations.residual)) / step[k]
        assert np.linalg.norm(made.regression.X[:, k] - change) < 0.02 * np.linalg.norm(change)


@pytest.mark.parametrize("signals", [["q"], ["theta"]])
def test_a_gain_of_an_encoder_moves_the_first_states_of_windows(signals: list[str]) -> None:
    """A true model without the gain of the encoder, asked what the gain would do: it leaves noise."""
    levels, gain = Levels(), 0.01
    (signal,) = signals
    plain = two_link_recording(levels, 0, signals)
    channels = {name: np.asarray(plain[name]) for name in plain.channels}
    channels[f"{signal}.shoulder"] = (1.0 + gain) * channels[f"{signal}.shoulder"]
    model = two_link(ARM)
    wrong = fd.effects.SensorGain(f"{signal}.shoulder", gain=gain)
    shot = shoot(model, Windows.of(model, [fd.Recording(plain.t, channels)], levels.noise()))
    rows = shot.whitened().size
    before, after = ((x**2).sum() / rows for x in (shot.whitened(), shot.whitened(model.replace(effects=[wrong]))))
    assert before > 2.5
    assert after < 1.3
