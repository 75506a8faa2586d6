"""A recording through one filter: widths chosen from the data, noise left in every term told."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records import Recording
from flexdyn.records.signals.derivatives import derivatives
from flexdyn.records.signals.noise import estimate_noise
from flexdyn.records.signals.smooth import Smoother
from flexdyn.records.signals.width import best_smoother
from tests.records.motions import acceleration, sines

RATE = 1000.0
T = np.arange(8000) / RATE


def noisy(std: float, seed: int = 1) -> Recording:
    """Two joints' positions and a torque."""
    rng = np.random.default_rng(seed)
    x = sines(T)
    channels = {"q.a": x + std * rng.normal(size=len(T)), "theta.a": x + 3 * std * rng.normal(size=len(T))}
    return Recording(T, {**channels, "tau.a": acceleration(T)})


@pytest.mark.parametrize("std", [1e-6, 1e-5, 1e-4, 1e-3])
def test_the_chosen_width_is_nearly_the_best(std: float) -> None:
    """Its true error is within 30 % of the smallest that any width reaches, which only the truth can tell."""
    rec = noisy(std)
    chosen = best_smoother(rec["q.a"], RATE, estimate_noise(rec.t, rec["q.a"]))

    def error(width: int) -> float:
        smoother = Smoother(width, RATE)
        return float(np.sqrt(np.mean((smoother.second(rec["q.a"]) - acceleration(T[smoother.valid])) ** 2)))

    least = min(error(2 * round(5 * 1.2**k / 2) + 1) for k in range(28))
    assert error(chosen.width) < 1.3 * least


def test_more_noise_asks_for_more_width() -> None:
    """And positions need less of it than accelerations."""
    widths = [derivatives(noisy(std)).smoother.width for std in (1e-7, 1e-5, 1e-3)]
    assert widths == sorted(widths)
    assert widths[0] < widths[-1] / 4
    rec = noisy(1e-4)
    noise = estimate_noise(rec.t, rec["q.a"])
    orders = [best_smoother(rec["q.a"], RATE, noise, order=order).width for order in ("value", "first", "second")]
    assert orders[0] < orders[2]


def test_the_noise_left_is_told() -> None:
    """The standard deviation of each output, from the samples alone, is what the known truth gives."""
    view = derivatives(noisy(1e-4), cutoff=25.0)
    for channel, std in (("q.a", 1e-4), ("theta.a", 3e-4)):
        clean = view.smoother.second(sines(T))
        error = float(np.std(view.second(channel) - clean))
        assert view.std(channel, "second") == pytest.approx(error, rel=0.15)
        assert view.noise[channel].std == pytest.approx(std, rel=0.05)
    assert view.smoother.cutoff == pytest.approx(25.0, rel=0.05)


def test_every_term_of_an_equation_is_filtered_alike() -> None:
    """A unit mass driven by a torque held between samples: second(q) - value(tau) and first(v) - value(tau) vanish."""
    u = np.random.default_rng(2).normal(size=3000)
    v = np.concatenate([[0.0], np.cumsum(u)])[:-1] / RATE
    q = np.concatenate([[0.0], np.cumsum(v / RATE + u / 2 / RATE**2)])[:-1]
    rec = Recording(T[:3000], {"q.a": q, "v.a": v, "tau.a": u})
    view = derivatives(rec, smoother=Smoother(41, RATE))
    size = float(np.std(view.value("tau.a")))
    assert np.abs(view.second("q.a") - view.value("tau.a")).max() < 1e-6 * size
    assert np.std(view.first("v.a") - view.value("tau.a")) < 5e-3 * size
    np.testing.assert_allclose(view.first("q.a"), view.value("v.a"), atol=2e-3 * float(np.std(v)))
    assert len(view.t) == len(view.value("q.a"))


def test_a_view_is_locked_and_pickles() -> None:
    """It can go to a worker and come back the same; nobody adds to its noise."""
    view = derivatives(noisy(1e-4), cutoff=25.0)
    again = pickle.loads(pickle.dumps(view))  # noqa: S301 - our own bytes
    assert again.noise == view.noise
    np.testing.assert_array_equal(again.second("q.a"), view.second("q.a"))
    with pytest.raises(TypeError):
        view.noise["q.b"] = view.noise["q.a"]  # type: ignore[index]


def test_a_recording_is_smoothed() -> None:
    """Every channel, at the times at which the filter fits; torques as what is held."""
    rec = noisy(1e-5)
    smoother = Smoother(21, RATE)
    small = rec.smoothed(smoother)
    np.testing.assert_array_equal(small.t, rec.t[smoother.valid])
    np.testing.assert_array_equal(small["q.a"], smoother.value(rec["q.a"]))
    np.testing.assert_array_equal(small["tau.a"], smoother.held(rec["tau.a"]))


def test_a_clock_that_rounds_is_uniform_and_one_that_stutters_is_not() -> None:
    """The row of the stutter and the remedy, which works."""
    rec = noisy(1e-5)
    rounded = Recording(np.round(T + 3e-7, 6), rec.channels)
    assert derivatives(rounded, cutoff=20.0).smoother.rate == pytest.approx(RATE, rel=1e-6)
    t = T.copy()
    t[4000:] += 0.4e-3
    with pytest.raises(InputError, match=r"t: row 4000: the samples are not uniform.*resample\(rate=1000\)"):
        derivatives(Recording(t, rec.channels))
    assert len(derivatives(Recording(t, rec.channels).resample(rate=1000.0), cutoff=20.0).t) > 7000


def test_wrong_requests_are_refused() -> None:
    """Two widths, another rate, nothing that moves, a noise not asked for, too few samples."""
    rec = noisy(1e-5)
    with pytest.raises(InputError, match="given twice"):
        derivatives(rec, cutoff=10.0, smoother=Smoother(11, RATE))
    with pytest.raises(InputError, match=r"smoother\.rate: the filter is made for another rate"):
        rec.smoothed(Smoother(11, 2 * RATE))
    with pytest.raises(InputError, match="no position moves"):
        derivatives(Recording(T, {"q.a": 0 * T, "tau.a": T}))
    with pytest.raises(InputError, match=r"tau\.a: the noise of the channel was not requested"):
        derivatives(rec, ["q.a"], cutoff=10.0).std("tau.a")
    with pytest.raises(InputError, match=r"did you mean 'q\.a'"):
        derivatives(rec, ["q.b"])
    with pytest.raises(InputError, match="too few to choose"):
        best_smoother(np.zeros(30), RATE, estimate_noise(T, sines(T)))
    with pytest.raises(InputError, match="known: value"):
        best_smoother(rec["q.a"], RATE, estimate_noise(T, sines(T)), order="third")
