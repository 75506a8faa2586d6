"""A drive's cascade: the PD law where it is one, differences over samples, what is cut, late and added."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from tests.arms import repickled

Array = NDArray[np.float64]

KP, KV = np.array([6.0, 8.0]), np.array([3.0, 2.0])
GOAL = np.array([0.4, -0.3])


@pytest.fixture(scope="module")
def arm() -> fd.FlexibleJointModel:
    """The paper's arm without friction."""
    return fd.load_model("scara_two_link").replace(effects=[])


def held(seconds: float = 0.3) -> fd.Samples:
    """A reference that does not move."""
    return fd.Samples([0.0, seconds], [GOAL, GOAL])


def at_ticks(run: fd.Run) -> tuple[Array, Array]:
    """Rotor positions and torques at the controller's ticks, which are the run's samples."""
    return run.theta[:-1], run.tau[:-1]


def test_with_true_velocities_it_is_the_pd_law(arm: fd.FlexibleJointModel) -> None:
    """The law kv (kp (r - y) - y') is PD control with the gains kp kv and kv about a reference at rest."""
    servo = fd.Servo(reference=held(), position_gain=KP, velocity_gain=KV, span=0)
    pd = fd.PD(held(), kp=KP * KV, kd=KV)
    ours, theirs = fd.simulate(arm, servo), fd.simulate(arm, pd)
    np.testing.assert_allclose(ours.theta, theirs.theta, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(ours.tau, theirs.tau, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("span", [1, 2, 5])
def test_velocity_is_a_difference_of_samples(arm: fd.FlexibleJointModel, span: int) -> None:
    """The torque at every tick follows from the run's own positions; before the run the joint moved as at its start."""
    v0 = np.array([0.3, -0.2])
    servo = fd.Servo(reference=held(), position_gain=KP, velocity_gain=KV, span=span)
    y, tau = at_ticks(fd.simulate(arm, servo, v0=v0))
    earlier = y[0] - v0 * np.arange(span, 0, -1)[:, None] * 1e-3
    speed = (y - np.vstack([earlier, y])[: len(y)]) / (span * 1e-3)
    np.testing.assert_allclose(tau, KV * (KP * (GOAL - y) - speed), rtol=1e-9, atol=1e-10)


def test_limit_delay_and_what_is_added(arm: fd.FlexibleJointModel) -> None:
    """Cut to the limit, late by two samples (nothing before that), then the test signal on top."""
    signal = fd.Samples(np.arange(301) / 1000.0, np.where(np.arange(301) % 50 < 25, 0.5, 0.0)[:, None] * [1.0, 0.0])
    servo = fd.Servo(
        reference=held(), position_gain=KP, velocity_gain=KV, span=0, limit=[2.0, 1.0], delay=2, added=signal
    )
    run = fd.simulate(arm, servo)
    tau = run.tau[:-1]
    asked = KV * (KP * (GOAL - run.theta[:-1]) - run.omega[:-1])
    expected = np.vstack([np.zeros((2, 2)), np.clip(asked[:-2], [-2.0, -1.0], [2.0, 1.0])]) + signal.values[:-1]
    np.testing.assert_allclose(tau, expected, rtol=1e-7, atol=1e-9)


def test_speed_feedforward_gives_the_references_velocity(arm: fd.FlexibleJointModel) -> None:
    """A ramp is followed without the lag v/kp that the position loop alone has."""
    t = np.linspace(0.0, 1.0, 1001)
    ramp = fd.Samples(t, t[:, None] * [0.2, 0.1] + [0.0, 0.5 * np.pi], "linear")
    lags = {}
    for share in (0.0, 1.0):
        servo = fd.Servo(reference=ramp, position_gain=8.0, velocity_gain=40.0, span=1, speed_feedforward=share)
        lags[share] = np.abs(fd.simulate(arm, servo).theta[-1] - ramp.values[-1])
    np.testing.assert_allclose(lags[0.0], [0.2 / 8.0, 0.1 / 8.0], rtol=0.2)
    assert (lags[1.0] < 0.1 * lags[0.0]).all()


def test_every_run_starts_anew(arm: fd.FlexibleJointModel) -> None:
    """The controller's memory belongs to the run: twice the same settings, twice the same run, also after pickling."""
    servo = fd.Servo(reference=held(), position_gain=KP, velocity_gain=KV, span=2, delay=1)
    one, two, three = (fd.simulate(arm, each) for each in (servo, servo, repickled(servo)))
    np.testing.assert_array_equal(one.tau, two.tau)
    np.testing.assert_array_equal(one.tau, three.tau)


def test_a_recordings_reference_is_tracked(arm: fd.FlexibleJointModel) -> None:
    """Its ``reference`` columns come before what was measured, and its first row is the first state."""
    t = np.linspace(0.0, 0.3, 301)
    names = arm.joint_names
    measured = {f"theta.{name}": np.full(301, 0.1) for name in names}
    wanted = {f"reference.{name}": np.full(301, x) for name, x in zip(names, GOAL, strict=True)}
    gains: dict[str, Any] = {"position_gain": KP, "velocity_gain": KV, "span": 1}
    run = fd.simulate(arm, fd.Servo(reference=fd.Recording(t, measured | wanted), **gains))
    other = fd.simulate(arm, fd.Servo(reference=held(), **gains), q0=[0.1, 0.1])
    np.testing.assert_allclose(run.theta[0], 0.1)
    np.testing.assert_allclose(run.tau, other.tau, atol=1e-12)
    alone = fd.simulate(arm, fd.Servo(reference=fd.Recording(t, measured), **gains))
    np.testing.assert_allclose(alone.theta, 0.1, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"feedback": "tau"}, "servo.feedback: no such feedback"),
        ({"span": -1}, "servo.span: a number of samples is needed"),
        ({"delay": 1.5}, "servo.delay: a number of samples is needed"),
        ({"rate": 0.0}, "servo.rate: a rate above 0 Hz is needed"),
        ({"added": 3.0}, "servo.added: Samples are needed"),
        ({"limit": 0.0}, "servo.limit: a limit above 0 is needed"),
        ({"velocity_gain": [1.0, 2.0, 3.0]}, "servo.velocity_gain: one number, or one for each of the 2 joints"),
        ({"position_gain": {"shoulder": 1.0}}, "servo.position_gain.elbow: a joint is missing"),
        ({"reference": 3.0}, "servo.reference: no reference to track"),
    ],
)
def test_settings_without_sense_are_refused(arm: fd.FlexibleJointModel, changes: dict[str, Any], words: str) -> None:
    """One line that names the setting."""
    settings: dict[str, Any] = {"reference": held(), "position_gain": 1.0, "velocity_gain": 1.0} | changes
    with pytest.raises(fd.InputError) as caught:
        fd.simulate(arm, fd.Servo(**settings))
    assert str(caught.value).startswith(words)
