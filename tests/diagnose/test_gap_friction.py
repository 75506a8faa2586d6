"""The gap where friction holds joints, and where friction remembers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.diagnose.shooting.spread import spread
from flexdyn.diagnose.shooting.starts import window_starts
from flexdyn.diagnose.shooting.whiten import Filter
from flexdyn.diagnose.shooting.windows import Windows
from tests.diagnose.truths import Levels, slider_model, slider_recording, sliding
from tests.oracles.integrate import held

RATE, MASS, LEVEL = 1000.0, 2.5, 3.0
T = np.arange(6000) / RATE
STOP_AND_GO = 4.0 * np.sin(2.0 * np.pi * 0.7 * T) + 2.0 * np.sin(2.0 * np.pi * 1.9 * T) * (T % 2.0 < 1.3)
FORCE = 2.0 * np.sin(2 * np.pi * 0.9 * T) + np.sin(2 * np.pi * 2.3 * T + 1.0)


@pytest.mark.parametrize("levels", [Levels(1e-6, 0.02), Levels(1e-5, 0.001)], ids=["torque noise", "sensor noise"])
def test_a_true_model_that_sticks_has_a_gap_of_one(tmp_path: Path, levels: Levels) -> None:
    """Rests, reversals and break-aways; what is held is not shaken loose by the noise of a velocity."""
    x, v = sliding(STOP_AND_GO, 1.0 / RATE, MASS, LEVEL)
    assert 0.2 < (v == 0.0).mean() < 0.8
    model = slider_model(tmp_path, [fd.effects.CoulombFriction("lift", side="link", level=LEVEL)])
    gaps = []
    for seed in range(4):
        windows = Windows.of(model, [slider_recording(x, STOP_AND_GO, RATE, levels, seed)], levels.noise(1))
        shot = shoot(model, windows)
        gaps.append(shot.gap)
        resting = v[windows.places[:, 1]] == 0.0
        deep = resting & (np.abs(v[windows.places[:, 1] + 30]) == 0.0) & (windows.places[:, 1] > 0)
        assert deep.any()
        np.testing.assert_array_equal(shot.x0[deep, 1], 0.0)
    assert np.sqrt(np.mean(np.square(gaps))) == pytest.approx(1.0, abs=0.15)
    assert shoot(slider_model(tmp_path), windows).gap > 20.0


@pytest.mark.parametrize("stiffness", [1e6, 5e8])
def test_noise_of_a_motor_encoder_winds_no_stiff_spring(tmp_path: Path, stiffness: float) -> None:
    """Rotor and link move as one mass: an error of the rotor's position is one of the link's, and no deflection."""
    levels, rotor = Levels(position=2e-5, torque=0.02), 1.0
    x, _ = sliding(FORCE, 1.0 / RATE, MASS + rotor, 0.0)
    drive = {"lift": {"stiffness": stiffness, "damping": 0.0, "rotor_inertia": rotor}}
    model, units = slider_model(tmp_path).replace(joints=drive), {"units": {"theta.lift": "m", "tau.lift": "N"}}
    gaps = []
    for seed in range(3):
        seen = slider_recording(x, FORCE, RATE, levels, seed)
        log = fd.Recording(seen.t, {"theta.lift": seen["q.lift"], "tau.lift": seen["tau.lift"]}, meta=units)
        gaps.append(shoot(model, Windows.of(model, [log], levels.noise(1))).gap)
    assert np.sqrt(np.mean(np.square(gaps))) == pytest.approx(1.0, abs=0.15)


def test_the_gap_of_a_wrong_mass_is_what_linear_theory_says(tmp_path: Path) -> None:
    """A free mass under sensor noise: twice integrated torque beside its best line, in units of noise."""
    levels, error = Levels(position=5e-5, torque=1e-6), 0.02
    x, _ = sliding(FORCE, 1.0 / RATE, MASS * (1.0 + error), 0.0)
    model = slider_model(tmp_path)
    windows = Windows.of(model, [slider_recording(x, FORCE, RATE, levels, 0)], levels.noise(1))
    u = np.linspace(-1.0, 1.0, windows.rows)
    expected = 0.0
    for row in windows.places[:, 1]:
        moved, _ = sliding(FORCE[row : row + windows.rows], 1.0 / RATE, MASS, 0.0)
        off = moved - moved / (1.0 + error)
        expected += ((off - np.polyval(np.polyfit(u, off, 1), u)) ** 2).mean() / levels.position**2 / len(windows)
    assert expected > 3.0
    assert shoot(model, windows).gap ** 2 - 1.0 == pytest.approx(expected, rel=0.1)


def test_bristles_keep_their_bend_into_the_window(tmp_path: Path) -> None:
    """Z follows the measured path up to each window's start; set to zero there it would leave a gap."""
    effect = fd.effects.PreslidingFriction("lift", side="link", level=LEVEL, stiffness=600.0)
    force = STOP_AND_GO[:4000:4]

    def rates(x: Sequence[float], tau: Sequence[float]) -> Sequence[float]:
        _, v, z = x
        return [v, (tau[0] - 600.0 * z) / MASS, v - 600.0 * abs(v) * z / LEVEL]

    rows = iter(force[:, None].tolist())
    states, _ = held(rates, [0.0, 0.0, 0.0], np.arange(len(force)) / 250.0, lambda _t, _x: next(rows))
    levels, model = Levels(1e-6, 1e-3), slider_model(tmp_path, [effect])
    windows = Windows.of(model, [slider_recording(states[:, 0], force, 250.0, levels, 0)], levels.noise(1))
    z = window_starts(Shooter(model, windows)).x[:, 2]
    np.testing.assert_allclose(z, states[windows.places[:, 1], 2], atol=0.05 * effect.reach)
    assert np.abs(z).max() > 0.5 * effect.reach
    assert shoot(model, windows).gap == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(
    "effect",
    [
        fd.effects.WarmUpFriction("lift", side="motor", coefficient=4.0, time_constant=1.5),
        fd.effects.CommandDelay("lift", delay=0.0073),
        fd.effects.CoulombFriction("lift", side="link", level=1.0),
        fd.effects.QuadraticDrag("lift", side="link", coefficient=3.0),
    ],
    ids=lambda effect: effect.name,
)
def test_windows_are_pieces_of_one_long_run(tmp_path: Path, effect: fd.effects.Effect) -> None:
    """Without noise each window falls onto the run it was cut from: time since its start and late torques included."""
    model = slider_model(tmp_path, [effect])
    run = fd.simulate(model, fd.Samples(T[:3000], FORCE[:3000]), solver=fd.solvers.DormandPrince())
    recording = slider_recording(run.q[:, 0], run.tau[:, 0], RATE, Levels(0.0, 0.0), 0)
    windows = Windows.of(model, [recording], Levels(1e-6, 1e-4).noise(1))
    shot = shoot(model, windows)
    assert np.abs(shot.residual[1:]).max() < 3e-6


