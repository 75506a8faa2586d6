"""The closed-form equations against kinetic energy computed by hand: rods as mass points, no inertia formula."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.paper import equations as eq

Array = NDArray[np.float64]

# Table I again, typed here and not taken from the package.
LENGTH, LINE_DENSITY, END_MASS, STIFFNESS = 1.05, 0.405, 0.1, 5.5
# Three Gauss points integrate the square of a velocity that is linear along a rod exactly.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(3)
STATES = np.random.default_rng(7).uniform(-3.0, 3.0, (25, 4))


def kinetic(q: Array, v: Array) -> float:
    """Energy of both rods and the end mass [J]: 1/2 of the integral of |velocity|^2 over the mass."""
    total = 0.0
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        s = 0.5 * LENGTH * (1 + point)
        mass = LINE_DENSITY * 0.5 * LENGTH * weight
        total += 0.5 * mass * (speed(q, v, s, 0.0) ** 2 + speed(q, v, LENGTH, s) ** 2)
    return total + 0.5 * END_MASS * speed(q, v, LENGTH, LENGTH) ** 2


def speed(q: Array, v: Array, first: float, second: float) -> float:
    """Of the point `first` along link 1 and then `second` along link 2 [m/s], by the complex step: exact."""
    h = 1e-30
    a, b = q[0] + 1j * h * v[0], q[0] + q[1] + 1j * h * (v[0] + v[1])
    place = np.array([first * np.cos(a) + second * np.cos(b), first * np.sin(a) + second * np.sin(b)])
    return float(np.linalg.norm(place.imag / h))


def inertia(q: Array) -> Array:
    """M from the energy: M_ij = T(e_i + e_j) - T(e_i) - T(e_j), M_ii = 2 T(e_i)."""
    one, two = np.eye(2)
    diagonal = [2 * kinetic(q, one), 2 * kinetic(q, two)]
    mixed = kinetic(q, one + two) - kinetic(q, one) - kinetic(q, two)
    return np.array([[diagonal[0], mixed], [mixed, diagonal[1]]])


def lagrange(q: Array, v: Array) -> Array:
    """Coriolis torques from the energy: (dM/dt) v - dT/dq, by central differences."""
    h = 1e-5
    rate = (inertia(q + h * v) - inertia(q - h * v)) / (2 * h)
    slope = [(kinetic(q + h * e, v) - kinetic(q - h * e, v)) / (2 * h) for e in np.eye(2)]
    return np.asarray(rate @ v - slope)


@pytest.mark.parametrize("state", STATES)
def test_mass_matrix(arm: eq.Arm, state: Array) -> None:
    """Eq. 16-18 with I = m L^2/12 are the inertia of two rods and a point mass."""
    q = state[:2]
    np.testing.assert_allclose(eq.mass_matrix(arm, q), inertia(q), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("state", STATES)
def test_coriolis(arm: eq.Arm, state: Array) -> None:
    """The velocity terms of eq. 12, 13 with eq. 19 follow from Lagrange's equations, signs included."""
    q, v = state[:2], state[2:]
    np.testing.assert_allclose(eq.coriolis(arm, q, v), lagrange(q, v), rtol=1e-7, atol=1e-8)


def test_acceleration_satisfies_the_equation_of_motion(arm: eq.Arm) -> None:
    """M a + c = torque with M and c from the energy."""
    torque = np.array([0.4, -0.7])
    for state in STATES:
        q, v = state[:2], state[2:]
        a = eq.link_acceleration(arm, q, v, torque)
        np.testing.assert_allclose(inertia(q) @ a + lagrange(q, v), torque, rtol=1e-6, atol=1e-7)


def test_energy_balance(arm: eq.Arm) -> None:
    """Along eq. 12-15 the energy of links, rotors and springs changes by what motors give and friction takes."""
    rng = np.random.default_rng(8)
    tau = np.array([0.3, -0.2])

    def energy(x: Array) -> float:
        rotors = 0.5 * arm.J * (x[6:] ** 2).sum()
        return kinetic(x[:2], x[4:6]) + float(rotors + 0.5 * STIFFNESS * ((x[2:4] - x[:2]) ** 2).sum())

    for x in rng.uniform(-1.5, 1.5, (25, 8)):
        rate, h = eq.derivative(arm, x, tau), 1e-6
        change = (energy(x + h * rate) - energy(x - h * rate)) / (2 * h)
        power = float(tau @ x[6:] - arm.v * (x[4:6] ** 2).sum())
        assert change == pytest.approx(power, rel=1e-7, abs=1e-8)


