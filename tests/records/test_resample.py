"""Other times: what is sampled is interpolated, what is held is held, gaps are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError
from flexdyn.records import Recording


def jittered(rate: float = 500.0, seconds: float = 4.0, share: float = 0.2, seed: int = 1) -> np.ndarray:
    """Times off a grid by up to a share of the period."""
    k = np.arange(int(rate * seconds))
    return np.asarray((k + np.random.default_rng(seed).uniform(-share, share, len(k))) / rate)


def motion(t: np.ndarray) -> dict[str, np.ndarray]:
    """A sine with its velocity and a torque that changes with every sample."""
    w = 2 * np.pi * 3.0
    return {"q.a": np.sin(w * t), "v.a": w * np.cos(w * t), "tau.a": np.arange(len(t)) * 1.0}


@pytest.mark.parametrize(("method", "error"), [("spline", 2e-8), ("hermite", 3e-8), ("linear", 4e-4)])
def test_jitter_is_removed(method: str, error: float) -> None:
    """A uniform grid, exactly t0 + k/rate, with the motion where it was (closed form)."""
    t = jittered()
    even = Recording(t, motion(t)).resample(rate=400.0, method=method)
    np.testing.assert_array_equal(even.t, t[0] + np.arange(len(even)) / 400.0)
    assert t[-1] - 1 / 400.0 < even.t[-1] <= t[-1]
    inner = slice(5, -5)
    np.testing.assert_allclose(even["q.a"][inner], motion(even.t)["q.a"][inner], atol=error)


def test_splines_are_smooth_to_the_second_derivative() -> None:
    """Fourth order: halving the period divides the error by sixteen."""
    errors = []
    for rate in (50.0, 100.0):
        t = np.arange(int(4 * rate) + 1) / rate
        fine = Recording(t, motion(t)).resample(rate=1600.0)
        inner = (fine.t > 1) & (fine.t < 3)
        errors.append(np.abs(fine["q.a"] - motion(fine.t)["q.a"])[inner].max())
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.15)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 1000), method=st.sampled_from(["spline", "hermite", "linear"]))
def test_old_times_keep_their_samples(seed: int, method: str) -> None:
    """Bit for bit, on the same times or on some of them."""
    t = jittered(seconds=0.2, seed=seed)
    rec = Recording(t, {**motion(t), "temperature.a": t, "flag": np.round(t)}, meta={"a": 1})
    assert rec.resample(times=t, method=method) == rec
    some = rec.resample(times=t[::3], method=method)
    assert all(np.array_equal(some[channel], rec[channel][::3]) for channel in rec.channels)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 1000))
def test_torque_is_held(seed: int) -> None:
    """At any new time stands the last value at or before it, found here one by one."""
    t = jittered(seconds=0.1, seed=seed)
    rec = Recording(t, motion(t))
    times = np.sort(np.random.default_rng(seed).uniform(t[0], t[-1], 40))
    times = times[[np.abs(t - time).min() > 4e-6 for time in times]]  # a thousandth of a period counts as the sample's
    expected = [rec["tau.a"][max(k for k in range(len(t)) if t[k] <= time)] for time in times]
    np.testing.assert_array_equal(rec.resample(times=times)["tau.a"], expected)


def test_a_rounded_clock_delays_no_torque() -> None:
    """Times written with eight digits land up to 5 ns late: their torque still belongs to the grid's time."""
    t = np.arange(1000) / 1024.0
    rec = Recording(np.round(t, 8) + 4e-9, motion(t))
    even = rec.resample(times=np.clip(t, rec.t[0], rec.t[-1]))
    np.testing.assert_array_equal(even["tau.a"], rec["tau.a"])


def test_rates_up_and_down_come_back() -> None:
    """1 kHz to 4 kHz and back is the same, bit for bit where the grid is dyadic."""
    t = np.arange(1025) / 1024.0
    rec = Recording(t, motion(t))
    assert rec.resample(rate=4096.0).resample(rate=1024.0) == rec
    assert len(rec.resample(rate=4096.0)) == 4097


