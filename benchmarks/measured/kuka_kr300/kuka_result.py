"""What the KUKA's study gives: torques, told numbers, and what the difference of the encoders is made of."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from kuka_encoders import Account, Difference, Ripple

import flexdyn as fd

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from along import Inverse


@dataclass(frozen=True, eq=False)
class Study:
    """All that the page shows.

    Attributes:
        references: errors of plain least squares by law and record.
        diagnosis: of the rigid model.
        before: the published model along every record.
        after: the corrected one.
        bare: the published one without friction and offsets, along records B and C.
        told: what record A says of the model's numbers.
        differences: theta - q of axes 1 to 3 by record.
        accounts: what it is made of.
        ripples: sines over position in it.
    """

    references: dict[str, dict[str, float]]
    diagnosis: fd.Diagnosis
    before: dict[str, Inverse]
    after: dict[str, Inverse]
    bare: dict[str, Inverse]
    told: fd.BaseParameters
    differences: list[dict[str, Difference]]
    accounts: list[Account]
    ripples: list[Ripple]
