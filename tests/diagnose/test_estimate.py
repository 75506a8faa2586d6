"""Fits end where the sum of squares is least, by SciPy's least squares over the same rows and priors."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

import flexdyn as fd
from flexdyn.diagnose.constants import LEAST_DESCENT
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.estimate import _after_share, _begun, fit
from flexdyn.diagnose.hypothesis.exact_descent import descended
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, moved
from flexdyn.diagnose.hypothesis.linear import OUT_OF_TOLERANCE_WIDTH, linearised, reached
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.errors import SimulationError
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, Levels
from tests.diagnose.workspaces import workspace
from tests.oracles.integrate import held

Array = NDArray[np.float64]
LEVELS, SECONDS, RATE = Levels(2e-7, 3e-3), 6.0, 1000.0
HANGING = dataclasses.replace(ARM, gravity=9.81)


@cache
def swinging() -> fd.Recording:
    """The arm hanging in the vertical plane, pushed by its motors, as its encoders saw it."""
    t = np.arange(round(SECONDS * RATE)) / RATE
    tau = np.stack([3.0 * np.sin(5.1 * t + 0.5) + np.sin(13.0 * t), np.sin(6.7 * t) + 0.5 * np.sin(17.0 * t)], axis=1)
    rows = iter(tau.tolist())
    states, _ = held(HANGING.derivative, [-1.4, 0.3, -1.4, 0.3, 0, 0, 0, 0], t, lambda _t, _x: next(rows))
    draw, step = np.random.default_rng(0), np.sqrt(12.0) * LEVELS.position
    channels = {}
    for j, joint in enumerate(JOINTS):
        channels[f"q.{joint}"], channels[f"theta.{joint}"] = (step * np.round(states[:, k] / step) for k in (j, 2 + j))
        channels[f"tau.{joint}"] = tau[:, j] + LEVELS.torque * draw.standard_normal(len(tau))
    return fd.Recording(t, channels)


def problem(*errors: fd.effects.ParameterError) -> tuple[Workspace, Hypothesis]:
    """The arm's motion under a model with wrong numbers."""
    model = two_link(HANGING, errors)
    space, start, _ = workspace(model, (measured(model, swinging()),))
    return space, start


def least(space: Workspace, start: Hypothesis) -> float:
    """The least sum of squares of white rows and priors that SciPy finds over the numbers of the file."""
    numbers = list(start.factors)
    sigma = np.array([OUT_OF_TOLERANCE_WIDTH if n in start.freed else n.tolerance for n in numbers])

    def rows(x: Array) -> Array:
        factors = dict(zip(numbers, x.tolist(), strict=False))
        at = space.equations.of(dataclasses.replace(start, factors=factors).model())
        counts = x[len(numbers) :]
        white = space.whiten(at.residual) + space.nuisance @ counts
        return np.concatenate([white, (x[: len(numbers)] - 1.0) / sigma, counts / space.nuisance_sigma])

    first = np.concatenate([np.ones(len(numbers)), np.zeros(space.nuisance.shape[1])])
    scale = np.concatenate([np.full(len(numbers), 0.01), space.nuisance_sigma])
    return 2.0 * float(least_squares(rows, first, x_scale=scale, xtol=1e-12, ftol=1e-12, gtol=1e-12).cost)


@pytest.mark.parametrize("factor", [0.6, 1.5])
def test_a_link_far_off_is_fitted_along_its_valley(factor: float) -> None:
    """Its mass, place and inertia multiply one another: what the data tells of them is a curve, and its foot is far."""
    space, start = problem(fd.effects.ParameterError("link2", parameter="link_com", factor=factor))
    free = frozenset(n for n in start.factors if (n.of, n.parameter) == ("link2", "link_com"))
    start = dataclasses.replace(start, freed=free)
    made = fit(start, space)
    assert made.chi2 < least(space, start) + 1.0
    (number,) = free
    assert abs(made.hypothesis.factors[number] - 1.0 / factor) < 3.0 * made.factor_std()[number]


def test_a_mass_that_would_be_negative_is_none_at_all() -> None:
    """The other numbers are then at their best without it."""
    space, start = problem(fd.effects.ParameterError("link2", parameter="link_mass", factor=1.1))
    laden = dataclasses.replace(start, effects=(fd.effects.Payload(mass=0.05, frame="tool"),))
    made, without = fit(laden, space), fit(start, space)
    assert made.hypothesis.effects[0].values == pytest.approx((0.0,), abs=1e-12)
    assert made.chi2 == pytest.approx(without.chi2, abs=0.2)


def test_an_unknown_at_its_bound_is_as_well_known_as_one_away_from_it() -> None:
    """A mass of zero that could only be a negative one has the spread of a mass that is there."""
    spread = []
    for factor in (1.1, 0.9):
        space, start = problem(fd.effects.ParameterError("link2", parameter="link_mass", factor=factor))
        made = fit(dataclasses.replace(start, effects=(fd.effects.Payload(mass=0.05, frame="tool"),)), space)
        spread.append(made.std()[made.hypothesis.effects[0], "mass"])
    assert spread[0] == pytest.approx(spread[1], rel=0.5)


