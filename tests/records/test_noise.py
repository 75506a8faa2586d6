"""Noise found in the samples themselves, against known truth under smooth motion and under friction's kinks."""

from __future__ import annotations

import pickle
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from flexdyn.errors import InputError
from flexdyn.records import Recording
from flexdyn.records.signals.noise import Noise, estimate_noise
from flexdyn.records.signals.reading_noise import held_for, high_frequency_std, quantisation_step, reading_noise
from tests.records.motions import MOTIONS, Array

LEVELS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)


@lru_cache
def moved(name: str, rate: int) -> tuple[Array, Array]:
    """Ten seconds of one motion."""
    t = np.arange(10 * rate) / rate
    return t, MOTIONS[name](t)


@pytest.mark.parametrize("rate", [250, 1000, 4000])
def test_white_noise_on_every_motion(rate: int) -> None:
    """Within 10 % in the median, never below half or above twice, and called white where the motion is smooth."""
    ratios = []
    for name in MOTIONS:
        t, x = moved(name, rate)
        for std in LEVELS:
            noise = estimate_noise(t, x + std * np.random.default_rng(1).normal(size=len(t)), unit="rad")
            ratios.append(noise.std / std)
            assert noise.unit == "rad"
            assert noise.step is None
            assert not noise.exact
            assert noise.white or name == "stick_slip"
    assert np.median(ratios) == pytest.approx(1.0, abs=0.1)
    assert min(ratios) > 0.5
    assert max(ratios) < 2.0


@pytest.mark.parametrize("rate", [250, 1000, 4000])
def test_encoders_with_and_without_dither(rate: int) -> None:
    """17 and 20 bits: the step to six digits, and the true rms error of the readings, quantisation included."""
    ratios = []
    for name in MOTIONS:
        t, x = moved(name, rate)
        for bits in (17, 20):
            step = 2 * np.pi / 2**bits
            for dither in (0.0, 0.3, 1.0):
                shaken = x + dither * step * np.random.default_rng(2).normal(size=len(t))
                read = np.round(shaken / step) * step
                noise = estimate_noise(t, read)
                assert noise.step == pytest.approx(step, rel=1e-6)
                ratios.append(noise.std / float(np.sqrt(np.mean((read - x) ** 2))))
    assert np.median(ratios) == pytest.approx(1.0, abs=0.1)
    assert min(ratios) > 0.5
    assert max(ratios) < 2.0


def test_a_slow_encoder_errs_by_its_step() -> None:
    """Less than a step per sample: hardly any jump is seen, and still the error is step/sqrt(12)."""
    t = np.arange(8000) / 1000.0
    x = 1e-3 * np.sin(0.5 * t)
    read = np.round(x / 5e-5) * 5e-5
    noise = estimate_noise(t, read)
    assert noise.std == pytest.approx(float(np.sqrt(np.mean((read - x) ** 2))), rel=0.1)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    scale=st.floats(1e-6, 1e6),
    coefficients=st.lists(st.floats(-1, 1), min_size=4, max_size=4),
)
def test_scales_and_ignores_slow_polynomials(seed: int, scale: float, coefficients: list[float]) -> None:
    """Twice the signal has twice the noise; a cubic of a thousand times the noise added changes nothing."""
    t = np.arange(2000) / 500.0
    x = np.random.default_rng(seed).normal(size=len(t))
    noise = estimate_noise(t, x)
    assert noise.std == pytest.approx(1.0, rel=0.2)
    assert estimate_noise(t, scale * x).std == pytest.approx(scale * noise.std, rel=1e-6)
    cubic = 1e3 * np.polynomial.Polynomial(coefficients)(t / 4.0)
    assert estimate_noise(t, x + cubic).std == pytest.approx(noise.std, rel=1e-6)


def test_jittered_samples() -> None:
    """20 % of jitter: the motion is taken off at the true times."""
    t = (np.arange(5000) + np.random.default_rng(3).uniform(-0.2, 0.2, 5000)) / 500.0
    x = np.sin(2 * np.pi * t)
    for std in (1e-6, 1e-4):
        assert estimate_noise(t, x + std * np.random.default_rng(4).normal(size=5000)).std == pytest.approx(
            std, rel=0.1
        )


