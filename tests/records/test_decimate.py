"""Decimation: what folds down is gone, noise stays white, nothing moves in time, held torques keep their impulse."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.errors import InputError

RATE = 5000.0
T = np.arange(20_000) / RATE


@pytest.mark.parametrize("factor", [2, 5, 8])
def test_what_would_fold_down_is_taken(factor: int) -> None:
    """A tone at 0.3 of the new rate passes, in time; one at 0.7, which would be seen at 0.3, does not."""
    low, high = (np.sin(2.0 * np.pi * share * RATE / factor * T) for share in (0.3, 0.7))
    rec = fd.Recording(T, {"q.a": 100.0 + low, "q.b": high}).decimate(factor)
    assert rec.rate == pytest.approx(RATE / factor)
    np.testing.assert_allclose(rec["q.a"] - 100.0, np.sin(2.0 * np.pi * 0.3 * RATE / factor * rec.t), atol=1e-3)
    assert np.abs(rec["q.b"]).max() < 2e-3
    assert np.abs(high[::factor]).max() > 0.9


def test_noise_stays_white_and_shrinks_as_that_of_a_mean() -> None:
    """By the root of the factor, and the estimate from the samples sees it."""
    noise = np.random.default_rng(0).normal(0.0, 1e-4, T.size)
    rec = fd.Recording(T, {"q.a": np.sin(3.0 * T) + noise}).decimate(5)
    left = float((rec["q.a"] - np.sin(3.0 * rec.t)).std())
    assert left == pytest.approx(1e-4 / np.sqrt(5.0), rel=0.05)
    assert rec.noise("q.a").std == pytest.approx(left, rel=0.05)


def test_held_torques_keep_their_impulse() -> None:
    """Each new sample is the mean of those that it stands for."""
    tau = np.random.default_rng(1).normal(size=T.size)
    rec = fd.Recording(T, {"tau.a": tau, "q.a": T}).decimate(4)
    first = round(rec.t[0] * RATE)
    np.testing.assert_allclose(rec["tau.a"], tau[first : first + 4 * len(rec)].reshape(-1, 4).mean(axis=1), rtol=1e-12)


@pytest.mark.parametrize("signal", ["voltage", "duty", "goal"])
def test_what_a_motor_is_asked_for_is_held_too(signal: str) -> None:
    """Volts, duties and goals as torques: the mean of the samples that become one."""
    asked = np.random.default_rng(2).normal(size=T.size)
    rec = fd.Recording(T, {f"{signal}.a": asked, "q.a": T}).decimate(5)
    first = round(rec.t[0] * RATE)
    wanted = asked[first : first + 5 * len(rec)].reshape(-1, 5).mean(axis=1)
    np.testing.assert_allclose(rec[f"{signal}.a"], wanted, rtol=1e-12)


def test_by_one_nothing_changes() -> None:
    """Bit for bit."""
    rec = fd.Recording(T, {"q.a": T})
    assert rec.decimate(1) is rec


def test_mistakes() -> None:
    """No whole factor, gaps, a clock that is not uniform, too few samples."""
    gap = np.concatenate([T[:500], T[900:]])
    jitter = T + 0.1 / RATE * np.sin(np.arange(T.size))
    for t, factor, match in (
        (T, 0, "factor: a whole number"),
        (T, 2.5, "factor: a whole number"),
        (gap, 2, "t: there are gaps"),
        (jitter, 2, r"t: row 19692: the samples are not uniform.*; resample first: \.resample\(rate=5000\)"),
        (T[:300], 10, "factor: 300 samples are too few"),
    ):
        with pytest.raises(InputError, match=match):
            fd.Recording(t, {"q.a": t}).decimate(factor)  # type: ignore[arg-type]
