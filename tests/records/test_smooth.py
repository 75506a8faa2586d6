"""One filter for every term: exact on polynomials, consistent between orders, its noise known."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, savgol_coeffs

from flexdyn.errors import InputError
from flexdyn.records.signals.kernels import GaussianSmoother, kernels
from flexdyn.records.signals.smooth import ORDERS, Smoother
from tests.records.motions import acceleration, sines

RATE = 500.0
SMOOTHERS = [
    Smoother(5, RATE),
    Smoother(31, RATE),
    Smoother(31, RATE, degree=5, taper=0),
    Smoother(501, RATE, degree=7),
    Smoother(8001, RATE),
]
ANY = st.builds(
    lambda half, degree, taper: Smoother(2 * (half + degree // 2) + 3, RATE, degree, taper),
    st.integers(0, 300),
    st.integers(1, 7),
    st.integers(0, 8),
)


@settings(max_examples=60, deadline=None)
@given(smoother=ANY)
def test_kernels_sum_exactly(smoother: Smoother) -> None:
    """A position leaks into no derivative: the weights sum to 0, and those of the values to 1, to the last bit."""
    family = kernels(smoother.width // 2, smoother.degree, smoother.taper)
    assert math.fsum(family.first) == 0.0
    assert math.fsum(family.second) == 0.0
    assert math.fsum(family.value) == 1.0
    assert math.fsum(family.held) == 1.0
    for kernel, sign in ((family.value, 1), (family.first, -1), (family.second, 1)):
        np.testing.assert_array_equal(kernel, sign * kernel[::-1])
        assert len(kernel) == 2 * smoother.reach + 1


@settings(max_examples=60, deadline=None)
@given(smoother=ANY, seed=st.integers(0, 1000))
def test_polynomials_come_out_exactly(smoother: Smoother, seed: int) -> None:
    """Value, first and second derivative of any polynomial up to the degree, to rounding."""
    n = 2 * smoother.reach + 6
    u = np.linspace(-1.0, 1.0, n)
    p = np.polynomial.Polynomial(np.random.default_rng(seed).normal(size=smoother.degree + 1))
    per_second = smoother.rate * (u[1] - u[0])
    x, at = p(u), u[smoother.valid]
    eps = 1e-14 * np.abs(p.coef).sum() * n
    np.testing.assert_allclose(smoother.value(x), p(at), atol=eps)
    np.testing.assert_allclose(smoother.first(x), p.deriv()(at) * per_second, atol=eps * RATE)
    np.testing.assert_allclose(smoother.second(x), p.deriv(2)(at) * per_second**2, atol=eps * RATE**2)


@pytest.mark.parametrize("smoother", SMOOTHERS, ids=str)
def test_constants_have_no_derivative(smoother: Smoother) -> None:
    """Exactly zero, and the value exactly the constant, however long the kernel."""
    x = np.full(2 * smoother.reach + 9, 1.2345678e6)
    assert not smoother.first(x).any()
    assert not smoother.second(x).any()
    np.testing.assert_array_equal(smoother.value(x), x[smoother.valid])
    np.testing.assert_array_equal(smoother.held(x), x[smoother.valid])


@settings(max_examples=30, deadline=None)
@given(smoother=ANY, seed=st.integers(0, 1000), a=st.floats(-3, 3), b=st.floats(-3, 3))
def test_linear_and_blind_to_the_arrow_of_time(smoother: Smoother, seed: int, a: float, b: float) -> None:
    """Sums go through term by term; run backwards, values and accelerations stay and velocities change sign."""
    x, y = np.random.default_rng(seed).normal(size=(2, 2 * smoother.reach + 20))
    for order, sign in (("value", 1), ("first", -1), ("second", 1)):
        apply = getattr(smoother, order)
        scale = smoother.noise_std(order, [1.0])
        np.testing.assert_allclose(apply(a * x + b * y), a * apply(x) + b * apply(y), atol=1e-11 * scale)
        np.testing.assert_allclose(apply(x[::-1]), sign * apply(x)[::-1], atol=1e-11 * scale)


def test_without_a_taper_the_value_is_savitzky_and_golays() -> None:
    """SciPy's coefficients for the same width and degree."""
    for width, degree in ((5, 3), (21, 2), (21, 5), (101, 3)):
        ours = kernels(width // 2, degree, 0).value[4:-4]
        np.testing.assert_allclose(ours, savgol_coeffs(width, degree), atol=1e-10)


@pytest.mark.parametrize("smoother", SMOOTHERS[:4], ids=str)
def test_every_order_has_the_same_response(smoother: Smoother) -> None:
    """A sine of frequency f is multiplied by H, i w H, -w^2 H: no term of an equation is filtered otherwise."""
    t = np.arange(4000) / RATE
    for share in (0.3, 1.0):
        f = share * min(smoother.cutoff, 0.12 * RATE)
        w = 2 * np.pi * f
        x, h = np.sin(w * t), float(smoother.response(f))
        at = t[smoother.valid]
        np.testing.assert_allclose(smoother.value(x), h * np.sin(w * at), atol=1e-12)
        np.testing.assert_allclose(smoother.first(x), h * w * np.cos(w * at), atol=3e-4 * h * w)
        np.testing.assert_allclose(smoother.second(x), -h * w * w * np.sin(w * at), atol=1e-4 * h * w * w)


@pytest.mark.parametrize("smoother", SMOOTHERS[:4], ids=str)
def test_held_torque_is_the_second_derivative_of_what_it_accelerates(smoother: Smoother) -> None:
    """With x'' = u and u random, held: second(x) is held(u) to rounding, where value(u) is half a sample early."""
    u = np.random.default_rng(3).normal(size=3000)
    v = np.concatenate([[0.0], np.cumsum(u)]) / RATE
    x = np.concatenate([[0.0], np.cumsum(v[:-1] / RATE + u / 2 / RATE**2)])[:-1]
    error = smoother.second(x) - smoother.held(u)
    assert np.abs(error).max() < 1e-7
    assert np.std(smoother.second(x) - smoother.value(u)) > 1e3 * np.std(error)


@pytest.mark.parametrize("std", [1e-6, 1e-5, 1e-4])
def test_users_are_served_better_than_by_the_gaussian_of_the_diagnosis(std: float) -> None:
    """Smallest error of an acceleration that any width of a family reaches: the Gaussian's is at least three times."""
    rate = 1000.0
    t = np.arange(8000) / rate
    x = sines(t) + std * np.random.default_rng(4).normal(size=len(t))
    truth = acceleration(t)

    def error(found: np.ndarray, lost: int) -> float:
        inner = slice(300 - lost, len(t) - 300 - lost)  # the same samples for every filter
        return float(np.sqrt(np.mean((found[inner] - truth[300:-300]) ** 2)))

    local = [Smoother(2 * round(2.5 * 1.2**k) + 1, rate) for k in range(24)]
    gaussian = [GaussianSmoother.of_width(1.25 * 1.12**k / rate, 1 / rate) for k in range(33)]
    best = min(error(smoother.second(x), smoother.reach) for smoother in local)
    assert min(error(smoother.apply(x, 2), smoother.half) for smoother in gaussian) > 3.0 * best


@pytest.mark.parametrize("smoother", SMOOTHERS, ids=str)
def test_the_cutoff_is_where_the_response_says(smoother: Smoother) -> None:
    """-3 dB there, and more below."""
    assert float(smoother.response(smoother.cutoff)) == pytest.approx(math.sqrt(0.5), rel=2e-3)
    assert float(smoother.response(0.0)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("degree", [1, 3, 5])
@pytest.mark.parametrize("cutoff", [2.0, 17.0, 60.0])
def test_a_filter_is_found_by_its_cutoff(cutoff: float, degree: int) -> None:
    """The nearest odd width: a wider or narrower one is further off."""
    best = Smoother.at_cutoff(cutoff, RATE, degree)
    off = abs(best.cutoff - cutoff)
    for step in (-2, 2):
        if best.width + step >= 2 * (degree // 2) + 3:
            assert abs(Smoother(best.width + step, RATE, degree).cutoff - cutoff) >= off


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("colour", [0.0, 0.8])
def test_noise_is_propagated(order: str, colour: float) -> None:
    """Standard deviation of filtered noise, white and coloured, against 400000 samples of it."""
    smoother = Smoother(15, RATE)
    white = np.random.default_rng(5).normal(size=400_000)
    x = lfilter([math.sqrt(1 - colour**2)], [1.0, -colour], white)
    out = getattr(smoother, order)(x)
    covariance = colour ** np.arange(60.0)
    assert smoother.noise_std(order, covariance) == pytest.approx(float(out.std()), rel=0.02)
    if colour == 0.0:
        assert smoother.noise_std(order, [1.0]) == pytest.approx(float(out.std()), rel=0.01)


def test_tables_are_filtered_column_by_column() -> None:
    """The same as one channel alone, for short kernels and for long ones that go through the FFT."""
    x = np.random.default_rng(6).normal(size=(3000, 3))
    for smoother in (Smoother(31, RATE), Smoother(601, RATE)):
        for order in ORDERS:
            together = getattr(smoother, order)(x)
            alone = np.column_stack([getattr(smoother, order)(column) for column in x.T])
            np.testing.assert_allclose(together, alone, atol=1e-10 * smoother.noise_std(order, [1.0]))
            assert len(together) == len(x[smoother.valid])


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"width": 12}, "even"),
        ({"width": 3}, "width: not a whole number in range, got 3; give 5 to"),
        ({"width": 5.0}, "not a whole number"),
        ({"degree": 8}, "degree"),
        ({"degree": True}, "degree"),
        ({"taper": -1}, "taper"),
        ({"rate": 0.0}, "rate"),
        ({"rate": math.nan}, "rate"),
        ({"rate": "fast"}, "rate"),
    ],
)
def test_what_makes_no_filter_is_refused(given_: dict[str, object], message: str) -> None:
    """One line with the argument and what would be right."""
    with pytest.raises(InputError, match=message):
        Smoother(**{"width": 11, "rate": RATE, **given_})  # type: ignore[arg-type]


def test_wrong_samples_are_refused() -> None:
    """Too few, not finite (with its row), not a table, no such output, no such cut-off."""
    smoother = Smoother(11, RATE)
    with pytest.raises(InputError, match="the filter of width 11 needs 19"):
        smoother.value(np.zeros(18))
    assert len(smoother.value(np.zeros(19))) == 1
    x = np.zeros((50, 2))
    x[7, 1] = np.nan
    with pytest.raises(InputError, match="row 7"):
        smoother.first(x)
    with pytest.raises(InputError, match="no column"):
        smoother.second(np.zeros((3, 3, 3)))
    with pytest.raises(InputError, match="known: value"):
        smoother.noise_std("third", [1.0])
    with pytest.raises(InputError, match="cut-off"):
        Smoother.at_cutoff(249.0, RATE)


def test_smoothers_are_values() -> None:
    """Equal by their settings, frozen, and they pickle."""
    smoother = Smoother(31, RATE)
    assert pickle.loads(pickle.dumps(smoother)) == smoother == Smoother(31, RATE, 3, 3)  # noqa: S301 - our own bytes
    with pytest.raises(AttributeError):
        smoother.width = 5  # type: ignore[misc]
