"""Effects of a corrected model: which one belongs to a candidate, and which ones a model can hold."""

from __future__ import annotations

import dataclasses

from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.effects import Effect, JointEffect


def without_effect(here: Hypothesis, effect: Effect | None) -> Hypothesis:
    """A hypothesis without one of its effects, and without what needs that."""
    return dataclasses.replace(here, effects=possible(here, [each for each in here.effects if each is not effect]))


def with_elasticity(here: Hypothesis, effects: list[Effect]) -> tuple[Effect, ...]:
    """Effects, and the elasticity of each joint whose friction takes the load."""
    loaded = {each.joint for each in effects if isinstance(each, JointEffect) and each.takes_load}
    soft = [each for each in here.effects if each.makes_elastic and getattr(each, "joint", "") in loaded]
    return (*effects, *(each for each in soft if each not in effects))


def possible(here: Hypothesis, effects: list[Effect]) -> tuple[Effect, ...]:
    """Effects that the model can hold: friction that takes the load needs an elastic joint."""
    soft = {getattr(each, "joint", "") for each in effects if each.makes_elastic}
    true = here.given.resolved()
    soft |= {name for name, elastic in zip(true.joint_names, true.elastic, strict=True) if elastic}
    return tuple(each for each in effects if not each.takes_load or getattr(each, "joint", "") in soft)
