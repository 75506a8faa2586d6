"""A diagnosis as report.json holds it: the schema ``flexdyn.diagnosis/2`` of the contract, section 8."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn.diagnose.report.calibrated import estimate
from flexdyn.diagnose.report.measures import Calibration, Gap, JointError, RecordingSpan
from flexdyn.diagnose.report.record import Statistics
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import model_sentence, stopped_sentence
from flexdyn.diagnose.report.suspects import Considered, Finding, Number, Structure, Suspect

SCHEMA = "flexdyn.diagnosis/2"
CONSIDERED = 40
"""So many of the candidates that were compared are written, the most probable first."""


def document(diagnosis: Diagnosis) -> dict[str, Any]:
    """The document; numbers in it may be infinite or NaN, see `report_json`."""
    told = [text for text in (stopped_sentence(diagnosis), model_sentence(diagnosis)) if text]
    return {
        "schema": SCHEMA,
        "verdict": diagnosis.verdict,
        "stopped_at": diagnosis.stopped_at or None,
        "findings": [_finding(entry) for entry in diagnosis.findings],
        "calibration": [_calibrated(diagnosis, entry) for entry in diagnosis.calibration],
        "gap": {"fit": _gap(diagnosis.gap_fit), "test": _gap(diagnosis.gap_test)},
        "errors": {joint: _error(entry) for joint, entry in diagnosis.errors.items()},
        "where": [vars(entry).copy() for entry in diagnosis.where],
        "left": [{**vars(entry), "depends_on": list(entry.depends_on)} for entry in diagnosis.left],
        "structures": [_structure(entry) for entry in diagnosis.structures],
        "considered": [_considered(entry) for entry in diagnosis.considered[:CONSIDERED]],
        "data": [_source(entry) for entry in diagnosis.data],
        "notes": [*told, *diagnosis.notes],
        "seconds": diagnosis.seconds,
        "record": {**vars(diagnosis.record), "files": [vars(entry).copy() for entry in diagnosis.record.files]},
        "fit": None if diagnosis.fit is None else _statistics(diagnosis.fit),
        "shares": None if diagnosis.shares is None else vars(diagnosis.shares).copy(),
    }


def report_json(diagnosis: Diagnosis) -> str:
    """Text of report.json: strict JSON, in which a number that is not finite is null."""
    return json.dumps(_strict(document(diagnosis)), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _finding(entry: Finding) -> dict[str, Any]:
    return {
        **_suspect(entry.suspect),
        "probability": entry.probability,
        "evidence": {"log_bayes_factor": entry.log_bayes_factor, "test_gain": entry.test_gain},
        "indistinguishable_from": [{**_suspect(rival), "probability": rival.probability} for rival in entry.rivals],
        "experiment": entry.experiment,
    }


def _calibrated(diagnosis: Diagnosis, entry: Calibration) -> dict[str, Any]:
    return {**vars(entry), "estimate": _number(estimate(diagnosis.model, entry))}


def _number(number: Number) -> dict[str, Any]:
    return {"value": number.value, "std": number.std, "interval": list(number.interval), "unit": number.unit}


def _suspect(entry: Suspect) -> dict[str, Any]:
    numbers = {name: _number(number) for name, number in entry.parameters.items()}
    return {"effect": entry.effect, "joint": entry.joint, "side": entry.side, **entry.place, "parameters": numbers}


def _structure(entry: Structure) -> dict[str, Any]:
    return {
        "effects": [_suspect(each) for each in entry.effects],
        "probability": entry.probability,
        "log_evidence": entry.log_evidence,
    }


def _considered(entry: Considered) -> dict[str, Any]:
    return {
        **_suspect(entry.suspect),
        "probability": entry.probability,
        "log_bayes_factor": entry.log_bayes_factor,
        "note": entry.note,
    }


def _gap(gap: Gap | None) -> dict[str, float] | None:
    return None if gap is None else vars(gap).copy()


def _error(entry: JointError) -> dict[str, Any]:
    return {
        "torque": {
            "before": entry.torque_before,
            "calibrated": entry.torque_calibrated,
            "after": entry.torque_after,
            "unit": entry.torque_unit,
            "share_before": entry.torque_share_before,
            "share_after": entry.torque_share_after,
        },
        "position": {
            "before": entry.position_before,
            "calibrated": entry.position_calibrated,
            "after": entry.position_after,
            "unit": entry.position_unit,
        },
        "force": _force(entry),
        "gap": dict(zip(("before", "calibrated", "after"), entry.gap, strict=True)) if entry.gap else None,
    }


def _force(entry: JointError) -> dict[str, Any] | None:
    """Error of the force of a prescribed motion."""
    if not entry.force:
        return None
    before, calibrated, after, size = entry.force
    share = {"share_before": before / size, "share_after": after / size} if size > 0.0 else {}
    return {"before": before, "calibrated": calibrated, "after": after, "unit": entry.torque_unit, **share}


def _source(entry: RecordingSpan) -> dict[str, Any]:
    return {
        "file": entry.file,
        "role": entry.role,
        "from": entry.start,
        "to": entry.end,
        "rate": entry.rate,
        "samples": entry.samples,
        "channels": list(entry.channels),
        "noise": dict(entry.noise),
    }


def _statistics(entry: Statistics) -> dict[str, Any]:
    pairs = [{"of": [one, other], "value": value} for one, other, value in entry.correlations]
    return {**vars(entry), "correlations": pairs}


def _strict(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _strict(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_strict(entry) for entry in value]
    if isinstance(value, np.generic):
        return _strict(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
