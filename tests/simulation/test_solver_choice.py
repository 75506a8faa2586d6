"""Which solver ``auto`` takes, what it says about it, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction, Effect, PreslidingFriction, StribeckFriction, ViscousFriction
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import STIFF, fastest_rate
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver, TimeStepping
from tests.effects.arms import model_of
from tests.effects.reference import Arm

SOFT = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.1))
STIFF_ARM = Arm((1e9, 200.0), (0.5, 0.3), (1e-3, 0.1))
LINK: dict[str, Any] = {"joint": "shoulder", "side": "link"}


def chosen(arm: Arm, effects: list[Effect], **start: Any) -> tuple[Solver, str]:
    """The solver that ``auto`` takes, and the one note about it."""
    run = fd.simulate(model_of(arm, effects), None, 1e-4, **start)
    (note,) = [note for note in run.notes if note.startswith("solver auto")]
    return run.solver, note


@pytest.mark.parametrize(
    "effects",
    [
        [],
        [CoulombFriction(**LINK, level=50.0)],
        [StribeckFriction(**LINK, excess=10.0, velocity=1e-4)],
        [PreslidingFriction(**LINK, level=1.0, stiffness=500.0)],
    ],
    ids=["bare", "dry", "steep_stribeck", "soft_bristles"],
)
def test_a_soft_arm_gets_the_reference(effects: list[Effect]) -> None:
    """Vibrations of some 80 rad/s; dry friction, however strong, is no stiffness where it sticks exactly."""
    solver, note = chosen(SOFT, effects, v0=[0.3, 0.1])
    assert solver == DormandPrince()
    assert note.startswith("solver auto: DormandPrince, the fastest rate at the start is")
    assert note.endswith("below 20000 1/s")


@pytest.mark.parametrize(
    ("arm", "effects"),
    [
        (STIFF_ARM, []),
        (Arm((300.0, 200.0), (5e4, 0.0), (0.1, 0.1)), []),
        (SOFT, [PreslidingFriction(**LINK, level=1.0, stiffness=1e6)]),
        (SOFT, [ViscousFriction("elbow", side="motor", coefficient=1e4)]),
    ],
    ids=["spring", "damping", "bristles", "viscous"],
)
def test_a_stiff_arm_gets_an_implicit_solver(arm: Arm, effects: list[Effect]) -> None:
    """K = 1e9 on a rotor of 1e-3, a hard damper, bristles of a micrometre: Rosenbrock, and the note says how fast."""
    solver, note = chosen(arm, effects, v0=[0.3, 0.1])
    assert solver == Rosenbrock()
    assert note.startswith("solver auto: Rosenbrock, the fastest rate at the start is")
    assert note.endswith("above 20000 1/s")


@pytest.mark.parametrize("name", fd.shipped_models())
def test_shipped_arms_get_the_reference(name: str) -> None:
    """The stiffnesses of real drives are no reason for an implicit method."""
    assert fd.simulate(fd.load_model(name), None, 1e-3).solver == DormandPrince()


def test_the_rate_is_the_vibrations() -> None:
    """One joint: sqrt(K (1/J + 1/M)) without damping; 2 zeta omega at most with much of it, by the quadratic."""
    for damping in (0.0, 400.0):
        arm = Arm((300.0,), (damping,), (0.1,))
        inverse = 1 / 0.1 + 1 / float(arm.mass_matrix([0.0])[0, 0])
        roots = np.roots([1.0, damping * inverse, 300.0 * inverse])
        assert fastest_rate(build_plant(model_of(arm)), np.zeros(4)) == pytest.approx(np.abs(roots).max(), rel=1e-6)


def test_the_threshold_divides() -> None:
    """One spring a little softer and one a little stiffer than STIFF on either side of it."""
    inverse = 1 / 0.1 + 1 / float(Arm((1.0,), (0.0,), (0.1,)).mass_matrix([0.0])[0, 0])
    for factor, kind in ((0.98, DormandPrince), (1.02, Rosenbrock)):
        arm = Arm(((factor * STIFF) ** 2 / inverse,), (0.0,), (0.1,))
        assert type(chosen(arm, [])[0]) is kind


def test_both_choices_find_the_same_motion() -> None:
    """What auto takes for a stiff arm agrees with the reference where the reference can be afforded."""
    model = model_of(Arm((3e6, 200.0), (20.0, 0.3), (1e-3, 0.1)))
    start: dict[str, Any] = {"q0": [0.0, 1.0], "v0": [0.3, 0.1]}
    auto = fd.simulate(model, [0.5, 0.2], 0.05, **start)
    reference = fd.simulate(model, [0.5, 0.2], 0.05, DormandPrince(), **start)
    assert isinstance(auto.solver, Rosenbrock)
    np.testing.assert_allclose(auto.q, reference.q, atol=1e-6)


def test_runge_kutta_refuses_dry_friction() -> None:
    """One line that names the effect and the way out; a neutral effect is no dry friction."""
    model = model_of(SOFT, [CoulombFriction(**LINK, level=1.0)])
    with pytest.raises(fd.InputError, match=r"coulomb_friction.*smoothing") as refused:
        fd.simulate(model, None, 0.1, RungeKutta4(step=1e-3))
    assert "\n" not in str(refused.value)
    neutral = model_of(SOFT, [CoulombFriction(**LINK, level=0.0)])
    assert fd.simulate(neutral, None, 0.01, RungeKutta4(step=1e-3)).stats["steps"] == 10


@pytest.mark.parametrize(
    "solver", [RungeKutta4(step=1e-3, smoothing=0.05), DormandPrince(smoothing=0.05), Rosenbrock(smoothing=0.05)]
)
def test_smoothing_is_said(solver: Solver) -> None:
    """A run with smoothed dry friction notes that it creeps; without dry friction there is nothing to note."""
    run = fd.simulate(model_of(SOFT, [CoulombFriction(**LINK, level=1.0)]), None, 0.01, solver)
    assert run.notes == ("dry friction is smoothed over 0.05 rad/s: a loaded joint creeps instead of sticking",)
    assert fd.simulate(model_of(SOFT), None, 0.01, solver).notes == ()


def test_a_solver_by_name() -> None:
    """Names give default settings, the run keeps them, and nothing has been chosen."""
    for name, solver in (("DormandPrince", DormandPrince()), ("TimeStepping", TimeStepping())):
        run = fd.simulate(model_of(SOFT), None, 0.01, name)
        assert (run.solver, run.notes) == (solver, ())


@pytest.mark.parametrize(
    ("solver", "said"),
    [
        ("DormandPrice", "DormandPrince"),
        ("RungeKutta4", "step"),
        (3, "DormandPrince"),
        (DormandPrince, "DormandPrince"),
    ],
)
def test_no_solver_is_refused_in_one_line(solver: Any, said: str) -> None:
    """A misspelt name, a name that needs a setting, a number, a class instead of its settings."""
    with pytest.raises(fd.InputError, match=said) as refused:
        fd.simulate(model_of(SOFT), None, 0.01, solver)
    assert "\n" not in str(refused.value)


def test_an_unreachable_start_is_left_to_the_solver() -> None:
    """At a first state so far out that slopes overflow there is still a choice, and the run says what happened."""
    with pytest.raises(fd.SimulationError, match="stopped at t = 0 s"):
        fd.simulate(model_of(SOFT), None, 0.01, q0=[0.0, math.pi / 2], v0=[1e200, 1e200])
