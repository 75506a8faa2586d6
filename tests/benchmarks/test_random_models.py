"""Models drawn at random end, agree and are the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd

pytestmark = pytest.mark.filterwarnings("ignore::flexdyn.simulation.limits.LimitWarning")


def test_the_same_seed_gives_the_same_problem() -> None:
    """Models are equal in every number, and no two seeds give one."""
    from random_models import drawn

    one, again, other = drawn(3), drawn(3), drawn(4)
    assert one.model.effects == again.model.effects
    np.testing.assert_array_equal(one.start["q0"], again.start["q0"])
    np.testing.assert_array_equal(one.model.stiffness, again.model.stiffness)
    assert one.model.effects != other.model.effects


@pytest.mark.parametrize("seed", [5, 13, 21, 40])
def test_solvers_agree(seed: int) -> None:
    """DormandPrince, Rosenbrock and auto: to a thousandth of the motion; 40 starts with unloaded gears at rest."""
    from random_models import drawn
    from random_runs import apart

    problem = drawn(seed, duration=0.2)
    reference, implicit, auto = (problem.run(solver, rate=100.0) for solver in ("DormandPrince", "Rosenbrock", "auto"))
    assert apart(reference.q, implicit.q) < 1e-3
    assert apart(reference.q, auto.q) < 1e-3


@pytest.mark.parametrize("seed", [0, 2, 5])
def test_extreme_models_end_or_say_why(seed: int) -> None:
    """Within a small budget the error names a joint of the model and a solver; TimeStepping always ends."""
    from random_models import drawn

    problem = drawn(seed, extreme=True, duration=0.05)
    with pytest.raises(fd.SimulationError) as stopped:
        problem.run(fd.solvers.DormandPrince(max_steps=500))
    assert stopped.value.fastest.joint in problem.model.joint_names
    assert stopped.value.fastest.rate > 1e4
    assert "take " in stopped.value.remedy
    assert problem.run(fd.solvers.TimeStepping(step=1e-3)).t[-1] == pytest.approx(0.05)


@pytest.mark.parametrize(("seed", "extreme", "stiff"), [(5, False, False), (13, False, True), (2, True, True)])
def test_equal_steps_end_or_a_smaller_one_is_asked_for(seed: int, extreme: bool, stiff: bool) -> None:
    """RungeKutta4 with smoothed dry friction takes any of these models; a spring too stiff for its step is said."""
    from random_models import drawn
    from random_runs import EQUAL_STEPS

    problem = drawn(seed, extreme=extreme, duration=0.05)
    if stiff:
        with pytest.raises(fd.SimulationError, match="take a smaller step"):
            problem.run(EQUAL_STEPS)
    else:
        assert np.isfinite(problem.run(EQUAL_STEPS).q).all()
