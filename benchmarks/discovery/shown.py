"""Whether anything that an arm does can show that a number of its links is wrong.

All that links do to the joints goes through the few numbers of `TwoLinkArm.links`. Where the other numbers, each within
its tolerance, make those few what they truly are, no recording of any length tells the wrong number from a right one.
"""

from __future__ import annotations

import numpy as np
from arm_draw import TwoLinkArm
from layout import Array
from model_text import TOLERANCE
from score import INSEPARABLE

NUMBERS = (("mass", 0), ("mass", 1), ("com", 0), ("com", 1), ("inertia", 0), ("inertia", 1), ("tool", 0))
STEP, ROUNDS = 1e-4, 8


def shown(true: TwoLinkArm, given: TwoLinkArm, wrong: tuple[str, int], tolerance: float = TOLERANCE) -> bool:
    """Whether the least that others must bend, to make up for the wrong number, is more than inseparable laws differ.

    Args:
        true: arm.
        given: as it is written down.
        wrong: the number that is out of tolerance, and whose.
        tolerance: of all numbers.
    """
    logs = np.array([np.log(_number(true, *each) / _number(given, *each)) for each in NUMBERS])
    goal, bent = _seen(true), np.zeros(len(NUMBERS))
    for _ in range(ROUNDS):  # the least change that does it, each time to first order around the last one
        here = _bent(given, tolerance * bent)
        columns = [(_seen(_bent(here, STEP * axis)) - _seen(here)) / STEP for axis in np.eye(len(NUMBERS))]
        J = tolerance * np.stack(columns, axis=1)
        bent = np.linalg.pinv(J) @ (goal - _seen(here) + J @ bent)
    others = np.array([each != wrong for each in NUMBERS])
    return bool(bent @ bent - ((logs / tolerance)[others] ** 2).sum() > INSEPARABLE)


def _seen(arm: TwoLinkArm) -> Array:
    """What the joints see of the links; lying down, no weights."""
    return arm.links()[: 5 if arm.vertical else 3]


def _number(arm: TwoLinkArm, name: str, j: int) -> float:
    value = getattr(arm, name)
    return float(value if name == "tool" else value[j])


def _bent(arm: TwoLinkArm, logs: Array) -> TwoLinkArm:
    """The arm with its numbers times exp(logs) (numbers,)."""
    factors = np.exp(logs)
    changed: dict[str, object] = {"tool": float(arm.tool * factors[-1])}
    for k, name in enumerate(("mass", "com", "inertia")):
        changed[name] = tuple((np.array(getattr(arm, name)) * factors[2 * k : 2 * k + 2]).tolist())
    return arm.replace(**changed)