def tip_differences(arm: eq.Arm, q: Array) -> Array:
    """The Jacobian by central differences of the tip's position."""
    h = 1e-6
    return np.stack([(eq.tip(arm, q + h * e) - eq.tip(arm, q - h * e)) / (2 * h) for e in np.eye(2)], -1)


@pytest.mark.parametrize("state", STATES)
def test_jacobian(arm: eq.Arm, state: Array) -> None:
    """Eq. 8-11, corrected, are the derivative of the tip's position."""
    np.testing.assert_allclose(eq.jacobian(arm, state[:2]), tip_differences(arm, state[:2]), atol=1e-9)


def test_tip_is_reached_link_by_link(arm: eq.Arm) -> None:
    """Stretched, folded by 90 degrees and folded back the tip is where a ruler says."""
    q = np.array([[0.0, 0.0], [0.0, np.pi / 2], [0.5, np.pi]])
    np.testing.assert_allclose(eq.tip(arm, q), [[2.1, 0.0], [1.05, 1.05], [0.0, 0.0]], atol=1e-15)


def test_equation_10_and_11_as_printed_are_wrong(arm: eq.Arm) -> None:
    """The printed eq. 10 misses the derivative by 2 l cos q1, eq. 11 by (l - I_2) cos(q1 + q2); eq. 8, 9 are right."""
    q = np.array([0.3, 0.8])
    missed = eq.jacobian_as_printed(arm, q) - tip_differences(arm, q)
    rod = LINE_DENSITY * LENGTH**3 / 12
    wrong = [[0.0, 0.0], [-2 * LENGTH * np.cos(0.3), (rod - LENGTH) * np.cos(1.1)]]
    np.testing.assert_allclose(missed, wrong, atol=1e-9)
    assert abs(missed[1, 0]) > 2.0


def test_equation_17_as_printed_is_wrong(arm: eq.Arm) -> None:
    """With I_2^2 for l_2^2 eq. 17 loses the end mass's inertia, m l^2 = 0.11 kg m^2."""
    true = inertia(np.array([0.0, 1.0]))[1, 1]
    assert eq.D22(arm) == pytest.approx(true, rel=1e-12)
    assert true - eq.D22_as_printed(arm) == pytest.approx(END_MASS * LENGTH**2, rel=0.01)


def test_tip_acceleration_needs_the_rate_of_the_jacobian(arm: eq.Arm) -> None:
    """Eq. 6, 7 leave out (dJ/dt) q': with it the second derivative of the tip's position comes out, without not."""
    h = 1e-4
    for state in STATES:
        q, v, a = state[:2], state[2:], np.array([1.0, -2.0])
        places = [eq.tip(arm, q + s * v + 0.5 * s**2 * a) for s in (-h, 0.0, h)]
        measured = (places[0] - 2 * places[1] + places[2]) / h**2
        term = eq.jacobian_rate(arm, q, v) @ v
        np.testing.assert_allclose(eq.jacobian(arm, q) @ a + term, measured, atol=2e-6)
        assert np.linalg.norm(term) > 1e-3


def test_friction_law() -> None:
    """Eq. 1: odd, b^s just off rest, b^d + b^v u far from it, b^d + (b^s - b^d)/e at epsilon but for b^v."""
    law = {"viscous": 0.01, "static": 0.03, "dynamic": 0.02, "epsilon": 0.05}
    u = np.array([1e-12, 0.05, 5.0])
    expected = [0.03, 0.02 + 0.01 / np.e + 0.0005, 0.07]
    np.testing.assert_allclose(eq.friction(u, **law), expected, rtol=1e-9)
    np.testing.assert_array_equal(eq.friction(-u, **law), -eq.friction(u, **law))
    assert eq.friction(0.0, **law) == 0.0
