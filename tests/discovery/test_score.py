"""The scoring of the hidden-effect benchmark: what counts as right, half, wrong, missed and forced."""

from __future__ import annotations

from typing import Any

import pytest
from names import parameter_errors
from score import outcome, score

HIDDEN = {
    "effect": "stribeck_friction",
    "joint": "elbow",
    "side": "motor",
    "parameters": {"excess": 1.0, "velocity": 0.05},
    "catalogued": True,
}
RIGHT = {
    "effect": "stribeck_friction",
    "joint": "elbow",
    "side": "motor",
    "parameters": {"excess": {"value": 1.1, "std": 0.06}, "velocity": {"value": 0.06, "std": 0.001}},
    "probability": 0.97,
    "indistinguishable_from": [],
}
OTHER = {**RIGHT, "effect": "presliding_friction", "parameters": {}, "probability": 0.6}


def truth(*hidden: dict[str, Any]) -> dict[str, Any]:
    """A truth file."""
    return {"case": "x", "family": "single", "hidden": list(hidden)}


def report(*findings: dict[str, Any], verdict: str = "explained") -> dict[str, Any]:
    """A report."""
    gap = {"before": 9.0, "after": 1.1, "floor": 1.0}
    return {"verdict": verdict, "findings": list(findings), "gap": {"fit": gap, "test": gap}, "seconds": 3.0}


@pytest.mark.parametrize(
    ("findings", "expected"),
    [
        ([RIGHT], "right"),
        ([{**RIGHT, "indistinguishable_from": [OTHER]}], "half"),
        ([{**OTHER, "indistinguishable_from": [RIGHT]}], "half"),
        ([RIGHT, OTHER], "beside"),
        ([OTHER], "wrong"),
        ([{**RIGHT, "side": "link"}], "wrong"),
        ([], "missed"),
    ],
)
def test_names_are_worth_what_they_say(findings: list[dict[str, Any]], expected: str) -> None:
    """Effect, joint and side must agree, alone; "A or B" with the truth in it is half."""
    assert outcome(truth(HIDDEN), report(*findings)) == expected


def test_nothing_hidden_and_effects_outside_the_catalogue_want_no_name() -> None:
    """A name for nothing is wrong; a name for what no name fits is forced; saying so is right."""
    unknown = {**HIDDEN, "effect": "fan", "catalogued": False}
    assert outcome(truth(), report(verdict="no_discrepancy")) == "right"
    assert outcome(truth(), report(RIGHT)) == "wrong"
    assert outcome(truth(unknown), report(RIGHT)) == "forced"
    for verdict, expected in (
        ("unexplained", "right"),
        ("partly_explained", "right"),
        ("explained", "forced"),
        ("no_discrepancy", "missed"),
        ("not_converged", "missed"),
        ("interrupted", "missed"),
    ):
        assert outcome(truth(unknown), report(verdict=verdict)) == expected, verdict
    assert outcome(truth(HIDDEN), None) == "failed"


def test_half_is_whole_where_no_data_could_tell() -> None:
    """An honest "A or B" between laws that the truth says are inseparable counts in full."""
    either = report({**RIGHT, "indistinguishable_from": [OTHER]})
    assert score(truth(HIDDEN), either)["points"] == 0.5
    assert score(truth(HIDDEN), either, {"delta_bic": 12.0})["points"] == 1.0
    assert score(truth(HIDDEN), either, {"delta_bic": 30.0})["points"] == 0.5


def test_rows_hold_the_gap_on_test_data_and_what_findings_claim() -> None:
    """Reports of schema 1, which said check, are read as well; a claim about what is outside the catalogue is false."""
    row = score(truth(HIDDEN), report(RIGHT, OTHER))
    assert row["gap"]["test"] == pytest.approx(1.1)
    assert [(claim["probability"], claim["true"]) for claim in row["claims"]] == [(0.97, True), (0.6, False)]
    first = report(RIGHT)
    first["gap"] = {"check": {"before": 9.0, "after": 2.2, "floor": 2.0}}
    assert score(truth(HIDDEN), first)["gap"]["test"] == pytest.approx(1.1)
    unknown = {**HIDDEN, "catalogued": False}
    assert not score(truth(unknown), report(RIGHT))["claims"][0]["true"]


def test_intervals_and_signs_of_parameters() -> None:
    """An interval of 1.96 standard deviations covers or not; -a sin(x) is a sin(x + pi)."""
    rows = {row["parameter"]: row for row in parameter_errors(RIGHT, HIDDEN)}
    assert rows["excess"]["covered"] is True
    assert rows["velocity"]["covered"] is False
    assert rows["velocity"]["relative_error"] == pytest.approx(0.2)
    ripple = {**HIDDEN, "parameters": {"amplitude": 2.0, "harmonic": 3.0, "phase": 3.0}}
    parameters = {"amplitude": -2.0, "harmonic": 3.0, "phase": 3.0 - 3.14159265}
    turned = parameter_errors({**RIGHT, "parameters": parameters}, ripple)
    assert all(row["relative_error"] < 1e-6 for row in turned)
