"""Solver settings: frozen numbers above zero, by class or by name."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError
from typing import Any

import pytest

import flexdyn as fd
from flexdyn.simulation.solvers import SOLVERS, DormandPrince, Rosenbrock, RungeKutta4, TimeStepping, make_solver
from tests.arms import repickled


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        (RungeKutta4, {"step": 0.0}),
        (RungeKutta4, {"step": -1e-3}),
        (RungeKutta4, {"step": math.nan}),
        (RungeKutta4, {"step": math.inf}),
        (RungeKutta4, {"step": "1e-3"}),
        (RungeKutta4, {"step": None}),
        (RungeKutta4, {"step": True}),
        (RungeKutta4, {"step": 1e-3, "smoothing": 0.0}),
        (DormandPrince, {"rtol": 0.0}),
        (DormandPrince, {"rtol": -1e-8}),
        (DormandPrince, {"atol": math.inf}),
        (DormandPrince, {"max_step": 0.0}),
        (DormandPrince, {"smoothing": -1.0}),
        (Rosenbrock, {"rtol": 0.0}),
        (Rosenbrock, {"smoothing": 0.0}),
        (TimeStepping, {"step": 0.0}),
        (TimeStepping, {"step": math.inf}),
    ],
)
def test_a_setting_without_sense_is_refused(kind: type[fd.solvers.Solver], settings: dict[str, Any]) -> None:
    """One line that names the setting."""
    wrong = list(settings)[-1]
    with pytest.raises(fd.InputError, match=rf"^solver\.{wrong}: (a number above 0 is needed|it must be finite)"):
        kind(**settings)


def test_settings_are_frozen_values_that_pickle() -> None:
    """Equal settings are equal after a trip through pickle and through their own dictionary."""
    fixed = (RungeKutta4(step=1e-3, smoothing=0.01), RungeKutta4(step=1), TimeStepping(step=0.01))
    for solver in (*fixed, DormandPrince(rtol=1e-6, max_step=0.1), Rosenbrock(atol=1e-7, smoothing=1e-3)):
        assert repickled(solver) == solver
        entry = solver.to_dict()
        assert make_solver(entry.pop("name"), **entry) == solver
        with pytest.raises(FrozenInstanceError):
            solver.smoothing = 1.0  # type: ignore[misc, union-attr]


def test_solvers_by_name() -> None:
    """Every solver can be made by its name; None leaves a setting at its default."""
    assert make_solver("RungeKutta4", step=1e-3, rtol=None) == RungeKutta4(step=1e-3)
    assert make_solver("DormandPrince") == DormandPrince()
    assert make_solver("Rosenbrock", atol=1e-7) == Rosenbrock(atol=1e-7)
    assert make_solver("TimeStepping") == TimeStepping() == TimeStepping(step=1e-3)
    assert set(SOLVERS) == {"RungeKutta4", "DormandPrince", "Rosenbrock", "TimeStepping"}


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("RungeKuta4", {}, "solver: no such solver, got 'RungeKuta4'; did you mean 'RungeKutta4'?"),
        ("RungeKutta4", {}, "solver.step: RungeKutta4 needs a step"),
        ("RungeKutta4", {"step": 1e-3, "rtol": 1e-6}, "solver.rtol: RungeKutta4 has no such setting"),
        ("DormandPrince", {"step": 1e-3}, "solver.step: DormandPrince has no such setting"),
        (
            "TimeStepping",
            {"rtol": 1e-6},
            "solver.rtol: TimeStepping has no such setting, got 1e-06; TimeStepping takes step",
        ),
        ("Rosenbrok", {}, "solver: no such solver, got 'Rosenbrok'; did you mean 'Rosenbrock'?"),
    ],
)
def test_a_wrong_name_or_setting_is_one_line(name: str, settings: dict[str, float], words: str) -> None:
    """With the near miss, or with what there is."""
    with pytest.raises(fd.InputError) as caught:
        make_solver(name, **settings)
    assert str(caught.value).startswith(words)


def test_auto_says_what_it_chose() -> None:
    """The run carries the solver that ran and a sentence on the choice."""
    model = fd.load_model("scara_two_link")
    run = fd.simulate(model, None, 0.01)
    assert isinstance(run.solver, DormandPrince)
    (note,) = run.notes
    assert note.startswith("solver auto: DormandPrince, ")
    plain = model.replace(effects=[])
    assert fd.simulate(plain, None, 0.01, "DormandPrince").notes == ()


@pytest.mark.parametrize("kind", [DormandPrince, Rosenbrock])
def test_smoothing_is_told(kind: type[DormandPrince | Rosenbrock]) -> None:
    """Dry friction is exact unless smoothing is given; then a run says that a loaded joint creeps."""
    model = fd.load_model("scara_two_link")
    assert kind().smoothing is None
    assert fd.simulate(model, None, 0.01, kind()).notes == ()
    (note,) = fd.simulate(model, None, 0.01, kind(smoothing=1e-3)).notes
    assert note.startswith("dry friction is smoothed over 0.001 rad/s: a loaded joint creeps")
    assert fd.simulate(model.replace(effects=[]), None, 0.01, kind(smoothing=1e-3)).notes == ()


def test_dry_friction_needs_smoothing_at_a_fixed_step() -> None:
    """RungeKutta4 refuses a law that jumps, with the remedy; a neutral one is no law."""
    model = fd.load_model("scara_two_link")
    with pytest.raises(fd.InputError, match=r"the model has coulomb_friction; use DormandPrince, or give .* smoothing"):
        fd.simulate(model, None, 0.01, RungeKutta4(step=1e-3))
    run = fd.simulate(model, None, 0.01, RungeKutta4(step=1e-3, smoothing=0.05))
    assert "0.05 rad/s" in run.notes[0]
    neutral = model.replace(effects=[fd.effects.CoulombFriction("elbow", side="link", level=0.0)])
    assert fd.simulate(neutral, None, 0.01, RungeKutta4(step=1e-3)).notes == ()


@pytest.mark.parametrize("solver", [None, 3, DormandPrince, {"name": "RungeKutta4"}])
def test_something_else_is_no_solver(solver: Any) -> None:
    """What is no solver is refused with the remedy."""
    with pytest.raises(fd.InputError, match=r"a solver is needed.*fd\.solvers\.DormandPrince\(\)"):
        fd.simulate(fd.load_model("scara_two_link"), None, 0.01, solver)


def test_a_step_that_would_never_end_is_refused() -> None:
    """1e20 steps overflow any counter: a clear line and not one stride of a second."""
    model = fd.load_model("scara_two_link").replace(effects=[])
    with pytest.raises(fd.InputError, match=r"^solver\.step: more than 1e\+15 steps"):
        fd.simulate(model, None, 1.0, RungeKutta4(step=1e-20))
