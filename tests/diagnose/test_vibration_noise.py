"""Encoder noise that makes simulated links vibrate, against their response in time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lsim

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.covariance import kernels_of
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.rest import touches_zero, uncertain_sign
from flexdyn.diagnose.equations.vibration_noise import VIBRATION_ROWS, vibration_noise
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import two_link
from tests.diagnose.test_hidden_links import RINGING
from tests.diagnose.truths import JOINTS

Array = NDArray[np.float64]
RATE = 1000.0
SIGMA = np.array([3e-6, 5e-6])


def _standing() -> Equations:
    """Motors that hardly move: the arm keeps its posture."""
    t = np.arange(round(3.0 * RATE)) / RATE
    channels = {f"theta.{joint}": place + 0.01 * t for joint, place in zip(JOINTS, (0.1, 0.9), strict=True)}
    channels |= {f"tau.{joint}": np.zeros(len(t)) for joint in JOINTS}
    model = two_link(RINGING)
    data = measured(model, fd.Recording(t, channels))
    return Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)


def _response(equations: Equations, j: int, taps: Array) -> Array:
    """Rows (samples, 2) after a single wrong sample of a motor's encoder, at every sample: by scipy's integration.

    ``M q'' = K (theta - q) + D (theta' - q')`` with the states q and ``w = q' - M^-1 D theta``.
    """
    K, D = np.diag(RINGING.stiffness), np.diag(RINGING.damping)
    M = equations.links.mass_matrix(np.array([[0.1, 0.9]]))[0]
    by_k, by_d = np.linalg.solve(M, K), np.linalg.solve(M, D)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-by_k, -by_d]])
    B = np.concatenate([by_d, by_k - by_d @ by_d])[:, [j]]
    count = 6000
    fine = np.arange(count) / RATE
    wrong = np.zeros(count)
    wrong[500] = 1.0
    _, q, _ = lsim((A, B, np.eye(2, 4), np.zeros((2, 1))), wrong, fine)
    moved = np.stack([np.convolve(q[:, i], taps[::-1], "same") for i in (0, 1)], axis=1)
    return np.asarray(moved @ M.T / equations.gains)


def test_the_covariance_of_the_rows_is_that_of_a_vibration_in_time() -> None:
    """White noise of both encoders, row by row, over lags up to 0.15 s."""
    equations = _standing()
    along, kernels = equations.motions[0], kernels_of(equations)["theta"]
    postures = vibration_noise(equations, along, SIGMA, kernels[0])
    every = equations.filters.every
    M = equations.links.mass_matrix(np.array([[0.1, 0.9]]))[0]
    middle = postures[len(postures) // 2].covariance
    expected = np.zeros_like(middle)
    for j in (0, 1):
        rows = SIGMA[j] * _response(equations, j, kernels[2])
        rigid = np.zeros_like(rows)
        start = 500 - len(kernels[2]) // 2
        rigid[start : start + len(kernels[2])] = SIGMA[j] * kernels[2][::-1, None] * M[:, j] / equations.gains
        for lag in range(len(middle)):
            ahead = slice(lag * every, None)
            for x, sign in ((rows, 1.0), (rigid, -1.0)):
                expected[lag] += sign * x[ahead].T @ x[: len(x) - lag * every]
    scale = np.abs(expected[0]).max()
    assert scale > 0.0
    np.testing.assert_allclose(middle, expected, atol=0.03 * scale)


def test_the_shares_of_neighbouring_postures_add_up_to_one() -> None:
    """So the variance of every row is that of its posture."""
    equations = _standing()
    along = equations.motions[0]
    total = np.zeros(equations.filters.count(len(along.t)))
    for each in vibration_noise(equations, along, SIGMA, kernels_of(equations)["theta"][0]):
        total[each.first : each.first + len(each.share)] += each.share**2
    np.testing.assert_allclose(total, 1.0)
    assert len(total) > 4 * VIBRATION_ROWS


def test_a_slope_by_stiffness_is_right_after_many_periods() -> None:
    """Against central differences over a tenth of the step: a thousandth of a stiffness is another phase."""
    t = np.arange(round(8.0 * RATE)) / RATE
    sway = np.stack([0.3 * np.sin(3.1 * t) + 0.01 * np.sign(np.sin(2.0 * t)), 0.9 + 0.3 * np.cos(4.3 * t)], axis=1)
    channels = {f"theta.{joint}": sway[:, j] for j, joint in enumerate(JOINTS)}
    channels |= {f"tau.{joint}": np.zeros(len(t)) for joint in JOINTS}
    model = two_link(RINGING, tolerance=0.05)
    data = measured(model, fd.Recording(t, channels))
    at = Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)
    (number,) = (each for each in file_numbers(model) if each.of == "shoulder" and each.parameter == "stiffness")
    found = number_columns.of_numbers(at, (number,))[:, 0]
    up, down = (at.of(model.replace(effects=[number.error(1.0 + step)])).residual for step in (1e-6, -1e-6))
    central = (up - down) / 2e-6
    assert np.linalg.norm(found - central) < 2e-3 * np.linalg.norm(central)


@pytest.mark.parametrize("rest", [0.0, 0.002])
def test_a_velocity_that_touches_zero_is_told_by_how_it_bends(rest: float) -> None:
    """It never changes its sign, and its mean over the filter is far from zero against the encoder's noise."""
    first = Filters.of_rate(1.0 / RATE).first
    t = np.arange(round(RATE)) / RATE
    since = np.maximum(np.abs(t - 0.5) - 0.5 * rest, 0.0)
    theta = 4.0 * np.sign(t - 0.5) * since**2  # the velocity is 8 |t - 0.5|
    u = first.apply(theta, 1)
    touching = touches_zero(u, first)
    assert u.min() > 1e-4
    assert not uncertain_sign(u, 1e-8, first).any()
    assert touching[len(u) // 2]
    assert touching.mean() < 0.02
