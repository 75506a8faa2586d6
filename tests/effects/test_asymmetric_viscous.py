"""Viscous friction of either direction: its corner at rest is located, and every solver gives the same motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import AsymmetricViscousFriction, CoulombFriction, Effect, ViscousFriction
from tests.effects.arms import model_of
from tests.effects.reference import Arm

Array = NDArray[np.float64]
UP, DOWN, STIFFNESS, ROTOR = 1.4, 0.2, 60.0, 1.0
EXACT = fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12)
OSCILLATOR = Arm((math.inf,), (0.0,), (ROTOR,))
"""A rigid arm that a spring pulls to 0: between two stops a linear oscillator of one damping."""


def _inertia() -> float:
    return float(OSCILLATOR.mass_matrix([0.0])[0, 0])


def _swings(times: Array, start: float) -> Array:
    """Position of a linear oscillator whose damping depends on the direction, released from rest, in closed form.

    From a turning point q0 it is ``q = q0 exp(-a t) (cos w t + a/w sin w t)`` over half a period, ``a = c/(2 I)``.
    """
    inertia, found, t0, q0 = _inertia(), np.empty(len(times)), 0.0, start
    while t0 < times[-1]:
        decay = (UP if q0 < 0.0 else DOWN) / (2.0 * inertia)
        w = math.sqrt(STIFFNESS / inertia - decay**2)
        inside = (times >= t0) & (times <= t0 + math.pi / w)
        s = times[inside] - t0
        found[inside] = q0 * np.exp(-decay * s) * (np.cos(w * s) + decay / w * np.sin(w * s))
        q0, t0 = -q0 * math.exp(-decay * math.pi / w), t0 + math.pi / w
    return found


def _model(side: Any = "motor", more: tuple[Effect, ...] = ()) -> fd.FlexibleJointModel:
    law = AsymmetricViscousFriction("shoulder", side=side, coefficient_positive=UP, coefficient_negative=DOWN)
    spring = fd.effects.ParallelSpring("shoulder", stiffness=STIFFNESS, rest=0.0)
    return model_of(OSCILLATOR, [law, spring, *more])


TIMES = np.linspace(0.0, 4.0, 401)
SOLVERS = [
    (EXACT, 1e-9),
    (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11), 1e-6),
    (fd.solvers.RungeKutta4(step=1e-4), 1e-8),
    (fd.solvers.TimeStepping(step=1e-5), 2e-4),
]


@pytest.mark.parametrize(("solver", "tolerance"), SOLVERS, ids=[type(each).__name__ for each, _ in SOLVERS])
@pytest.mark.parametrize("side", ["link", "motor"])
def test_an_oscillator_in_closed_form(side: Any, solver: Any, tolerance: float) -> None:
    """Every half swing has the damping of its direction."""
    run = fd.simulate(_model(side), None, TIMES[-1], solver, times=TIMES, q0=[0.5])
    np.testing.assert_allclose(run.q[:, 0], _swings(TIMES, 0.5), atol=tolerance)


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.Rosenbrock(rtol=1e-7, atol=1e-9)], ids=["explicit", "implicit"])
def test_every_turning_point_is_an_event_and_no_other(solver: Any) -> None:
    """Started from rest in either direction: the acceleration says on which piece the motion begins."""
    inertia = _inertia()
    for start, coefficients in ((0.5, (DOWN, UP)), (-0.5, (UP, DOWN))):
        halves = [math.pi / math.sqrt(STIFFNESS / inertia - (c / (2.0 * inertia)) ** 2) for c in coefficients]
        ends = np.cumsum(halves * 30)
        run = fd.simulate(_model(), None, TIMES[-1], solver, times=TIMES, q0=[start])
        assert run.stats["events"] == int((ends < TIMES[-1]).sum())


def test_beside_dry_friction_a_stop_is_one_event() -> None:
    """The contact's breaking away chooses the piece at once; stuck, it is exactly at rest."""
    model = _model(more=(CoulombFriction("shoulder", side="link", level=4.0),))
    run = fd.simulate(model, None, 3.0, EXACT, rate=1000, q0=[0.5])
    moving = np.sign(run.v[:, 0])
    turns = int((np.diff(moving[moving != 0.0]) != 0.0).sum())
    assert (run.v[-100:] == 0.0).all()
    # the start breaks away at once; each turn is one event where the stop is a point of passage, and the last one holds
    assert run.stats["events"] == turns + 1


def test_equal_coefficients_are_viscous_friction() -> None:
    """To the tolerance: the corner that is located changes steps, not the law."""
    same = AsymmetricViscousFriction("shoulder", side="motor", coefficient_positive=0.7, coefficient_negative=0.7)
    spring = fd.effects.ParallelSpring("shoulder", stiffness=STIFFNESS, rest=0.0)
    runs = [
        fd.simulate(model_of(OSCILLATOR, [each, spring]), None, 4.0, EXACT, times=TIMES, q0=[0.5])
        for each in (same, ViscousFriction("shoulder", side="motor", coefficient=0.7))
    ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, atol=1e-9)


def test_beside_viscous_friction_it_says_what_the_direction_changes() -> None:
    """(c, -c) beside a coefficient of at least c is the same law, to the tolerance."""
    mean, half = 0.5 * (UP + DOWN), 0.5 * (UP - DOWN)
    parts = [
        ViscousFriction("shoulder", side="motor", coefficient=mean),
        AsymmetricViscousFriction("shoulder", side="motor", coefficient_positive=half, coefficient_negative=-half),
        fd.effects.ParallelSpring("shoulder", stiffness=STIFFNESS, rest=0.0),
    ]
    run = fd.simulate(model_of(OSCILLATOR, parts), None, TIMES[-1], EXACT, times=TIMES, q0=[0.5])
    np.testing.assert_allclose(run.q[:, 0], _swings(TIMES, 0.5), atol=1e-9)


def test_large_coefficients_stay_stable_in_large_steps() -> None:
    """TimeStepping takes the coefficient of the direction implicitly: no step is too long for it."""
    stiff = AsymmetricViscousFriction("shoulder", side="motor", coefficient_positive=1e5, coefficient_negative=1e4)
    run = fd.simulate(model_of(OSCILLATOR, [stiff]), [2.0], 1.0, fd.solvers.TimeStepping(step=1e-2), v0=[1.0])
    assert run.v[-1, 0] == pytest.approx(2.0 / 1e5, rel=1e-6)
    back = fd.simulate(model_of(OSCILLATOR, [stiff]), [-2.0], 1.0, fd.solvers.TimeStepping(step=1e-2), v0=[1.0])
    assert back.v[-1, 0] == pytest.approx(-2.0 / 1e4, rel=1e-6)
