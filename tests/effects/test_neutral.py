"""A neutral effect changes nothing, bit for bit."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import Effect, ViscousFriction
from tests.effects.arms import ELASTIC, RIGID, catalogue_examples, model_of, states

OTHERS: list[Effect] = [ViscousFriction("elbow", side="link", coefficient=0.1)]
START: dict[str, Any] = {"q0": [-0.4, 0.7], "v0": [0.6, -0.5]}


@pytest.mark.parametrize("solver", ["DormandPrince", "RungeKutta4"])
@pytest.mark.parametrize("effect", catalogue_examples(), ids=lambda effect: effect.name)
def test_a_neutral_effect_changes_nothing(effect: Any, solver: str) -> None:
    """Neither the run nor its statistics nor what the sensors report."""
    settings = {} if solver == "DormandPrince" else {"step": 1e-3}
    neutral = dataclasses.replace(effect, **effect.neutral)
    arm = RIGID if effect.name == "joint_elasticity" else ELASTIC
    one, two = (
        fd.simulate(
            model_of(arm, effects), [0.3, 0.1], 0.2, fd.solvers.make_solver(solver, **settings), rate=200, **START
        )
        for effects in (OTHERS, [neutral, *OTHERS])
    )
    np.testing.assert_array_equal(states(one), states(two))
    for signal in ("tau", "tau_applied", "tau_s"):
        np.testing.assert_array_equal(getattr(one, signal), getattr(two, signal))
    assert dict(one.stats) == dict(two.stats)
    assert one.to_recording().same_as(two.to_recording())


@pytest.mark.parametrize("effect", catalogue_examples(), ids=lambda effect: effect.name)
def test_an_example_changes_something(effect: Any) -> None:
    """The same effect with its example's numbers moves the arm otherwise, or is measured otherwise."""
    if effect.name in ("backlash", "torque_speed_limit", "end_stop"):  # only where the motion gets there
        numbers = {"backlash": {}, "torque_speed_limit": {"stall_torque": 0.2}, "end_stop": {"lower": 0.0}}
        effect = dataclasses.replace(effect, **numbers[effect.name])
    arm = RIGID if effect.name == "joint_elasticity" else ELASTIC
    one, two = (
        fd.simulate(model_of(arm, effects), [0.3, 0.1], 0.2, fd.solvers.DormandPrince(), rate=200, **START)
        for effects in ([], [effect])
    )
    assert not one.to_recording().same_as(two.to_recording())