def test_three_samples_are_enough() -> None:
    """The spline through them is the parabola."""
    few = Recording([0.0, 1.0, 2.0], {"q.a": [0.0, 1.0, 4.0], "tau.a": [1.0, 2.0, 3.0]}).resample(rate=4.0)
    np.testing.assert_allclose(few["q.a"], few.t**2, atol=1e-12)
    np.testing.assert_array_equal(few["tau.a"], [1, 1, 1, 1, 2, 2, 2, 2, 3])


def test_channels_of_other_kinds_never_leave_their_range() -> None:
    """Temperatures and flags are interpolated linearly: no overshoot at a step."""
    t = np.arange(20) / 10.0
    step = (t > 1).astype(float)
    fine = Recording(t, {"q.a": step, "temperature.a": step, "door": step}).resample(rate=100.0)
    assert fine["q.a"].max() > 1.0
    for channel in ("temperature.a", "door"):
        assert fine[channel].min() == 0.0
        assert fine[channel].max() == 1.0


def test_gaps_are_never_bridged_in_silence() -> None:
    """The row before the gap, its length, and the remedy; on request they are."""
    t = np.concatenate([np.arange(100), np.arange(150, 250)]) / 100.0
    rec = Recording(t, motion(t))
    with pytest.raises(InputError, match=r"row 99: a gap of 0\.51 s follows.*\.split\(gaps=") as caught:
        rec.resample(rate=50.0)
    assert caught.value.row == 99
    assert len(rec.resample(rate=50.0, longest_gap=0.6)) == 125
    assert all(len(piece.resample(rate=50.0)) == 50 for piece in rec.split(gaps=0.1))


def test_filtered_keeps_what_folds_down_away() -> None:
    """A vibration above half the new rate stands in the plain result at full size and is gone from the filtered one."""
    t = np.arange(8001) / 2000.0
    shake = 0.1 * np.sin(2 * np.pi * 303.0 * t)
    rec = Recording(t, {"q.a": np.sin(2 * t) + shake, "tau.a": np.cos(2 * t) + shake})
    plain, clean = rec.resample(rate=200.0), rec.resample(rate=200.0, filtered=True)
    assert np.std(plain["q.a"] - np.sin(2 * plain.t)) > 0.05
    assert np.abs(clean["q.a"] - np.sin(2 * clean.t)).max() < 1e-3
    assert set(np.round(clean.t * 200.0, 9)) < set(np.round(plain.t * 200.0, 9))


def test_filtered_torque_keeps_its_impulse() -> None:
    """The mean of what was held: the integral over whole new periods is that of the old steps."""
    t = np.arange(4001) / 1000.0
    tau = np.random.default_rng(2).normal(size=len(t))
    slow = Recording(t, {"q.a": t, "tau.a": tau}).resample(rate=50.0, filtered=True)
    first, last = (round(1000 * float(time)) for time in slow.t[[0, -1]])
    assert slow["tau.a"][:-1].sum() / 50.0 == pytest.approx(tau[first:last].sum() / 1000.0, abs=1e-12)


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({}, "give either rate"),
        ({"rate": 10.0, "times": [0.0, 1.0]}, "give either rate"),
        ({"rate": -1.0}, "rate: not a sample rate, got -1"),
        ({"rate": 1e-3}, "samples would come out"),
        ({"rate": 10.0, "method": "cubic"}, "known: spline, hermite, linear"),
        ({"times": [0.0, 5.0]}, "times: row 1: outside the recording"),
        ({"times": [0.1, np.nan]}, "row 1: outside"),
        ({"times": [0.1, 0.3, 0.2]}, "row 2: times must increase"),
        ({"times": [[0.1, 0.2]]}, "no column"),
        ({"rate": 10.0, "longest_gap": -1}, "longest_gap: not a length"),
        ({"rate": 100.0, "filtered": True}, "not low enough to need a filter"),
        ({"rate": 1.0, "filtered": True}, "too few for a filter"),
    ],
)
def test_wrong_requests_are_refused(given_: dict[str, object], message: str) -> None:
    """One line with the argument and the remedy."""
    t = np.arange(101) / 100.0
    with pytest.raises(InputError, match=message):
        Recording(t, motion(t)).resample(**given_)  # type: ignore[arg-type]