def test_a_derived_velocity_is_not_white() -> None:
    """Differences of encoder readings: sqrt(2)/dt times their noise, and -1/2 at lag one."""
    t, x = moved("sines", 1000)
    read = x + 1e-5 * np.random.default_rng(5).normal(size=len(t))
    noise = estimate_noise(t[1:], np.diff(read) * 1000.0)
    assert not noise.white
    assert noise.std == pytest.approx(np.sqrt(2) * 1e-2, rel=0.05)
    np.testing.assert_allclose(noise.autocorrelation[:4], [1, -0.5, 0, 0], atol=0.05)
    assert noise.autocovariance[0] == pytest.approx(noise.std**2)


@pytest.mark.parametrize("std", LEVELS[1:])
def test_the_noise_of_readings_is_what_the_diagnosis_uses(std: float) -> None:
    """White noise: both figures within 5 %. With memory: the total is nearer, the readings' in closed form.

    The sixth difference D of noise with the autocorrelation pole^k has the variance sum_jk D_j D_k pole^|j - k|/D.D.
    """
    t, x = moved("sines", 1000)
    white = std * np.random.default_rng(15).normal(size=len(t))
    noise = estimate_noise(t, x + white)
    assert noise.std == pytest.approx(std, rel=0.05)
    assert noise.reading_std == pytest.approx(std, rel=0.05)
    assert noise.reading_std == reading_noise(x + white)
    pole, D = 0.8, np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])
    slow = estimate_noise(t, x + lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white))
    share = np.sqrt(D @ toeplitz(pole ** np.arange(7.0)) @ D / (D @ D))
    assert slow.reading_std is not None
    assert slow.reading_std == pytest.approx(share * std, rel=0.1)
    assert abs(slow.std - std) < abs(slow.reading_std - std)


@pytest.mark.parametrize("speed", [0.05, 0.2, 0.4, 0.8])
def test_the_noise_of_whole_counts_is_that_of_rounding(speed: float) -> None:
    """At any speed in counts a sample; the median of the sixth differences, which are whole numbers, is far off."""
    t = np.arange(20000) / 1000.0
    x = speed * (1000.0 / 1.7 * np.sin(1.7 * t) + 300.0 * np.sin(0.9 * t))
    counts = np.round(x)
    assert reading_noise(counts) == pytest.approx(float(np.std(counts - x)), rel=0.1)
    if speed >= 0.4:
        assert high_frequency_std(counts) > 1.5 * float(np.std(counts - x))


@pytest.mark.parametrize(("pole", "tolerance"), [(-0.5, 0.05), (0.5, 0.05), (0.8, 0.1)])
def test_coloured_noise(pole: float, tolerance: float) -> None:
    """First-order filtered noise: total and autocorrelation pole^k, though the motion hides its lowest frequencies."""
    t, x = moved("sines", 1000)
    white = np.random.default_rng(6).normal(size=len(t))
    error = 1e-3 * lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white)
    noise = estimate_noise(t, x + error)
    assert not noise.white
    assert noise.std == pytest.approx(1e-3, rel=tolerance)
    np.testing.assert_allclose(noise.autocorrelation[:4], pole ** np.arange(4.0), atol=0.1)
    assert noise.seen_above is not None
    assert 0 < noise.seen_above < 100


def test_commands_are_exact() -> None:
    """A smooth command has noise of rounding only; steps and what a slower clock holds have none."""
    t, x = moved("sines", 1000)
    random = np.random.default_rng(7).normal(size=1000)
    assert estimate_noise(t, np.sin(2 * np.pi * (1 + t) * t)).std < 1e-13
    for command in (np.sign(x), np.repeat(random, 10), np.repeat(x[::10], 10), np.full(len(t), 3.3), np.floor(4 * x)):
        noise = estimate_noise(t, command, held=True)
        assert noise.exact
        assert noise.std == 0.0
    assert estimate_noise(t, np.repeat(random, 10), held=True).hold == 10


