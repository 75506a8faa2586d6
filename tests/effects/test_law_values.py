"""What a law gives over whole recordings equals a second implementation in NumPy; odd laws are odd."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from tests.effects.arms import catalogue_examples

Array = NDArray[np.float64]
Law = Callable[[Any, Array, Array, Array, Array], Array]
EXAMPLES = {effect.name: effect for effect in catalogue_examples()}


def clipped(e: Any, tau: Array, omega: Array) -> Array:
    """The torque-speed line, neither bound past zero."""
    upper = np.maximum(e.stall_torque * (1 - omega / e.no_load_speed), 0.0)
    return np.clip(tau, np.minimum(-e.stall_torque * (1 + omega / e.no_load_speed), 0.0), upper)


def pressed(e: Any, x: Array, u: Array) -> Array:
    """Spring and damper beyond a stop, where they press."""
    above = np.where(x > e.upper, np.minimum(-e.stiffness * (x - e.upper) - e.damping * u, 0.0), 0.0)
    return above + np.where(x < e.lower, np.maximum(-e.stiffness * (x - e.lower) - e.damping * u, 0.0), 0.0)


LAWS: dict[str, Law] = {
    "viscous_friction": lambda e, t, x, u, tau: e.coefficient * u,
    "coulomb_friction": lambda e, t, x, u, tau: e.level * np.sign(u),
    "asymmetric_friction": lambda e, t, x, u, tau: np.where(u > 0, e.level_positive, e.level_negative) * np.sign(u),
    "stribeck_friction": lambda e, t, x, u, tau: e.excess * np.exp(-((abs(u) / e.velocity) ** e.exponent)) * np.sign(u),
    "asymmetric_viscous_friction": (
        lambda e, t, x, u, tau: e.coefficient_positive * np.maximum(u, 0) + e.coefficient_negative * np.minimum(u, 0)
    ),
    "quadratic_drag": lambda e, t, x, u, tau: e.coefficient * np.sign(u) * u**2,
    "load_dependent_friction": lambda e, t, x, u, tau: e.coefficient * abs(tau) * np.sign(u),
    "directional_gear_loss": (
        lambda e, t, x, u, tau: np.where(tau * u > 0, e.driving * tau, -e.driven * tau) * (u != 0)
    ),
    "stribeck_gear_loss": (
        lambda e, t, x, u, tau: (
            np.where(tau * u > 0, e.driving * tau, -e.driven * tau) * np.exp(-abs(u) / e.velocity) * (u != 0)
        )
    ),
    "position_dependent_friction": (
        lambda e, t, x, u, tau: e.amplitude * (1 + np.sin(e.harmonic * x + e.phase)) * np.sign(u)
    ),
    "warm_up_friction": lambda e, t, x, u, tau: e.coefficient * np.exp(-t / e.time_constant) * u,
    "joint_elasticity": lambda e, t, x, u, tau: e.stiffness * x,
    "transmission_damping": lambda e, t, x, u, tau: e.coefficient * u,
    "hardening_spring": lambda e, t, x, u, tau: e.cubic * x**3,
    "torque_offset": lambda e, t, x, u, tau: tau + e.offset,
    "torque_constant_error": lambda e, t, x, u, tau: tau * (1 + e.gain),
    "torque_ripple": lambda e, t, x, u, tau: tau + e.amplitude * np.sin(e.harmonic * x + e.phase),
    "torque_saturation": lambda e, t, x, u, tau: np.sign(tau) / (1 / abs(tau) + 1 / e.scale),
    "torque_speed_limit": lambda e, t, x, u, tau: clipped(e, tau, u),
    "parallel_spring": lambda e, t, x, u, tau: e.stiffness * (e.rest - x),
    "position_torque": lambda e, t, x, u, tau: (
        -e.cos_1 * np.cos(x) - e.sin_1 * np.sin(x) - e.cos_2 * np.cos(2 * x) - e.sin_2 * np.sin(2 * x)
    ),
    "end_stop": lambda e, t, x, u, tau: pressed(e, x, u),
    "joint_coupling": lambda e, t, x, u, tau: e.coefficient * u + e.level * np.sign(-e.ratio * u),
}
ODD = [
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_drag",
    "load_dependent_friction",
    "directional_gear_loss",
    "stribeck_gear_loss",
    "warm_up_friction",
    "joint_elasticity",
    "transmission_damping",
    "hardening_spring",
    "torque_constant_error",
    "torque_saturation",
    "torque_speed_limit",
    "joint_coupling",
]


def variants(effect: Any) -> list[Any]:
    """The example and two with other numbers, none of them special."""
    rng = np.random.default_rng(7)
    numbers = [field.name for field in effect.parameters()]
    entry = {key: value for key, value in effect.to_dict().items() if key != "effect"}
    found = [effect]
    for scale in (0.37, 1.9):
        changed = {key: getattr(effect, key) * scale + 0.1 * rng.uniform() for key in numbers}
        found.append(type(effect).from_dict(entry | changed))
    return found


@pytest.mark.parametrize("name", LAWS)
def test_a_law_equals_its_formula(name: str) -> None:
    """To rounding, over positions, velocities, times and torques of either sign, zero included."""
    rng = np.random.default_rng(1)
    t, x, u, tau = (rng.normal(0.0, scale, 400) for scale in (3.0, 2.0, 3.0, 4.0))
    t, u[:20] = abs(t), 0.0
    for effect in variants(EXAMPLES[name]):
        expected = LAWS[name](effect, t, x, u, tau)
        np.testing.assert_allclose(effect.torque(x, u, t=t, tau=tau), expected, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("name", ODD)
def test_odd_laws_are_odd(name: str) -> None:
    """f(-x, -u, -tau) = -f(x, u, tau), bit for bit: no direction is better than the other."""
    rng = np.random.default_rng(2)
    x, u, tau = rng.normal(0.0, 2.0, (3, 300))
    effect = EXAMPLES[name]
    np.testing.assert_array_equal(effect.torque(-x, -u, tau=-tau), -effect.torque(x, u, tau=tau))


def test_asymmetric_friction_mirrored_has_its_levels_exchanged() -> None:
    """The other direction of motion feels the other level."""
    u = np.linspace(-1.0, 1.0, 11)
    one = fd.effects.AsymmetricFriction("shoulder", side="link", level_positive=2.0, level_negative=1.0)
    two = fd.effects.AsymmetricFriction("shoulder", side="link", level_positive=1.0, level_negative=2.0)
    np.testing.assert_array_equal(one.torque(0.0, -u), -two.torque(0.0, u))


def test_deflections() -> None:
    """A dead zone takes its half gap off either side; a kinematic error adds what the rotor's angle says."""
    delta, theta = np.random.default_rng(3).normal(0.0, 0.02, (2, 300))
    gap = fd.effects.Backlash("shoulder", half_gap=0.01)
    expected = np.where(delta > 0.01, delta - 0.01, np.where(delta < -0.01, delta + 0.01, 0.0))
    np.testing.assert_allclose(gap.deflection(delta), expected, atol=1e-17)
    np.testing.assert_array_equal(gap.deflection(-delta), -gap.deflection(delta))
    error = fd.effects.KinematicError("shoulder", amplitude=0.003, harmonic=80.0, phase=0.4)
    bent = delta + 0.003 * np.sin(80.0 * theta + 0.4)
    np.testing.assert_allclose(error.deflection(delta, theta), bent, atol=1e-16)


