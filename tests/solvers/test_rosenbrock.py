"""Rosenbrock: order 4, and steps that stiff springs and stiff bristles do not dictate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect, PreslidingFriction, SpringHysteresis, ViscousFriction
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, Solver, TimeStepping
from tests.solvers.arms import coulomb, planar, positions

EXACT = DormandPrince(rtol=1e-13, atol=1e-14)
START: dict[str, Any] = {"q0": [-1.0, 0.8], "theta0": [-0.9, 0.9]}


def test_order_four() -> None:
    """At steps that do not adapt the error falls with the fourth power."""
    effects = [ViscousFriction("shoulder", side="link", coefficient=0.2)]
    model = planar(40.0, effects, joints=2, damping=0.1, gravity=9.81)
    exact = positions(fd.simulate(model, [0.6, -0.2], 1.0, EXACT, **START, times=[1.0]))
    steps, errors = 0.01 / 2.0 ** np.arange(4), []
    for step in steps:
        run = fd.simulate(model, [0.6, -0.2], 1.0, Rosenbrock(rtol=1e3, atol=1e3, max_step=step), **START, times=[1.0])
        errors.append(np.abs(positions(run) - exact).max())
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("friction", [False, True])
def test_the_error_follows_the_tolerance(friction: bool) -> None:
    """From 1e-4 to 1e-9, smooth or sticking, between samples too."""
    effects = [*coulomb("link", 0.3, 0.1), *coulomb("motor", 0.2, 0.1)] if friction else []
    model = planar(40.0, effects, joints=2, damping=0.1, gravity=4.0)
    exact = positions(fd.simulate(model, [0.6, -0.2], 2.0, EXACT, **START, rate=997))
    errors = []
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        run = fd.simulate(model, [0.6, -0.2], 2.0, Rosenbrock(rtol=rtol, atol=rtol), **START, rate=997)
        errors.append(float(np.abs(positions(run) - exact).max() / rtol))
    assert max(errors) < 300.0


def test_stiff_springs_cost_little() -> None:
    """K = 1e7 N m/rad with damping: a tenth of DormandPrince's evaluations for the same motion."""
    model = planar(1e7, joints=2, damping=100.0, gravity=9.81)
    start: dict[str, Any] = {"q0": [-1.0, 0.8], "theta0": "equilibrium", "rate": 100}
    exact = fd.simulate(model, [0.6, -0.2], 1.0, DormandPrince(rtol=1e-10, atol=1e-12), **start)
    stiff, explicit = (
        fd.simulate(model, [0.6, -0.2], 1.0, kind(rtol=1e-6, atol=1e-8), **start)
        for kind in (Rosenbrock, DormandPrince)
    )
    np.testing.assert_allclose(stiff.q, exact.q, atol=1e-6)
    assert stiff.stats["evaluations"] < 0.1 * explicit.stats["evaluations"]


@pytest.mark.parametrize("solver", [Rosenbrock(), TimeStepping(step=1e-3)], ids=["Rosenbrock", "TimeStepping"])
@pytest.mark.parametrize("kind", ["presliding", "hysteresis"])
def test_stiff_memory_does_not_dictate_the_steps(solver: Solver, kind: str) -> None:
    """Bristles of 1e6 N m/rad cost at most three times the steps of 1e3; stability would ask for 1000 times as many."""

    def work(bristle: float) -> int:
        effects: list[Effect] = [
            PreslidingFriction("shoulder", side="link", level=0.5, stiffness=bristle),
            PreslidingFriction("elbow", side="motor", level=0.3, stiffness=bristle),
        ]
        if kind == "hysteresis":
            effects = [SpringHysteresis("shoulder", stiffness=0.5 * bristle / 1e3, width=1e3 / bristle)]
        model = planar(40.0, effects, joints=2, damping=0.1)
        run = fd.simulate(model, [0.6, -0.2], 2.0, solver, **START)
        return run.stats["steps"] + run.stats["rejected"]

    soft = work(1e3)
    for bristle in (1e5, 1e6):
        assert work(bristle) < 3.0 * soft


@pytest.mark.parametrize("stiffness", [1e5, 1e6])
def test_stiff_bristles_end_where_exact_friction_does(stiffness: float) -> None:
    """The stiffer the bristles, the nearer presliding comes to Coulomb friction: within a few of their bends."""
    level = 0.3
    bristles = [
        PreslidingFriction(name, side="link", level=level, stiffness=stiffness) for name in ("shoulder", "elbow")
    ]
    dry = [CoulombFriction(name, side="link", level=level) for name in ("shoulder", "elbow")]
    start: dict[str, Any] = {"q0": [0.0, 0.8], "v0": [1.0, -1.0], "rate": 100}
    soft, hard = (
        fd.simulate(planar(40.0, effects, joints=2, damping=0.5), None, 2.0, Rosenbrock(rtol=1e-8, atol=1e-10), **start)
        for effects in (bristles, dry)
    )
    np.testing.assert_allclose(soft.q, hard.q, atol=30.0 * level / stiffness)
