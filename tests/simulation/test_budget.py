"""A run has a budget of steps; one that spends it says where it stands, why it is slow, and what would do."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect, PreslidingFriction, ViscousFriction
from flexdyn.simulation.fastest_motion import fastest_motion
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import STIFF, budget, fastest_rate
from flexdyn.simulation.solvers import (
    DormandPrince,
    DormandPrinceThenRosenbrock,
    Rosenbrock,
    RungeKutta4,
    TimeStepping,
)
from tests.arms import state
from tests.effects.arms import model_of
from tests.effects.reference import Arm

SOFT = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.1))
HARD = Arm((1e9, 200.0), (0.5, 0.3), (1e-3, 0.1))
MOVING: dict[str, Any] = {"q0": [0.0, 1.0], "v0": [0.3, 0.1]}
BRISTLES = PreslidingFriction("elbow", side="motor", level=0.05, stiffness=5e3)
"""They reach over 10 microrad: at 1 rad/s they follow within 10 microseconds, at rest they are slow."""


def becomes_stiff() -> fd.FlexibleJointModel:
    """An arm that starts at rest, where nothing is fast, and swings."""
    return model_of(SOFT, [BRISTLES])


def test_a_spent_budget_says_where_it_stands() -> None:
    """Time reached, the fastest rate, the spring it comes of, and a solver that then ends."""
    model = model_of(HARD)
    with pytest.raises(fd.SimulationError, match="stopped at t = ") as spent:
        fd.simulate(model, None, 1.0, DormandPrince(max_steps=2000), **MOVING)
    error = spent.value
    assert error.reason == "more steps than allowed"
    assert 0.0 < error.t < 1.0
    assert error.fastest.rate == pytest.approx(math.sqrt(1e9 / 1e-3), rel=0.05)
    assert (error.fastest.joint, error.fastest.cause[:17]) == ("shoulder", "the stiffness 1e+")
    assert "shoulder" in str(error)
    assert "take Rosenbrock" in str(error)
    assert "if these stop too, take TimeStepping" in str(error)
    assert "\n" not in str(error)
    assert fd.simulate(model, None, 1.0, Rosenbrock(), **MOVING).t[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("arm", "effects", "joint", "cause"),
    [
        (Arm((300.0, 200.0), (5e4, 0.0), (0.1, 0.1)), [], "shoulder", "damping"),
        (Arm((300.0, 9e7), (0.0, 0.0), (0.1, 0.01)), [], "elbow", "stiffness"),
        (SOFT, [ViscousFriction("elbow", side="motor", coefficient=1e4), BRISTLES], "elbow", "viscous_friction"),
        (SOFT, [PreslidingFriction("shoulder", side="link", level=1.0, stiffness=1e8)], "shoulder", "presliding"),
    ],
    ids=["damping", "spring", "viscous", "bristles"],
)
def test_the_cause_of_the_fastest_motion_is_named(arm: Arm, effects: list[Effect], joint: str, cause: str) -> None:
    """The part whose slopes make the greatest eigenvalue, and that eigenvalue."""
    model = model_of(arm, effects)
    plant = build_plant(model)
    x = np.zeros(plant.state_size)
    x[4:8] = 0.3
    found = fastest_motion(model, x, np.zeros(2))
    assert found is not None
    assert (found.joint, cause in found.cause) == (joint, True), found
    assert found.rate == pytest.approx(fastest_rate(plant, x), rel=1e-6)


@pytest.mark.parametrize(
    "solver", [DormandPrince(max_steps=300), Rosenbrock(max_steps=30)], ids=["explicit", "implicit"]
)
def test_the_budget_is_no_clock(solver: Any) -> None:
    """The same run stops at the same step, alone or beside others."""
    model = model_of(SOFT, [CoulombFriction("elbow", side="motor", level=0.5)])
    with pytest.raises(fd.SimulationError) as alone:
        fd.simulate(model, [1.0, 0.5], 5.0, solver, **MOVING)
    many = fd.simulate_many([model] * 4, [1.0, 0.5], 5.0, solver, threads=3, **MOVING)
    for each in many:
        assert isinstance(each, fd.SimulationError)
        assert each.t == alone.value.t
        np.testing.assert_array_equal(each.state, alone.value.state)


def test_switches_of_the_command_are_counted_apart() -> None:
    """A controller at 5 kHz forces 2,500 steps in half a second; a budget of 50 is not touched by them."""
    command = fd.Controller(lambda t, x: -0.1 * x.omega, 5e3)
    run = fd.simulate(model_of(SOFT), command, 0.5, DormandPrince(max_steps=50), **MOVING)
    assert run.stats["steps"] >= 2500


def test_fixed_steps_have_no_budget() -> None:
    """They always come to an end; an adaptive solver's grows with the time simulated, or is what the user gives."""
    assert [budget(solver, 3600.0) for solver in (RungeKutta4(step=1e-6), TimeStepping())] == [0, 0]
    assert budget(DormandPrince(), 100.0) == 200_000 + 50_000 * 100
    assert budget(Rosenbrock(max_steps=10.0), 100.0) == 10


