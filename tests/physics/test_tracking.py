"""Joint tracking at a control rate, its law written a second time over the closed-form arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import flexdyn as fd
from tests.arms import EXACT, state, two_link
from tests.oracles.integrate import held
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
ARM = TwoLink(stiffness=(300.0, 200.0), damping=(0.5, 0.3))
START = [0.0, math.pi / 2] * 2 + [0.0] * 4
KP, KD = (30.0, 20.0), (6.0, 4.0)


def reference(span: float) -> fd.Samples:
    """A smooth motion of both joints that ends before the run does."""
    t = np.linspace(0.0, span, 21)
    s = t / span
    blend = s**3 * (10 - 15 * s + 6 * s**2)
    return fd.Samples(t, np.column_stack([0.8 * blend, math.pi / 2 - 0.6 * blend]), "cubic")


@pytest.mark.parametrize(("feedback", "duration"), [("theta", 5.0), ("q", 1.0)])
def test_tracking_at_1_khz(feedback: Literal["theta", "q"], duration: float) -> None:
    """PD with feedforward, re-implemented: 1e-8 rad over 5 s; after the reference's end the arm is held there."""
    path = reference(0.8 * duration)
    ahead = fd.Samples([0.0, 0.5 * duration], [[0.3, -0.1], [0.1, 0.2]], "linear")
    pd = fd.PD(path, kp=KP, kd=KD, feedback=feedback, feedforward=ahead)
    run = fd.simulate(two_link(ARM), pd, duration, EXACT, q0=START[0:2])
    spline, end = CubicSpline(path.t, path.values), float(path.t[-1])
    speed = spline.derivative()

    def law(t: float, x: Sequence[float]) -> list[float]:
        y, rate = (x[2:4], x[6:8]) if feedback == "theta" else (x[0:2], x[4:6])
        inside = min(t, end)
        wanted, fast = spline(inside), speed(inside) * (t <= end)
        more = [float(np.interp(t, ahead.t, ahead.values[:, j])) * (t < ahead.t[-1]) for j in (0, 1)]
        return [more[j] + KP[j] * (wanted[j] - y[j]) + KD[j] * (fast[j] - rate[j]) for j in (0, 1)]

    expected, tau = held(ARM.derivative, START, run.t, law)
    assert np.abs(state(run) - expected).max() < 1e-8
    np.testing.assert_allclose(run.tau, tau, atol=1e-5)


def test_a_held_reference_ends_on_its_last_sample() -> None:
    """Where the reference is held from sample to sample, the arm comes to rest on the last one."""
    steps = fd.Samples([0.0, 0.5, 1.0], [[0.0, 0.0], [0.2, -0.2], [0.4, -0.4]])
    model = two_link(TwoLink(stiffness=(2000.0, 2000.0), damping=(5.0, 5.0)))
    run = fd.simulate(model, fd.PD(steps, kp=60.0, kd=20.0), 15.0, rate=10)
    np.testing.assert_allclose(run.q[-1], [0.4, -0.4], atol=1e-4)


def test_a_controller_in_python_is_the_same_law() -> None:
    """The same PD written as a Python callable gives the same trajectory, and sees the whole state."""
    path = reference(0.5)
    spline = CubicSpline(path.t, path.values)

    def law(t: float, x: fd.State) -> Array:
        inside = min(t, 0.5)
        fast = spline(inside, 1) * (t <= 0.5)
        return np.asarray(np.array(KP) * (spline(inside) - x.theta) + np.array(KD) * (fast - x.omega))

    model = two_link(ARM)
    native = fd.simulate(model, fd.PD(path, KP, KD, rate=500), 1.0, EXACT, q0=START[0:2])
    python = fd.simulate(model, fd.Controller(law, rate=500), 1.0, EXACT, q0=START[0:2])
    assert np.abs(state(native) - state(python)).max() < 1e-11


def test_gains_and_reference_by_joint() -> None:
    """Gains may be one number, one a joint, or a mapping that leaves no joint out."""
    path = reference(0.2)
    named = fd.Samples(path.t, {"elbow": path.values[:, 1], "shoulder": path.values[:, 0]}, "cubic")
    model = two_link(ARM)
    runs = [
        fd.simulate(model, fd.PD(each, kp, kd), 0.3)
        for each, kp, kd in (
            (path, [30.0, 20.0], 6.0),
            (named, {"elbow": 20.0, "shoulder": 30.0}, [6.0, 6.0]),
        )
    ]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)
    for joint, gains in (("shouldr", {"shouldr": 1.0}), ("elbow", {"shoulder": 1.0})):
        with pytest.raises(fd.InputError, match=rf"pd\.kp\.{joint}"):
            fd.simulate(model, fd.PD(path, gains, 1.0), 0.1)


def test_the_torque_is_held_between_ticks() -> None:
    """At 50 Hz the torque is a staircase of 20 ms, right-continuous at every tick."""
    path = reference(0.3)
    run = fd.simulate(two_link(ARM), fd.PD(path, KP, KD, rate=50), 0.3, rate=1000, q0=START[0:2])
    steps = run.tau[:-1].reshape(15, 20, 2)
    assert (steps == steps[:, :1]).all()
    assert (np.diff(steps[:, 0], axis=0) != 0).all()