def test_a_spring_beyond_all_bounds_is_an_error_and_a_step_to_it_is_not_made() -> None:
    """Not a number does not travel on: a fit refuses the step, a hypothesis that begins there is refused."""
    space, start = problem()
    wild = fd.effects.HardeningSpring("shoulder", cubic=1e306)
    with pytest.raises(SimulationError, match="not finite"):
        linearised(dataclasses.replace(start, effects=(wild,)), space)

    tame = linearised(dataclasses.replace(start, effects=(fd.effects.HardeningSpring("shoulder", cubic=50.0),)), space)
    cubic = len(start.factors)
    assert tame.step[cubic] * tame.scales[0] != 0.0
    beyond = 1e306 / abs(tame.step[cubic] * tame.scales[0])
    assert _after_share(dataclasses.replace(tame, scales=(beyond * tame.scales[0],)), 1.0, math.inf) is None
    one = _after_share(tame, 1.0, math.inf)
    assert one is not None
    assert one.reached < tame.reached


@pytest.mark.parametrize("right", [True, False])
def test_a_fit_begins_with_numbers_bent_only_where_data_speaks_for_them(right: bool) -> None:
    """A stiffness a third off that the arm does have, or that a missing effect had bent; both fits end at the truth."""
    space, start = problem(
        *(fd.effects.ParameterError("elbow", parameter="stiffness", factor=1.4) for _ in range(right))
    )
    (number,) = (n for n in start.factors if (n.of, n.parameter) == ("elbow", "stiffness"))
    bent = dataclasses.replace(start, factors={**start.factors, number: 1.0 / 1.4})
    assert _begun(bent, space).hypothesis.factors == (bent if right else bent.tolerated()).factors
    assert fit(bent, space).hypothesis.factors[number] == pytest.approx(1.0 / 1.4 if right else 1.0, rel=1e-3)


def test_a_fit_whose_slopes_lead_up_goes_down_along_differences() -> None:
    """Slopes of the file's numbers with the wrong sign: Gauss-Newton stays, differences find the least squares."""
    space, start = problem(fd.effects.ParameterError("link2", parameter="link_com", factor=1.03))
    stalled = fit(start, dataclasses.replace(space, bare=dataclasses.replace(space.bare, numbers=-space.bare.numbers)))
    made, lowest = descended(stalled), least(space, start)
    assert stalled.reached > 100.0 * lowest
    assert made.stationary
    assert made.reached < lowest + 2.0 * LEAST_DESCENT


def test_what_is_left_at_a_place_is_known_without_its_slopes() -> None:
    """The same sum of squares as the whole problem there has, priors and free encoder counts included."""
    space, start = problem()
    there = moved(start, 1e-2 * np.ones(len(start.factors)), ())
    at = space.equations.of(there.model())
    assert reached(there, at, space) == pytest.approx(linearised(there, space).reached, rel=1e-9)
    assert reached(there, at, space) != pytest.approx(linearised(start, space).reached, rel=1e-3)


def test_slopes_of_the_files_numbers_are_taken_anew_where_a_sensor_has_moved_far() -> None:
    """An encoder whose error moved by a hundredth keeps them, one that moved by half does not."""
    space, start = problem()

    def with_gain(gain: float) -> Hypothesis:
        return dataclasses.replace(start, effects=(fd.effects.SensorGain("q.shoulder", gain=gain),))

    first, many = linearised(with_gain(0.02), space), len(start.factors)
    near, far = (linearised(with_gain(gain), space, first) for gain in (0.0202, 0.03))
    assert np.array_equal(near.regression.X[:, :many], first.regression.X[:, :many])
    assert not np.array_equal(far.regression.X[:, :many], first.regression.X[:, :many])
    assert np.array_equal(far.regression.X, linearised(with_gain(0.03), space).regression.X)
    # What was taken once is measured from where it was taken, not from one small step to the next.
    after = linearised(with_gain(0.0204), space, near)
    assert after.taken is first.hypothesis


def test_slopes_of_links_numbers_are_those_of_where_they_stand() -> None:
    """A forearm a fifth heavier, which nobody set free: mass and inertia multiply its centre of mass."""
    space, start = problem()
    (number,) = (n for n in start.factors if (n.of, n.parameter) == ("link2", "link_com"))
    there = dataclasses.replace(start, factors={**start.factors, number: 1.2})
    sides = []
    for step in (1e-3, -1e-3):
        moved_ = dataclasses.replace(there, factors={**there.factors, number: 1.2 + step})
        sides.append(space.whiten(space.equations.of(moved_.model()).residual))
    slope = (sides[0] - sides[1]) / 2e-3
    column = linearised(there, space).regression.X[:, list(start.factors).index(number)]
    assert np.linalg.norm(column - slope) < 0.01 * np.linalg.norm(slope)
    assert np.linalg.norm(space.numbers[:, list(start.factors).index(number)] - slope) > 0.1 * np.linalg.norm(slope)


def test_a_coupling_that_is_proposed_has_no_dry_friction() -> None:
    """Its level is no candidate: two couplings of the same motors with levels would be no model."""
    model = fd.load_model("scara_two_link")
    effects = tuple(
        fd.effects.JointCoupling(one, other=other, coefficient=0.1)
        for one, other in (("shoulder", "elbow"), ("elbow", "shoulder"))
    )
    here = Hypothesis(model, {}, effects=effects)
    assert [name for _, name in here.unknowns()] == ["coefficient", "coefficient"]
