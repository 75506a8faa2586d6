"""The Panda of the benchmark: what friction holds does not move, and what slides has its whole level against it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from panda_truth import MIDDLE, STEP, Friction, _step, true_arm

from flexdyn.robot.names import find_robot

LEVEL = np.array([1.2, 1.5, 0.9, 1.1, 0.5, 0.4, 0.35])
NONE = np.zeros(7)
DRY = Friction(LEVEL, NONE, NONE, np.ones(7), np.ones(7), NONE)


@pytest.fixture(scope="module")
def arm() -> pin.Model:
    """As published."""
    return true_arm(find_robot("panda")[0], np.random.default_rng(0), 0.0)


def test_friction_holds(arm: pin.Model) -> None:
    """Nine tenths of every level beside gravity move nothing."""
    data = arm.createData()
    weight = pin.computeGeneralizedGravity(arm, data, MIDDLE).copy()
    state = MIDDLE.copy(), np.zeros(7), np.zeros(7)
    for _ in range(200):
        state = _step(arm, data, DRY, state, weight + 0.9 * LEVEL, np.abs(weight))
    assert np.abs(state[0] - MIDDLE).max() < 1e-12
    assert state[2] == pytest.approx(0.9 * LEVEL * STEP, rel=1e-6)


def test_what_slides_has_its_level_against_it(arm: pin.Model) -> None:
    """One joint is pushed beyond its level: its impulse is the level, the others hold what reaches them."""
    data = arm.createData()
    weight = pin.computeGeneralizedGravity(arm, data, MIDDLE).copy()
    push = np.where(np.arange(7) == 4, 2.0 * LEVEL, 0.0)
    state = MIDDLE.copy(), np.zeros(7), np.zeros(7)
    for _ in range(20):
        state = _step(arm, data, DRY, state, weight + push, np.abs(weight))
    assert state[1][4] > 0.0
    assert state[2][4] == pytest.approx(LEVEL[4] * STEP, rel=1e-9)
    assert (np.abs(state[2]) <= LEVEL * STEP * (1.0 + 1e-9)).all()
