"""What the solvers promise: order 4 at a fixed step, a tolerance that is honoured, output that changes nothing."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from tests.arms import BENT, EXACT, state, two_link
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05), gravity=9.81)
SPAN = 1.5
BETWEEN = np.sort(np.random.default_rng(0).uniform(0.0, SPAN, 40))
COMMAND = fd.Samples([0.0, 0.4, 0.9, SPAN], [[1.0, -0.5], [-2.0, 0.8], [0.5, 0.5], [0.0, 0.0]], "cubic")


def motion(solver: fd.solvers.Solver, times: Array) -> Array:
    """States of the driven arm."""
    return state(fd.simulate(two_link(ARM), COMMAND, SPAN, solver, times=times, **BENT))


def test_runge_kutta_converges_at_order_4() -> None:
    """The error at the end, and between the steps too, falls with the fourth power of the step."""
    times = np.append(BETWEEN, SPAN)
    exact = motion(EXACT, times)
    steps = [SPAN / count for count in (150, 300, 600, 1200)]
    errors = [np.abs(motion(fd.solvers.RungeKutta4(step=step), times) - exact) for step in steps]
    for part in (slice(-1, None), slice(0, -1)):
        slope = np.polyfit(np.log(steps), np.log([error[part].max() for error in errors]), 1)[0]
        assert slope == pytest.approx(4.0, abs=0.2)


def test_steps_end_on_the_switches_of_the_command() -> None:
    """Order 4 also where held torques jump at times that no step would hit by itself."""
    held = fd.Samples([0.0, 0.3331, 0.7777, SPAN], [[3.0, -2.0], [-4.0, 2.0], [2.0, 1.0], [0.0, 0.0]])
    model = two_link(ARM)
    ends = [
        state(fd.simulate(model, held, SPAN, solver, **BENT))[-1]
        for solver in (EXACT, *(fd.solvers.RungeKutta4(step=SPAN / count) for count in (150, 300, 600)))
    ]
    errors = [np.abs(end - ends[0]).max() for end in ends[1:]]
    for coarse, fine in itertools.pairwise(errors):
        assert coarse / fine == pytest.approx(16.0, rel=0.3)


def test_dormand_prince_honours_its_tolerance() -> None:
    """The error falls with rtol and stays within 100 times it, at the end and in the dense output."""
    times = np.append(BETWEEN, SPAN)
    exact = motion(fd.solvers.DormandPrince(rtol=1e-13, atol=1e-14), times)
    size = np.abs(exact).max()
    errors = []
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        solver = fd.solvers.DormandPrince(rtol=rtol, atol=rtol)
        errors.append(np.abs(motion(solver, times) - exact).max() / size)
        assert errors[-1] < 100 * rtol
    for coarse, fine in itertools.pairwise(errors):
        assert fine < 0.05 * coarse


def test_dormand_prince_takes_more_steps_for_more_digits() -> None:
    """Its work grows about as rtol^(-1/5), as that of a method of order 5 does."""
    model = two_link(ARM)
    steps = [
        fd.simulate(model, COMMAND, SPAN, fd.solvers.DormandPrince(rtol=rtol, atol=rtol), **BENT).stats["steps"]
        for rtol in (1e-5, 1e-10)
    ]
    assert 5 < steps[1] / steps[0] < 20


@pytest.mark.parametrize(
    "solver", [fd.solvers.DormandPrince(), fd.solvers.DormandPrince(max_step=0.01), fd.solvers.RungeKutta4(step=1e-3)]
)
def test_samples_change_nothing_in_the_integration(solver: fd.solvers.Solver) -> None:
    """Whatever the rate or times, the last state is the same bit for bit, and so are the steps taken."""
    model = two_link(ARM, [fd.effects.ViscousFriction("elbow", side="link", coefficient=0.2)])
    grids: list[dict[str, object]] = [{"rate": 1000.0}, {"rate": 7.0}, {"times": BETWEEN}, {"times": [0.0, SPAN]}]
    runs = [fd.simulate(model, COMMAND, SPAN, solver, **grid, **BENT) for grid in grids]  # type: ignore[arg-type]
    for run in runs:
        assert run.stats["steps"] == runs[0].stats["steps"]
        assert run.stats["rejected"] == runs[0].stats["rejected"]
        if run.t[-1] == SPAN:
            np.testing.assert_array_equal(state(run)[-1], state(runs[0])[-1])
    np.testing.assert_array_equal(state(runs[0])[0], state(runs[3])[0])


def test_the_longest_step_is_kept_to() -> None:
    """An arm at rest could be crossed in one stride; max_step forbids it."""
    rest = two_link(TwoLink())
    free = fd.simulate(rest, None, 1.0, fd.solvers.DormandPrince())
    bound = fd.simulate(rest, None, 1.0, fd.solvers.DormandPrince(max_step=0.01))
    assert free.stats["steps"] < 30
    assert bound.stats["steps"] >= 100


def test_dense_output_is_smooth() -> None:
    """Between the steps v is the slope of q, to the accuracy of fourth order."""
    times = np.linspace(0.2, 1.2, 20001)
    solver = fd.solvers.DormandPrince(rtol=1e-9, atol=1e-11)
    run = fd.simulate(two_link(ARM), COMMAND, SPAN, solver, times=times, **BENT)
    slope = np.gradient(run.q, times, axis=0, edge_order=2)
    np.testing.assert_allclose(slope[1:-1], run.v[1:-1], atol=2e-6)