def test_auto_changes_where_the_run_becomes_stiff() -> None:
    """At rest nothing is fast; once the elbow moves its bristles are. The motion is that of the explicit reference."""
    model = becomes_stiff()
    auto = fd.simulate(model, [2.0, 1.0], 0.5, q0=[0.0, 1.0])
    assert isinstance(auto.solver, DormandPrinceThenRosenbrock)
    assert 0.0 < auto.solver.until < 0.5
    assert any(note.startswith("solver: Rosenbrock from t = ") for note in auto.notes)
    reference = fd.simulate(model, [2.0, 1.0], 0.5, DormandPrince(), q0=[0.0, 1.0])
    np.testing.assert_allclose(auto.q, reference.q, atol=2e-6)
    assert auto.stats["evaluations"] < 0.5 * reference.stats["evaluations"]


def test_a_run_that_changed_is_made_again_bit_for_bit() -> None:
    """Its solver says when it changed; the ledger goes through the motion with it and closes."""
    model = becomes_stiff()
    auto = fd.simulate(model, [2.0, 1.0], 0.3, q0=[0.0, 1.0])
    again = fd.simulate(model, [2.0, 1.0], 0.3, auto.solver, q0=[0.0, 1.0])
    np.testing.assert_array_equal(state(again), state(auto))
    assert again.stats == auto.stats
    assert auto.energy.closes
    (beside,) = fd.simulate_many([model], [2.0, 1.0], 0.3, q0=[0.0, 1.0])
    assert isinstance(beside, fd.Run)
    np.testing.assert_array_equal(state(beside), state(auto))


def test_short_steps_alone_are_not_stiff() -> None:
    """A controller at 20 kHz and tight tolerances make short steps of a soft arm: the reference stays."""
    command = fd.Controller(lambda t, x: -0.1 * x.omega, 20e3)
    run = fd.simulate(model_of(SOFT), command, 0.2, **MOVING)
    assert run.solver == DormandPrince()
    assert run.stats["steps"] >= 0.2 * STIFF


def test_progress_is_told_while_an_arm_stands_still() -> None:
    """Friction holds it through a million switches of the command: no step is taken, and Ctrl-C must get through."""
    sides: tuple[Any, ...] = ("link", "motor")
    held = [CoulombFriction(joint, side=side, level=5.0) for joint in ("shoulder", "elbow") for side in sides]
    model = model_of(SOFT, held)
    t = np.linspace(0.0, 1000.0, 1_000_001)
    command = fd.Samples(t, np.zeros((len(t), 2)), "hold")
    told: list[float] = []

    def enough(reached: float) -> None:
        told.append(reached)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fd.simulate(model, command, 1000.0, DormandPrince(), rate=1.0, progress=enough)
    assert 0.0 < told[0] < 1000.0


def test_a_motion_that_runs_away_is_said_to() -> None:
    """A controller whose gains have the wrong sign: the joint and its speed, and no other solver."""
    command = fd.Controller(lambda t, x: 1e3 * x.omega)
    with pytest.raises(fd.SimulationError, match=r"runs away at .* rad/s: check the gains") as stopped:
        fd.simulate(model_of(SOFT), command, 5.0, DormandPrince(max_steps=20_000), **MOVING)
    assert "take" not in stopped.value.remedy


@pytest.mark.parametrize("solver", [TimeStepping(), RungeKutta4(step=1e-3)], ids=["TimeStepping", "RungeKutta4"])
def test_fixed_steps_take_no_max_steps(solver: Any) -> None:
    """One line that says so."""
    with pytest.raises(fd.InputError, match="max_steps"):
        fd.solvers.make_solver(type(solver).__name__, step=1e-3, max_steps=10)


def test_a_vibration_that_swings_on_is_followed_by_every_adaptive_solver() -> None:
    """A rotor let go beside its link on a spring without damping: Rosenbrock is not proposed, and what is ends."""
    model = model_of(Arm((1e9, 200.0), (0.0, 0.3), (1e-3, 0.1)))
    with pytest.raises(fd.SimulationError, match="take TimeStepping") as spent:
        fd.simulate(model, None, 1.0, DormandPrince(max_steps=2000), theta0=[0.01, 1.0], **MOVING)
    assert "Rosenbrock" not in str(spent.value)
    with pytest.raises(fd.SimulationError, match="more steps than allowed"):
        fd.simulate(model, None, 1.0, Rosenbrock(max_steps=20_000), theta0=[0.01, 1.0], **MOVING)
    assert fd.simulate(model, None, 1.0, TimeStepping(), theta0=[0.01, 1.0], **MOVING).t[-1] == pytest.approx(1.0)
