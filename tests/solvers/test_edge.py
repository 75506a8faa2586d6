"""A joint whose load is, to the last bit, what its friction can hold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexdyn as fd
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver
from tests.oracles.two_link import TwoLink
from tests.solvers.arms import Array, coulomb, label, planar, positions

STIFFNESS, LEVELS = 50.0, (0.3, 0.2)
ARM = TwoLink(stiffness=(STIFFNESS, STIFFNESS), link_friction=lambda joint, v: LEVELS[joint])
"""Both links on their way forward."""
LAST_BITS = range(-6, 7)
INSTANT = 2e-3


def load(x: Array) -> float:
    """What holds the elbow at rest while the shoulder moves forward: K (theta - q) - h - D12 a1."""
    q, v = x[:2].tolist(), x[4:6].tolist()
    spring = STIFFNESS * (x[2:4] - x[:2])
    d11, _, d12, _ = ARM.inertias(q[1])
    h1, h2 = ARM.bias(q, v)
    return float(spring[1] - h2 - d12 * (spring[0] - LEVELS[0] - h1) / d11)


def at_the_edge(rng: np.random.Generator) -> Array:
    """[q, theta, v, omega]: the elbow's load is its level, and about to grow."""
    while True:
        q, v = rng.uniform(-1.5, 1.5, 2), np.array([rng.uniform(0.5, 3.0), 0.0])
        x = np.concatenate([q, q, v, [v[0], 0.3]])
        x[2] += rng.uniform(-0.05, 0.05)
        x[3] += (LEVELS[1] - load(x)) / STIFFNESS
        rate = np.array(ARM.derivative(x.tolist(), (0.0, 0.0)))
        rate[5] = 0.0
        if load(x + 1e-6 * rate) - load(x) > 1e-6:
            return x


@pytest.mark.parametrize("solver", [DormandPrince(), Rosenbrock()], ids=label)
def test_a_load_at_the_level_breaks_the_joint_away_whatever_its_last_bit(solver: Solver) -> None:
    """Shoulder moving, elbow at rest under its level give or take a few ulps: it slides from the first instant on."""
    model, rng = planar(STIFFNESS, coulomb("link", *LEVELS), joints=2), np.random.default_rng(1)
    for _ in range(60):
        x = at_the_edge(rng)
        sliding = solve_ivp(lambda t, x: ARM.derivative(x, (0.0, 0.0)), (0.0, INSTANT), x, rtol=1e-10, atol=1e-12)
        theta0 = [[x[2], x[3] + bits * np.spacing(x[3])] for bits in LAST_BITS]
        runs = fd.simulate_many(
            model, None, INSTANT, solver, q0=x[:2], v0=x[4:6], theta0=theta0, omega0=x[6:], rate=1e4
        )
        for run in runs:
            assert isinstance(run, fd.Run), run
            np.testing.assert_allclose(positions(run)[-1], sliding.y[:4, -1], rtol=0.0, atol=1e-10)
            assert run.v[-1, 1] > 0.0
