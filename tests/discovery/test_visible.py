"""What is hidden shows in both recordings of a case, or the case is drawn again."""

from __future__ import annotations

import dataclasses

import cases
import numpy as np
import pytest
from hidden import Hidden
from plants import Case, true_plant
from two_link_run import controlled
from visible import make_filter, reported, surprises, visible

SHORT = 8.0, 4.0
STOP = {"stiffness": 500.0, "damping": 2.0}


@pytest.fixture(scope="module")
def case() -> Case:
    """An arm of which all is known."""
    return cases.make_case("none", 3, 0, *SHORT)


def with_stop(case: Case, beyond: tuple[float, float]) -> tuple[Case, Hidden]:
    """The case with a stop at the elbow, so far beyond what fit and check reach without one [rad]."""
    reach = max(float(run.y[:, 1].max()) for run in (case.fit, case.check))
    stop = Hidden("end_stop", 1, "link", {"lower": -9.0, "upper": reach + beyond[0], **STOP})
    plant = true_plant(case.arm, (stop,))
    runs = [controlled(plant, control) for control in case.controls]
    return dataclasses.replace(case, hidden=(stop,), plant=plant, fit=runs[0], check=runs[1]), stop


def test_a_stop_that_is_met_shows_and_one_that_is_not_does_not(case: Case) -> None:
    """By where the link went, the only thing that a stop asks for."""
    shown = []
    for beyond in (-0.3, 0.01):
        one, stop = with_stop(case, (beyond, beyond))
        met = [bool((run.y[:, 1] > stop.parameters["upper"]).any()) for run in (one.fit, one.check)]
        assert visible(one, stop) == all(met), beyond
        shown.append(any(met))
    assert shown == [True, False]


def test_the_true_law_surprises_nobody(case: Case) -> None:
    """The filter's coarse steps are off by less than noise, and at a stop, which it does not locate, by little."""
    white = surprises(case.fit, reported(case, case.fit), case.arm, (), make_filter(case))
    assert float((white**2).sum()) < 0.1
    one, _ = with_stop(case, (-0.3, -0.3))
    found, z = make_filter(one), reported(one, one.fit)
    known, less = (surprises(one.fit, z, one.arm, laws, found) for laws in (one.hidden, ()))
    assert float((known**2).sum()) < 1e-3 * float((less**2).sum())


def test_an_offset_surprises_by_its_size(case: Case) -> None:
    """The first error is the offset over the noise of one prediction, as the filter has seen nothing before."""
    offset = Hidden("sensor_offset", 1, None, {"offset": 1e-3}, {"channel": "q.elbow"})
    one, found = dataclasses.replace(case, hidden=(offset,)), make_filter(case)
    z = reported(one, one.fit)
    np.testing.assert_allclose(z[:, 1] - one.fit.y[:, 1], 1e-3, atol=1e-12)
    assert visible(one, offset)
    small = dataclasses.replace(offset, parameters={"offset": 1e-12})
    assert not visible(dataclasses.replace(case, hidden=(small,)), small)
    white = surprises(one.fit, z, one.arm, (offset,), found)
    assert float((white**2).sum()) < 1.0


def test_arms_of_rigid_joints_can_be_made() -> None:
    """The filter knows elastic arms alone."""
    made = [cases.make_case("rigid", 77, number, *SHORT) for number in range(4)]
    assert all(np.isinf(each.arm.stiffness).any() for each in made)
    assert all(each.hidden for each in made)