def test_noise_that_would_excuse_any_motion_is_told(tmp_path: Path) -> None:
    """A response that grows tenfold from block to block carries noise to any size: such windows are wild."""
    levels, model = Levels(5e-5, 1e-3), slider_model(tmp_path)
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    windows = Windows.of(model, [slider_recording(x, FORCE, RATE, levels, 0)], levels.noise(1))
    shooter = Shooter(model, windows)
    starts = window_starts(shooter)
    response = spread(shooter, shooter.run(starts.x), np.arange(len(starts.x)))
    grown = dataclasses.replace(response, flow=10.0 * response.flow)
    used = np.ones(windows.measured.shape, bool)
    told = [Filter.of(windows, each, starts.prior, used, np.arange(len(windows))).wild for each in (response, grown)]
    assert not told[0].any()
    assert told[1].all()


def test_first_states_bend_no_bristle_far_beyond_its_reach(tmp_path: Path) -> None:
    """However far a linear correction would go, a bristle slips at its reach."""
    effect = fd.effects.PreslidingFriction("lift", side="link", level=LEVEL, stiffness=600.0)
    levels, model = Levels(1e-6, 1e-3), slider_model(tmp_path, [effect])
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    windows = Windows.of(model, [slider_recording(x, FORCE, RATE, levels, 0)], levels.noise(1))
    far = np.full((len(windows), 3), 5.0)
    bounded = Shooter(model, windows).bounded(far)
    assert (bounded[:, 2] <= 2.0 * effect.reach).all()
    np.testing.assert_array_equal(bounded[:, :2], far[:, :2])


@pytest.mark.parametrize("timed", [False, True], ids=["one plant", "a plant a window"])
def test_some_windows_respond_as_among_all(tmp_path: Path, timed: bool) -> None:
    """Responses of a few windows are those that they have among all of them."""
    laws: list[fd.effects.Effect] = [fd.effects.CoulombFriction("lift", side="link", level=LEVEL)]
    if timed:
        laws.append(fd.effects.WarmUpFriction("lift", side="link", coefficient=4.0, time_constant=1.5))
    levels, model = Levels(1e-6, 0.02), slider_model(tmp_path, laws)
    x, _ = sliding(STOP_AND_GO, 1.0 / RATE, MASS, LEVEL)
    windows = Windows.of(model, [slider_recording(x, STOP_AND_GO, RATE, levels, 0)], levels.noise(1))
    shooter, some = Shooter(model, windows), np.array([1, 4, 7])
    starts = window_starts(shooter).x
    whole = shooter.run(starts)
    assert (whole.written == windows.rows).all()
    response, few = spread(shooter, whole, np.arange(len(windows))), spread(shooter, whole, some)
    emptied = dataclasses.replace(
        response, **{name: np.zeros_like(getattr(response, name)) for name in ("flow", "push", "seen")}
    )
    filled = emptied.replaced(some, few)
    for name in ("flow", "push", "seen"):
        np.testing.assert_allclose(getattr(filled, name)[some], getattr(response, name)[some], rtol=1e-9, atol=1e-12)

    used, prior = np.ones(windows.measured.shape, bool), window_starts(shooter).prior
    one, other = (Filter.of(windows, r, prior, used, w) for r, w in ((response, np.arange(len(windows))), (few, some)))
    mixed = dataclasses.replace(one, gain=0.0 * one.gain, whitener=0.0 * one.whitener).replaced(some, other)
    for name in ("gain", "first_gain", "whitener", "variance", "unfitted", "counted"):
        np.testing.assert_allclose(getattr(mixed, name)[some], getattr(one, name)[some], rtol=1e-6, atol=1e-12)
    assert not np.delete(mixed.gain, some, axis=0).any()


def test_a_response_that_explodes_moves_no_first_state_out_of_the_world(tmp_path: Path) -> None:
    """A cable that winds to and fro: the gap is large and finite, first states stay near what was measured."""
    levels = Levels(5e-5, 1e-3)
    x, v = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    cable = fd.effects.PositionTorque("lift", cos_1=0.0, sin_1=3e4, cos_2=0.0, sin_2=0.0)
    model = slider_model(tmp_path, [cable])
    shot = shoot(model, Windows.of(model, [slider_recording(x, FORCE, RATE, levels, 0)], levels.noise(1)))
    assert np.isfinite(shot.gap)
    assert shot.gap > 10.0
    assert np.abs(shot.x0[:, 1]).max() < 2.0 * np.abs(v).max()
