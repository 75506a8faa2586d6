"""A joint that the model file takes for rigid, end to end, shortened."""

from __future__ import annotations

from pathlib import Path

import pytest
from score import outcome

from tests.discovery.shortened import diagnosed


@pytest.mark.slow
def test_an_elasticity_is_named_alone_and_its_stiffness_is_right(tmp_path: Path) -> None:
    """At its joint, on an arm of which the model says that no joint is elastic, to 2 percent."""
    found, truth = diagnosed("rigid", 3, 18, tmp_path)
    assert truth["hidden"][0]["effect"] == "joint_elasticity"
    assert outcome(truth, found) == "right", (found["findings"], truth["hidden"])
    stiffness = found["findings"][0]["parameters"]["stiffness"]["value"]
    assert stiffness == pytest.approx(truth["hidden"][0]["parameters"]["stiffness"], rel=0.02)
