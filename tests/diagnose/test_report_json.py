"""report.json as section 8 of the contract has it: every key, nothing else, strict JSON."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Set
from pathlib import Path
from typing import Any, get_args

import pytest

from flexdyn.diagnose.report.document import CONSIDERED
from flexdyn.diagnose.report.result import Diagnosis, Verdict
from flexdyn.diagnose.report.suspects import Number, Suspect
from tests.diagnose import report_cases as cases

NUMBER, NAME = (int, float, type(None)), (str, type(None))
GAP = {"before": NUMBER, "calibrated": NUMBER, "after": NUMBER, "floor": NUMBER}
PARAMETER = {"value": NUMBER, "std": NUMBER, "interval": list, "unit": str}
SUSPECT = {"effect": str, "joint": NAME, "side": NAME, "parameters": dict}
PLACE = {"channel", "of", "parameter", "other", "frame"}
DOCUMENT = {
    "schema": str,
    "verdict": str,
    "stopped_at": NAME,
    "findings": list,
    "calibration": list,
    "gap": dict,
    "errors": dict,
    "where": list,
    "left": list,
    "structures": list,
    "considered": list,
    "data": list,
    "notes": list,
    "seconds": NUMBER,
    "record": dict,
    "fit": (dict, type(None)),
    "shares": (dict, type(None)),
}
RECORD = {"version": str, "date": str, "command": str, "files": list}
FILE = {"path": str, "use": str, "bytes": int, "modified": str}
FIT = {"method": str, "points": int, "variables": int, "chi_square": NUMBER, "reduced": NUMBER, "aic": NUMBER}
FIT |= {"bic": NUMBER, "correlations": list}
SHARES = {"calibration": NUMBER, "findings": list, "left": NUMBER, "noise": NUMBER}
ENTRIES: dict[str, dict[str, Any]] = {
    "findings": SUSPECT | {"probability": NUMBER, "evidence": dict, "indistinguishable_from": list, "experiment": str},
    "calibration": {
        "of": str,
        "parameter": str,
        "factor": NUMBER,
        "std": NUMBER,
        "tolerance": NUMBER,
        "estimate": dict,
    },
    "where": {"joint": str, "side": str, "share": NUMBER, "regime": str},
    "left": {"joint": str, "share_of_torque": NUMBER, "correlation_time": NUMBER, "depends_on": list},
    "structures": {"effects": list, "probability": NUMBER, "log_evidence": NUMBER},
    "considered": SUSPECT | {"probability": NUMBER, "log_bayes_factor": NUMBER, "note": str},
    "data": {
        "file": str,
        "role": str,
        "from": NUMBER,
        "to": NUMBER,
        "rate": NUMBER,
        "noise": dict,
        "samples": int,
        "channels": list,
    },
}
ERROR = {
    "torque": {
        "before": NUMBER,
        "calibrated": NUMBER,
        "after": NUMBER,
        "unit": str,
        "share_before": NUMBER,
        "share_after": NUMBER,
    },
    "position": {"before": NUMBER, "calibrated": NUMBER, "after": NUMBER, "unit": str},
}


@pytest.mark.parametrize("made", [*cases.CASES, cases.robot])
def test_the_json_is_what_the_contract_says(made: Callable[[], Diagnosis], tmp_path: Path) -> None:
    """Every key of the contract with its type and no other; JSON by the letter, in which unknown numbers are null."""
    made().save(tmp_path)
    text = (tmp_path / "report.json").read_text(encoding="utf-8")
    document = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert document["schema"] == "flexdyn.diagnosis/2"
    assert document["verdict"] in get_args(Verdict)
    _is(document, DOCUMENT)
    assert list(document["gap"]) == ["fit", "test"]
    for gap in document["gap"].values():
        assert gap is None or _is(gap, GAP)
    for entry in document["errors"].values():
        _is(entry, {"torque": dict, "position": dict, "force": (dict, type(None)), "gap": (dict, type(None))})
        for name, kinds in ERROR.items():
            _is(entry[name], kinds)
    for key, kinds in ENTRIES.items():
        for entry in document[key]:
            _is(entry, kinds, PLACE)
    for finding in document["findings"]:
        _is(finding["evidence"], {"log_bayes_factor": NUMBER, "test_gain": NUMBER})
        for rival in finding["indistinguishable_from"]:
            _is(rival, SUSPECT | {"probability": NUMBER}, PLACE)
    for suspect in _suspects(document):
        for number in suspect["parameters"].values():
            _is(number, PARAMETER)
            assert len(number["interval"]) == 2
    assert {entry["role"] for entry in document["data"]} <= {"fit", "test"}
    _is(document["record"], RECORD)
    assert all(_is(entry, FILE) for entry in document["record"]["files"])
    for key, kinds in (("fit", FIT), ("shares", SHARES)):
        assert document[key] is None or _is(document[key], kinds)


def test_the_json_tells_where_a_sensor_and_a_payload_are() -> None:
    """A payload has neither joint nor side; a sensor effect names its channel, a wrong number whose it is."""
    stribeck, payload, wrong, offset = cases.explained().to_dict()["findings"]
    excess = stribeck["parameters"]["excess"]
    assert (excess["value"], excess["std"], excess["unit"]) == (1.2, 0.05, "N m")
    assert excess["interval"] == pytest.approx([1.102, 1.298])
    assert stribeck["probability"] == 0.996, "of all its names together"
    rivals = [(rival["effect"], rival["probability"]) for rival in stribeck["indistinguishable_from"]]
    assert rivals == [("presliding_friction", 0.21), ("spring_hysteresis", 0.076)]
    assert (payload["joint"], payload["side"], payload["frame"]) == (None, None, "tip")
    assert (wrong["of"], wrong["parameter"]) == ("shoulder", "stiffness")
    assert (offset["channel"], offset["side"]) == ("q.elbow", "sensor")


def test_at_most_forty_candidates_are_written() -> None:
    """The most probable ones; the result itself keeps all."""
    entry = cases.compared()[0]
    many = dataclasses.replace(cases.no_discrepancy(), considered=(entry,) * 50)
    assert len(many.to_dict()["considered"]) == CONSIDERED == 40


def test_what_did_not_converge_and_a_missing_model_are_in_the_notes() -> None:
    """A program that reads report.json knows which estimates stopped, and that model.yaml is not there."""
    stopped, missing = cases.not_converged().to_dict()["notes"]
    assert stopped == "These estimates stopped before they had converged: stiffness of elbow and damping of elbow."
    assert "model.yaml was not written" in missing


def test_an_interval_holds_95_percent_of_a_normal_distribution() -> None:
    """Two-sided; nothing is known of a number whose standard deviation is not."""
    assert Number(2.0, 0.5, "N m").interval == pytest.approx((1.02, 2.98))
    assert Number(2.0, 0.0, "1").interval == (2.0, 2.0)
    assert all(math.isnan(end) for end in Number(2.0, math.nan, "1").interval)


def test_one_effect_at_one_place_is_one_key() -> None:
    """Whatever its numbers and its probability are; the place counts, in whatever order it was written."""
    place = {"of": "elbow", "parameter": "stiffness"}
    one = Suspect("parameter_error", "elbow", None, {"factor": Number(1.1, 0.1, "1")}, place, 0.4)
    other = Suspect("parameter_error", "elbow", None, {}, dict(reversed(place.items())))
    assert one.key == other.key
    assert one.key != dataclasses.replace(one, place={**place, "parameter": "damping"}).key


def _is(entry: dict[str, Any], kinds: dict[str, Any], optional: Set[str] = frozenset()) -> bool:
    """Exactly these keys, but for optional ones, each of its type."""
    assert set(entry) - optional <= set(kinds) <= set(entry), set(entry) ^ set(kinds)
    for key, kind in kinds.items():
        assert isinstance(entry[key], kind), (key, entry[key])
        assert not isinstance(entry[key], bool)
    return True


def _suspects(document: dict[str, Any]) -> list[dict[str, Any]]:
    found = [*document["findings"], *document["considered"]]
    found += [rival for finding in document["findings"] for rival in finding["indistinguishable_from"]]
    return found + [effect for structure in document["structures"] for effect in structure["effects"]]
