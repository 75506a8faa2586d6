"""Recordings in which too little moves or too little is asked get one clear line; a joint that only rests does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.sanity import check_recordings
from tests.diagnose.sanity_cases import LEVELS, Change, Channels, checked, geared_arm, same, scaled
from tests.diagnose.truths import ARM, two_link_recording
from tests.diagnose.workspaces import workspace
from tests.oracles.integrate import held


@pytest.fixture(name="model")
def _model() -> fd.FlexibleJointModel:
    return geared_arm()


def test_one_second_is_too_short(model: fd.FlexibleJointModel) -> None:
    """Three windows to fit do not fit in, whatever moves in it; less than a window tells nothing at all."""
    for keep, match in (
        (250, r"too little motion in the recording, got '\d(\.\d+)? s of motion'; at least 1\.5 s of motion"),
        (100, r"the recording is too short, got '0\.396 s'; at least 1\.5 s of motion to fit"),
    ):
        with pytest.raises(fd.errors.InputError, match=rf"log\.csv: t: {match}"):
            checked(model, same, keep=keep)


def test_a_long_rest_is_too_short(model: fd.FlexibleJointModel) -> None:
    """What counts is the time in which something moves."""

    def resting(channels: Channels) -> Channels:
        return {
            name: np.concatenate([x[:250], np.full(len(x) - 250, x[250])]) if not name.startswith("tau") else x
            for name, x in channels.items()
        }

    with pytest.raises(fd.errors.InputError, match=r"too little motion in the recording, got '1(\.\d)? s of motion'"):
        checked(model, resting)


def test_a_constant_torque(model: fd.FlexibleJointModel) -> None:
    """It can be compared with nothing."""
    change: Change = lambda channels: channels | {"tau.elbow": np.full(1000, 1.5)}  # noqa: E731
    with pytest.raises(fd.errors.InputError, match=r"tau\.elbow: the torque is constant, got '1\.5 throughout'"):
        checked(model, change)


def test_a_passive_joint_is_noted(model: fd.FlexibleJointModel) -> None:
    """An elbow without motor may swing: its torque is zero, and that is no mistake."""
    notes = checked(model, lambda channels: channels | {"tau.elbow": np.zeros(1000)})
    assert notes == ("No torque is ever asked of elbow: what scales its torque cannot be told.",)


def test_a_joint_that_rests(model: fd.FlexibleJointModel) -> None:
    """A position that flickers between counts is no motion."""
    flicker = np.where(np.random.default_rng(2).random(1000) < 0.5, 0.9, 0.9 + 1e-5)
    change: Change = lambda channels: channels | {"q.elbow": flicker, "theta.elbow": flicker}  # noqa: E731
    with pytest.raises(fd.errors.InputError, match=r"elbow: the joint does not move.*robot\.lock: \{elbow: \.\.\.\}"):
        checked(model, change)


def test_a_dead_encoder(model: fd.FlexibleJointModel) -> None:
    """A link encoder that reads zero while the motor's moves is no measurement."""
    with pytest.raises(fd.errors.InputError, match=r"q\.elbow: it rests while theta\.elbow moves.*leave out q\.elbow"):
        checked(model, scaled(0.0, "q.elbow"))


@pytest.mark.parametrize(("share", "fine"), [(1.0, True), (30.0, False)])
def test_a_joint_that_is_held_winds_while_its_rotor_rests(
    model: fd.FlexibleJointModel, share: float, fine: bool
) -> None:
    """In a second motion, by what its torque winds the spring by, or by far more, which no held joint does."""

    def wound(channels: Channels) -> Channels:
        tau, q = channels["tau.shoulder"], channels["q.shoulder"]
        bent = share * np.abs(tau).max() / ARM.stiffness[0] * np.sin(np.arange(len(tau)) / 200.0)
        return {**channels, "q.shoulder": q[0] + bent, "theta.shoulder": np.full(len(tau), q[0])}

    rec = two_link_recording(LEVELS, seed=3)
    again = fd.Recording(rec.t, wound({name: np.array(x) for name, x in rec.channels.items()}), name="held.csv")
    data = (measured(model, rec), measured(model, again))
    if fine:
        check_recordings(model, data)
        return
    with pytest.raises(fd.errors.InputError, match=r"^held\.csv: theta\.shoulder: it rests while q\.shoulder moves"):
        check_recordings(model, data)


def test_a_held_joint_whose_link_alone_is_seen_is_not_taken_for_a_mistake(model: fd.FlexibleJointModel) -> None:
    """Its link shakes on its spring while the rotor stands: what that needs of the motor is not what it is asked."""
    t = np.arange(4000) / 1000.0

    def control(now: float, x: Sequence[float]) -> Sequence[float]:
        return [np.sin(20.0 * now) + 0.3 * np.sin(54.0 * now), -3000.0 * (x[3] - 0.9) - 40.0 * x[7]]

    states, tau = held(ARM.derivative, [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0], t, control)
    noise, step = np.random.default_rng(0), np.sqrt(12.0) * 2e-6
    channels = {}
    for j, joint in enumerate(("shoulder", "elbow")):
        channels[f"q.{joint}"] = step * np.round(states[:, j] / step)
        channels[f"tau.{joint}"] = tau[:, j] + LEVELS.torque * noise.standard_normal(len(t))
    check_recordings(model, (measured(model, fd.Recording(t, channels)),))
    channels["tau.shoulder"] *= 1e3  # the other joint still speaks
    with pytest.raises(fd.errors.InputError, match=r"tau\.shoulder: .*mN m"):
        check_recordings(model, (measured(model, fd.Recording(t, channels)),))


@pytest.mark.parametrize("signals", [("q",), ("q", "theta")])
def test_a_measured_link_that_rests_hides_its_own_equations_alone(
    model: fd.FlexibleJointModel, signals: tuple[str, ...]
) -> None:
    """Friction may hold at the elbow's rotor what nobody sees; the shoulder's equation needs the links alone."""
    rec = two_link_recording(LEVELS, seed=3, signals=signals)
    rests = [f"{signal}.elbow" for signal in signals]
    channels = {name: np.full(len(x), 0.9) if name in rests else x for name, x in rec.channels.items()}
    data = (measured(model, fd.Recording(rec.t, channels, name="log.csv")),)
    hidden = workspace(model, data)[0].whiten.mask.reshape(-1, 2 * len(signals)).all(axis=0)
    shoulder, elbow = hidden.reshape(2, -1)
    assert not shoulder.any()
    assert elbow.all()


def test_joints_that_turn_back_all_the_time(model: fd.FlexibleJointModel) -> None:
    """Their velocities have no certain sign anywhere."""
    t = np.arange(6000) / 1000.0
    noise = np.random.default_rng(3)
    wave = np.sin(2.0 * np.pi * 60.0 * t)
    channels: dict[str, np.ndarray] = {}
    for joint in model.joint_names:
        channels |= {f"q.{joint}": 1e-3 * wave + 1e-6 * noise.standard_normal(len(t)), f"tau.{joint}": wave}
    data = (measured(model, fd.Recording(t, channels, name="log.csv")),)
    with pytest.raises(fd.errors.InputError, match=r"^log\.csv: t: joints rest.* let all joints move at once"):
        workspace(model, data)
