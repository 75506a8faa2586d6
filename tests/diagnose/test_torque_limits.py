"""Motors that give less than their recorded torque: the limit acts before the filters, and cuts the noise too."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.equations.covariance import whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.held_torque import centred
from flexdyn.diagnose.equations.match import match
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.equations.noise_coefficients import coefficients, passed_torque
from flexdyn.diagnose.equations.terms import applied_torque, torque_slope
from flexdyn.simulation.link_side import LinkSide
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE, Array, Levels
from tests.oracles.integrate import held

LIMIT = fd.effects.TorqueSpeedLimit("elbow", stall_torque=0.9, no_load_speed=1e6)
LEVELS = Levels(2e-5, 0.02)


def _limited(asked: Array, seed: int) -> Equations:
    """Equations with the limit, along a motion of the clipped torques; the asked ones are recorded, with noise."""
    given = np.column_stack([asked[:, 0], np.clip(asked[:, 1], -0.9, 0.9)])
    rows = iter(given.tolist())
    t = np.arange(len(asked)) / RATE
    states, _ = held(ARM.derivative, [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0], t, lambda _t, _x: next(rows))
    draw, channels = np.random.default_rng(seed), {}
    for j, joint in enumerate(JOINTS):
        for signal, column in (("q", j), ("theta", 2 + j)):
            channels[f"{signal}.{joint}"] = states[:, column] + LEVELS.position * draw.standard_normal(len(t))
        channels[f"tau.{joint}"] = asked[:, j] + LEVELS.torque * draw.standard_normal(len(t))
    model = two_link(ARM)
    data = measured(model, fd.Recording(t, channels))
    return Equations(model, (data,), Filters.of_rate(data.dt)).of(model.replace(effects=[LIMIT]))


def _slow() -> Array:
    """Asked torques (samples, 2); the elbow's are beyond its limit for more than half of the time."""
    t = np.arange(round(8.0 * RATE)) / RATE
    return np.stack([2.0 * np.sin(5.1 * t) + np.sin(13.0 * t), 2.0 * np.sin(2.3 * t)], axis=1)


def test_a_torque_that_jumps_is_limited_before_it_is_smoothed() -> None:
    """From -5 to 5 and back every tenth sample: the filter sees a torque between the limits, not a steep slope."""
    at = _limited(np.column_stack([np.zeros(1000), 5.0 * np.sign(np.sin(np.arange(1000) * np.pi / 10.0 + 0.1))]), 0)
    (along,) = at.motions
    found = applied_torque([LIMIT], at.true, along, 1)
    clipped = np.clip(along.data.tau[:, 1], -0.9, 0.9)
    expected = at.filters.first.apply(centred(clipped[:, None]), 0)[:, 0]
    np.testing.assert_allclose(found, expected, atol=1e-5)
    assert np.abs(found - np.clip(along.tau[:, 1], -0.9, 0.9)).max() > 0.3


def test_units_and_signs_are_checked_against_a_model_that_has_the_limit() -> None:
    """The check takes fewer samples than were recorded, and the torque that the limit leaves."""
    at = _limited(_slow(), 1)
    found = match(at.true, LinkSide(at.true), at.data[0])
    np.testing.assert_allclose(found.gain, 1.0, atol=0.05)


def test_the_noise_of_a_limited_torque_is_that_of_its_free_rows() -> None:
    """Where the limit cuts the torque, it cuts the noise; these rows say nothing of it."""
    at = _limited(_slow(), 1)
    slope = torque_slope(acting_on(at.true, 1), at.motions[0], 1)
    assert slope is not None
    assert np.mean(slope < 0.5) > 0.5
    assert passed_torque(at, at.motions[0], 0) == 1.0
    found = torque_noise(at, at.residual, np.zeros(len(at.residual), bool), LEVELS.noise())
    np.testing.assert_allclose(found, LEVELS.torque, rtol=0.15)


def test_a_limit_behind_a_gain_acts_on_the_torque_after_it() -> None:
    """With twice the recorded torque the limit is reached at half of it, and what is passed has the slope 2."""
    (along,) = _limited(_slow(), 0).motions
    slope = torque_slope([LIMIT, fd.effects.TorqueConstantError("elbow", gain=1.0)], along, 1)
    assert slope is not None
    size = np.abs(along.tau[:, 1])
    np.testing.assert_allclose(slope[size < 0.44], 2.0, rtol=1e-6)
    np.testing.assert_allclose(slope[size > 0.46], 0.0, atol=1e-3)


def test_rows_behind_a_limit_are_white_with_the_noise_that_it_passes() -> None:
    """The same variance whether the limit acts or not; without its slope, limited rows would have hardly any."""
    at = _limited(_slow(), 2)
    white = whitener(at, LEVELS.noise(), np.zeros(len(at.residual), bool))(at.residual).reshape(-1, len(at.kinds))
    row = at.kinds.index((1, "motor"))
    passed = np.asarray(passed_torque(at, at.motions[0], 1))
    free, cut = white[passed > 0.99, row], white[passed < 0.01, row]
    assert min(len(free), len(cut)) > 80
    assert float(np.mean(free**2)) == pytest.approx(1.2, abs=0.5)
    assert float(np.mean(cut**2) / np.mean(free**2)) == pytest.approx(1.0, abs=0.4)


def test_positions_made_up_from_a_limited_torque_keep_its_noise() -> None:
    """They are right to first order only: rows without noise would weigh their errors too much."""
    at = _limited(_slow(), 2)
    alone = dataclasses.replace(at.data[0], has_q=np.zeros(2, bool))
    one = Equations(at.model, (alone,), at.filters)
    assert one.computed.all()
    (along,) = one.motions
    assert np.ptp(np.asarray(passed_torque(one, along, 1))) > 0.9
    assert np.ndim(coefficients(one, along)["tau", 1][0][one.kinds.index((1, "total"))]) == 0
