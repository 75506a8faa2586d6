"""Entries of model files that show how an effect is written."""

from __future__ import annotations

import dataclasses
from typing import Any

from flexdyn.effects import Effect, JointEffect


def example_entry(kind: type[Effect], joint: str, other: str = "OTHER_JOINT") -> dict[str, Any]:
    """An entry of a model file, to be copied.

    Args:
        kind: the effect's class.
        joint: name of the joint that it acts on.
        other: name of a second joint, if it needs one.
    """
    effect = kind.example(joint, other)
    if isinstance(effect, JointEffect):
        effect = dataclasses.replace(effect, side=kind.sides[-1])  # the motor's rather than the link's
    return effect.to_dict()
