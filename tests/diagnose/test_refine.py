"""Numbers fitted to simulated windows end where SciPy finds the least robust sum of squares."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from flexdyn.diagnose import refine as module
from flexdyn.diagnose import slopes
from flexdyn.diagnose.gap import Shot, shoot
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.measured import measured
from flexdyn.diagnose.numbers import file_numbers
from flexdyn.diagnose.refine import refine
from flexdyn.diagnose.run import window_noise
from flexdyn.diagnose.slopes import ROBUST, Slopes, slopes_of
from flexdyn.diagnose.windows import Windows
from flexdyn.diagnose.workspace import workspace
from tests.arms import two_link
from tests.diagnose.test_estimate import HANGING, swinging

Array = NDArray[np.float64]


def problem() -> tuple[Hypothesis, Windows]:
    """The hanging arm under a model whose shoulder is too soft and whose elbow's rotor is too light, by 0.2 %."""
    model = two_link(HANGING)
    noise = workspace(model, (measured(model, swinging()),))[2]
    wanted = {("shoulder", "stiffness"): 0.998, ("elbow", "rotor_inertia"): 0.998}
    numbers = {
        n: wanted[str(n.joint), n.parameter] for n in file_numbers(model) if (str(n.joint), n.parameter) in wanted
    }
    assert len(numbers) == 2
    return Hypothesis(model, numbers), Windows.of(model, [swinging()], window_noise(noise))


def cost(start: Hypothesis, windows: Windows, factors: Array) -> float:
    """Cauchy's sum of squares of the windows' surprises, and the priors."""
    there = dataclasses.replace(start, factors=dict(zip(start.factors, factors.tolist(), strict=True)))
    white = shoot(there.seen(), windows).whitened()
    prior = sum(((f - 1.0) / n.tolerance) ** 2 for n, f in there.factors.items())
    return float((ROBUST**2 * np.log1p((white / ROBUST) ** 2)).sum() + prior)


@cache
def least() -> OptimizeResult:
    """SciPy's."""
    start, windows = problem()
    first = [[1.0, 1.0], [1.0005, 1.0], [1.0, 1.0005]]
    options = {"initial_simplex": first, "fatol": 0.05, "xatol": 1e-6}
    return minimize(lambda x: cost(start, windows, x), np.ones(2), method="Nelder-Mead", options=options)


@pytest.mark.parametrize("anew", [0.0, math.inf])
def test_the_least_sum_of_squares_is_found(anew: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """From where it is much larger; slopes that are taken once come to the same place."""
    start, windows = problem()
    asked = []

    def counted(*arguments: Any) -> Slopes:
        asked.append(1)
        return slopes_of(*arguments)

    monkeypatch.setattr(module, "slopes_of", counted)
    made = refine(start, windows, anew=anew)
    found = least()
    assert cost(start, windows, np.full(2, 0.998)) > 1.5 * found.fun
    assert made.cost == pytest.approx(found.fun, abs=2.0)  # names are told apart by ten
    off = np.array(list(made.hypothesis.factors.values())) - found.x
    assert (np.abs(off) < 1.5 * made.std).all()
    assert (len(asked) == 1) == (anew > 0.0)
    assert (np.abs(np.array(list(made.hypothesis.factors.values())) - 1.0) < 4.0 * made.std).all()


@pytest.mark.parametrize(("far", "simulated"), [(0.02, False), (0.04, True)])
def test_slopes_of_another_fit_come_to_the_same_place(
    far: float, simulated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it stands near; where a number is another one by more than 3 %, they are taken anew."""
    start, windows = problem()
    there = dataclasses.replace(start, factors=dict.fromkeys(start.factors, 1.0 + far))
    like = refine(there, windows, rounds=1)
    assert like.slopes is not None
    asked, slope = [], slopes._slope

    def counted(*arguments: Any) -> Array:
        asked.append(1)
        return slope(*arguments)

    monkeypatch.setattr(slopes, "_slope", counted)
    made = refine(start, windows, anew=math.inf, like=like)
    assert bool(asked) == simulated
    assert made.cost == pytest.approx(least().fun, abs=2.0)
    assert like.cost > made.cost + 10.0


def test_a_few_windows_that_tell_all_are_not_trusted_beyond_their_noise() -> None:
    """One of twenty windows holds the number, and is met by chance: the number is no better known than its rows say."""
    J = np.zeros((20 * 50, 1))
    J[:50] = 2.0
    shot: Any = SimpleNamespace(whitened=lambda: np.zeros((20, 50)))
    one = Slopes(J, np.ones(len(J)), np.zeros(1), (3.0,), {})
    assert one.std(shot) == pytest.approx([3.0 / np.linalg.norm(J)])


def test_a_step_that_is_not_worth_its_time_is_promised_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it would have brought, near enough, without a simulation of it; a step that is worth more is made."""
    start, windows = problem()
    best = refine(start, windows)
    assert best.promised == 0.0
    off = {n: f + 4.0 * std for (n, f), std in zip(best.hypothesis.factors.items(), best.std.tolist(), strict=True)}
    there, tried = dataclasses.replace(start, factors=off), []

    def noted(*_: Any) -> Iterator[tuple[Hypothesis, Shot]]:
        tried.append(1)
        return iter(())

    monkeypatch.setattr(module, "_trials", noted)
    asked = refine(there, windows, worth=0.5)
    assert not tried
    assert asked.hypothesis == there
    assert asked.cost > best.cost + 10.0
    assert asked.promised == pytest.approx(asked.cost - best.cost, rel=0.2)
    refine(there, windows, worth=0.5 * asked.promised / asked.cost)
    assert tried