@pytest.mark.parametrize(("amplitude", "phase"), [(-0.5, 0.3), (-0.5, 2.9), (0.5, 1095.9), (0.5, -4.0), (0.5, 0.3)])
def test_a_wave_has_one_form_in_the_usual_range(amplitude: float, phase: float) -> None:
    """The same law, its amplitude positive and its phase within half a turn; a form in this range stays."""
    wave = fd.effects.TorqueRipple("shoulder", amplitude=amplitude, harmonic=2.0, phase=phase)
    usual = wave.in_usual_range()
    theta = np.linspace(-4.0, 4.0, 201)
    np.testing.assert_allclose(usual.torque(theta, 0.0, tau=0.0), wave.torque(theta, 0.0, tau=0.0), atol=1e-12)
    assert usual.amplitude > 0.0
    assert abs(usual.phase) <= np.pi
    assert usual.in_usual_range() is usual
    level = fd.effects.PositionDependentFriction("shoulder", side="motor", amplitude=0.5, harmonic=2.0, phase=phase)
    same = level.in_usual_range().torque(theta, 1.0)
    np.testing.assert_allclose(same, level.torque(theta, 1.0), atol=1e-12)


def test_what_is_no_torque_says_what_to_use() -> None:
    """A payload, a delay, a law with memory, a sensor: one line each."""
    silent = {name for name in EXAMPLES if name not in LAWS}
    assert {name for name, effect in EXAMPLES.items() if effect.no_torque} == silent
    for name in silent:
        with pytest.raises(fd.InputError, match=f"effect: the effect has no torque.*'{name}'; "):
            EXAMPLES[name].torque(0.0, 1.0)
