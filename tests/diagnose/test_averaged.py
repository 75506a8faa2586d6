"""Intervals of a finding's numbers, where it is not certain which other effects are there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexdyn.diagnose.decision.averaged import Shifts
from flexdyn.diagnose.decision.run import diagnose
from tests.diagnose.slides import model, recording

DRAWS = 40_000
LEVEL, VISCOUS = 5.0, 0.01
"""Friction of a slide [N, N s/m]: what the second one makes is not enough to be named after three seconds."""
SHIFT = st.floats(-10.0, 10.0)


@given(st.lists(st.tuples(SHIFT, st.floats(0.01, 1.0)), min_size=1, max_size=5), st.floats(0.1, 3.0))
def test_an_interval_holds_95_percent_of_a_mixture(parts: list[tuple[float, float]], std: float) -> None:
    """Counted in draws from it; and it is never narrower than that of the fit."""
    shift, weight = np.array(parts).T
    probability = weight / weight.sum()
    wide = Shifts(shift, probability).widened(std)
    draw = np.random.default_rng(0)
    seen = draw.choice(shift, DRAWS, p=probability) + std * draw.standard_normal(DRAWS)
    inside = float((np.abs(seen) <= 1.96 * wide).mean())
    assert wide >= std
    assert inside == pytest.approx(0.95, abs=0.006) or (wide == std and inside >= 0.944)


def test_structures_that_agree_add_nothing() -> None:
    """Neither does a shift that has hardly any probability, nor is an unknown number known by it."""
    assert Shifts(np.zeros(2), np.array([0.4, 0.6])).widened(0.3) == 0.3
    assert Shifts(np.array([0.0, 50.0]), np.array([0.999, 0.001])).widened(0.3) == pytest.approx(0.3, rel=0.01)
    assert math.isnan(Shifts(np.array([1.0]), np.array([1.0])).widened(math.nan))


def test_the_interval_of_a_level_allows_for_friction_without_a_name(tmp_path: Path) -> None:
    """Dry friction takes over what viscous friction does that has no name: many of the fit's own errors."""
    answer = diagnose(model(tmp_path), [recording(lambda v: math.copysign(LEVEL, v) + VISCOUS * v, seconds=3.0)])
    (finding,) = answer.findings
    assert finding.suspect.effect == "coulomb_friction"
    level = finding.suspect.parameters["level"]
    off, alone = abs(level.value - LEVEL), 0.02 / math.sqrt(3.0 * 500.0)  # of the recorded force's noise
    assert 50.0 * alone < off < 2.5 * level.std