def test_a_slow_sensor_is_judged_at_its_own_rate() -> None:
    """Each value held for five samples: the noise of the values, not of their steps."""
    t, x = moved("sines", 1000)
    read = np.repeat(x[::5] + 1e-4 * np.random.default_rng(8).normal(size=2000), 5)
    noise = estimate_noise(t, read)
    assert noise.hold == 5
    assert noise.std == pytest.approx(1e-4, rel=0.1)


def test_spikes_and_shocks_are_left_out() -> None:
    """One outlier in a hundred samples, a hundred times the noise, leaves the estimate within a fifth."""
    t, x = moved("sines", 1000)
    read = x + 1e-5 * np.random.default_rng(9).normal(size=len(t))
    read[50::100] += 1e-3
    assert estimate_noise(t, read).std == pytest.approx(1e-5, rel=0.2)


def test_steps_are_found_in_what_files_hold() -> None:
    """Levels with an offset, with skipped neighbours, written with few digits; and none in continuous values."""
    rng = np.random.default_rng(10)
    step = 25 / 65535
    levels = np.asarray(rng.integers(-3000, 3000, 500) * step, float)
    assert quantisation_step(levels - 12.5) == pytest.approx(step, rel=1e-9)
    assert quantisation_step(np.round(levels, 6)) == pytest.approx(step, rel=1e-6)
    skipping = np.cumsum(rng.choice([2, 3, 5], 60)) * step
    assert quantisation_step(np.asarray(skipping, float)) == pytest.approx(step, rel=1e-9)
    assert quantisation_step(np.asarray(np.round(rng.normal(size=1000), 3), float)) == pytest.approx(1e-3, rel=1e-9)
    assert not [n for n in range(10, 200) if quantisation_step(rng.normal(size=n)) is not None]
    assert quantisation_step(np.array([1.0, 2.0] * 50)) is None


def test_holding_is_counted() -> None:
    """Only where every change falls on one slower clock."""
    x = np.random.default_rng(11).normal(size=40)
    assert held_for(np.repeat(x, 4)) == 4
    assert held_for(np.repeat(x, 4)[3:]) == 4
    assert held_for(x) == 1
    assert held_for(np.repeat(x, np.arange(40) % 3 + 1)) == 1


def test_a_recording_knows_its_channels() -> None:
    """Unit and holding come from the channel's name; errors name it."""
    t, x = moved("sines", 250)
    read = x + 1e-4 * np.random.default_rng(12).normal(size=len(t))
    rec = Recording(t, {"q.a": read, "tau.a": np.repeat(read[::5], 5)})
    assert rec.noise("q.a") == estimate_noise(t, read, unit="rad")
    assert rec.noise("tau.a").exact
    assert rec.noise("tau.a").unit == "N m"
    with pytest.raises(InputError, match=r"^q\.a: 50 samples are too few to estimate noise; give 64 or more"):
        rec.trim(end=t[49]).noise("q.a")


def test_few_samples_still_give_a_number() -> None:
    """Below a dozen clean segments the spectrum is left open and the contrasts alone decide."""
    x = np.random.default_rng(13).normal(size=80)
    noise = estimate_noise(np.arange(80.0), x)
    assert noise.flatness is None
    assert 0.5 < noise.std < 2.0


def test_wrong_columns_are_refused() -> None:
    """Lengths, NaN and time, with the row."""
    t = np.arange(100.0)
    bad = t.copy()
    bad[5] = np.nan
    for args, message in (
        ((t, t[1:]), "no two columns"),
        ((t, bad), "x: row 5: not a finite number"),
        ((bad, t), "t: row 5"),
        ((-t, t), "row 1: time runs backwards"),
    ):
        with pytest.raises(InputError, match=message):
            estimate_noise(*args)
    with pytest.raises(InputError, match="10 values, each held for 10 samples, are too few"):
        estimate_noise(t, np.repeat(np.random.default_rng(14).normal(size=10), 10))


def test_noise_is_a_value() -> None:
    """Frozen, comparable, and it pickles."""
    noise = Noise(1.0, "rad", autocorrelation=(1.0, 0.5))
    assert pickle.loads(pickle.dumps(noise)) == noise  # noqa: S301 - our own bytes
    with pytest.raises(AttributeError):
        noise.std = 2.0  # type: ignore[misc]
