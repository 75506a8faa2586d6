"""Scoring of cases that lack many effects at once: recall, false names, "A or B", what is allowed."""

from __future__ import annotations

from typing import Any

import pytest
from many import tally
from overview import summary, tables
from score import outcome, score

from tests.discovery.test_score import report


def effect(name: str, joint: str = "elbow", side: str = "motor", **more: Any) -> dict[str, Any]:
    """A hidden effect or a finding."""
    return {"effect": name, "joint": joint, "side": side, "parameters": {}, "catalogued": True, **more}


VISCOUS = effect("viscous_friction", matters=True)
COULOMB = effect("coulomb_friction", matters=True)
STRIBECK = effect("stribeck_friction", matters=False)
ELASTIC = effect("joint_elasticity", side="transmission")
TRUTH = {
    "case": "published_1_000",
    "family": "published",
    "rigid_model": True,
    "hidden": [VISCOUS, COULOMB, STRIBECK],
    "allowed": [ELASTIC],
}
BACKLASH = effect("backlash", side="transmission")


@pytest.mark.parametrize(
    ("findings", "found", "false", "expected"),
    [
        ([VISCOUS, COULOMB], 2.0, 0, "right"),
        ([VISCOUS, COULOMB, STRIBECK, ELASTIC], 2.0, 0, "right"),
        ([{**VISCOUS, "side": "link"}, COULOMB], 2.0, 0, "right"),
        ([VISCOUS], 1.0, 0, "missed"),
        ([VISCOUS, COULOMB, BACKLASH], 2.0, 1, "beside"),
        ([VISCOUS, {**COULOMB, "joint": "shoulder"}], 1.0, 1, "wrong"),
        ([VISCOUS, {**BACKLASH, "indistinguishable_from": [COULOMB]}], 1.5, 0, "half"),
        ([{**VISCOUS, "indistinguishable_from": [{**VISCOUS, "side": "link"}]}, COULOMB], 2.0, 0, "right"),
        ([], 0.0, 0, "missed"),
    ],
)
def test_what_matters_is_counted_and_what_is_neither_true_nor_allowed(
    findings: list[dict[str, Any]], found: float, false: int, expected: str
) -> None:
    """The side of a rigid joint does not matter; an "A or B" counts half unless both names are true."""
    counted = tally(TRUTH, report(*findings))
    assert (counted.wanted, counted.found, len(counted.false)) == (2, found, false)
    assert outcome(TRUTH, report(*findings)) == expected


def test_an_offset_beside_coulomb_friction_is_asymmetric_friction() -> None:
    """The same law under two names is true; one of them alone is not."""
    asymmetric = {**TRUTH, "hidden": [VISCOUS, effect("asymmetric_friction", matters=True)]}
    coulomb, offset = effect("coulomb_friction"), effect("torque_offset")
    assert tally(asymmetric, report(VISCOUS, coulomb, offset)).outcome == "right"
    assert tally(asymmetric, report(VISCOUS, coulomb)).outcome == "wrong"


def test_a_coupling_must_name_the_other_joint() -> None:
    """Of six joints the wrong one may be said to drag."""
    truth = {**TRUTH, "hidden": [effect("joint_coupling", matters=True, other="shoulder")]}
    for other, found in (("shoulder", 1.0), ("wrist", 0.0)):
        finding = effect("joint_coupling", parameters={"other": {"value": other}})
        assert tally(truth, report(finding)).found == found


def test_the_summary_pools_effects_and_names() -> None:
    """Recall over all effects that matter, false names over all names; points of a case are its own recall."""
    rows = [score(TRUTH, report(VISCOUS, COULOMB, BACKLASH)), score(TRUTH, report(VISCOUS)), score(TRUTH, None)]
    assert [row["points"] for row in rows] == [1.0, 0.5, 0.0]
    numbers = summary(rows)["published"]
    assert numbers["recall"] == pytest.approx(3 / 6)
    assert numbers["false_rate"] == pytest.approx(1 / 4)
    assert "backlash elbow transmission" in tables(rows)
