"""The error of the first filter at corners of laws: nothing where laws are linear, or jump at a reversal.

That a gap is found with its right size is in `test_unknown_laws.py`.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.hypothesis.less_rounded import less_rounded, rounding
from flexdyn.effects import CoulombFriction, ViscousFriction
from tests.diagnose.slides import RATE, fitted, pushed

DAMPING = 1.5


@cache
def slid(level: float = 0.0) -> fd.Recording:
    """A mass on a slide with damping, and dry friction."""
    t = np.arange(round(12.0 * RATE)) / RATE

    def acting(asked: float, x: float, v: float) -> float:
        return asked - DAMPING * v - level * math.copysign(1.0, v)

    return pushed(t, 30.0 * np.sin(2.1 * t + 0.3) + 22.0 * np.sin(5.3 * t), acting)


def test_linear_laws_have_no_such_error(tmp_path: Path) -> None:
    """What noise and rounding make of it is far below the noise of the rows."""
    made = fitted(tmp_path, slid(), ViscousFriction("lift", side="motor", coefficient=DAMPING))
    rows = made.space.whiten(rounding(made))
    assert np.abs(rows).max() < 0.02


def test_rows_near_a_reversal_are_left_as_they_are(tmp_path: Path) -> None:
    """Dry friction jumps there: the wider filter sees more of the jump, which is no error of the narrow one."""
    dry = CoulombFriction("lift", side="motor", level=5.0)
    made = fitted(tmp_path, slid(5.0), dry, ViscousFriction("lift", side="motor", coefficient=DAMPING))
    rows = made.space.whiten(rounding(made))
    assert np.abs(rows).max() < 0.5
    assert less_rounded(made).hypothesis.effects[0].values == pytest.approx((5.0,), abs=0.02)
