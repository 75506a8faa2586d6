"""Laws with memory along a path: exact states, closed loops, what they forget."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexdyn.effects import MemoryEffect, PreslidingFriction, SpringHysteresis

BRISTLES = PreslidingFriction("shoulder", side="motor", level=2.0, stiffness=500.0, damping=0.3)
BOUC_WEN = SpringHysteresis("shoulder", stiffness=1000.0, width=0.004)
BOTH = pytest.mark.parametrize("effect", [BRISTLES, BOUC_WEN], ids=lambda effect: effect.name)


@BOTH
def test_states_along_a_path_equal_an_integration_in_time(effect: Any) -> None:
    """Z' = u - abs(u) z/reach along x(t) = a sin t + b sin 3t, by SciPy."""
    assert effect.reach == 0.004
    t = np.linspace(0.0, 9.0, 4001)
    x = 0.011 * np.sin(t) + 0.004 * np.sin(3 * t)
    u = 0.011 * np.cos(t) + 0.012 * np.cos(3 * t)

    def f(time: float, z: Any) -> Any:
        speed = 0.011 * np.cos(time) + 0.012 * np.cos(3 * time)
        return speed - abs(speed) * z / 0.004

    z = solve_ivp(f, (0.0, 9.0), [0.001], t_eval=t, rtol=1e-10, atol=1e-13, max_step=0.01).y[0]
    # Exact between turning points; where x turns within a sample the path is cut short.
    np.testing.assert_allclose(effect.states_along(x, 0.001), z, atol=4e-8)
    damping = effect.damping if isinstance(effect, PreslidingFriction) else 0.0
    expected = effect.stiffness * z + damping * (u - abs(u) * z / 0.004)
    np.testing.assert_allclose(effect.along(x, u, 0.001), expected, atol=1e-4)


@BOTH
def test_a_path_in_more_points_gives_the_same(effect: MemoryEffect) -> None:
    """The state is a function of the path, not of its samples."""
    x = np.array([0.0, 0.005, -0.002, 0.009])
    fine = np.interp(np.linspace(0, 3, 3001), np.arange(4), x)
    np.testing.assert_allclose(effect.states_along(fine)[::1000], effect.states_along(x), rtol=1e-12)


@BOTH
def test_a_loop_takes_energy(effect: Any) -> None:
    """Going round costs work; wide turns come back to the same torque; the first step is a spring's."""
    x = effect.example_path()
    torque = effect.along(x)
    assert abs(torque).max() <= effect.along(np.linspace(0, 1, 9))[-1] * (1 + 1e-12)
    work = np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(x))
    assert work > 0.0
    small = effect.reach * 1e-6
    assert effect.along([0.0, small])[1] == pytest.approx(effect.stiffness * small, rel=1e-5)
    assert x[240] == pytest.approx(x[720]) == pytest.approx(4 * effect.reach)
    assert torque[240] == pytest.approx(torque[720], rel=0.02)


@BOTH
def test_reversed_paths_give_reversed_torques(effect: MemoryEffect) -> None:
    """Neither direction is better."""
    x = effect.example_path()
    np.testing.assert_array_equal(effect.along(-x), -effect.along(x))


def test_a_level_of_nothing() -> None:
    """Without a level there is no state to remember: no torque and no NaN."""
    none = PreslidingFriction("shoulder", side="motor", level=0.0, stiffness=500.0)
    np.testing.assert_array_equal(none.along([0.0, 1.0, -1.0], 1.0), np.zeros(3))
