"""One case: the truth, and what the code under test is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from arm_draw import TwoLinkArm
from hidden import Hidden, enter, true_arm
from layout import Array
from model_text import TOLERANCE
from outside import enter_outside
from recording import Sensors
from two_link_run import Control, Plant, Truth


@dataclass(frozen=True, eq=False)
class Case:
    """A case.

    Attributes:
        name: for its folder.
        hidden: what is to be found.
        arm: true, without the hidden effects that have a law.
        given: the arm as the model file has it.
        plant: true, hidden effects included.
        fit, check: what really happened.
        recordings: channels of fit and check.
        sensors: what was measured.
        controls: of fit and check.
        tolerance: of the numbers of the model file.
        wide: drawn from the wider ranges.
    """

    name: str
    hidden: tuple[Hidden, ...]
    arm: TwoLinkArm
    given: TwoLinkArm
    plant: Plant
    fit: Truth
    check: Truth
    recordings: dict[str, dict[str, Array]]
    sensors: Sensors
    controls: tuple[Control, Control]
    tolerance: float = TOLERANCE
    wide: bool = False


def true_plant(arm: TwoLinkArm, hidden: Sequence[Hidden]) -> Plant:
    """The plant with everything that is hidden."""
    for one in hidden:
        arm = true_arm(arm, one)
    plant = arm.plant()
    for one in hidden:
        (enter if one.catalogued else enter_outside)(plant.P, one)
    return plant
