"""A diagnosis as report.json holds it: the schema ``flexdyn.diagnosis/2`` of the contract, section 8."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn.diagnose.report.calibrated import estimate
from flexdyn.diagnose.report.measures import JointError, RecordingSpan, SignalError, Statistics
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import model_sentence, stopped_sentence
from flexdyn.diagnose.report.suspects import Considered, Finding, Number, Suspect

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
        "calibration": [
            {**vars(entry), "estimate": _number(estimate(diagnosis.model, entry))} for entry in diagnosis.calibration
        ],
        "gap": {"fit": _fields(diagnosis.gap_fit), "test": _fields(diagnosis.gap_test)},
        "errors": {joint: _error(entry) for joint, entry in diagnosis.errors.items()},
        "where": [_fields(entry) for entry in diagnosis.where],
        "left": [{**vars(entry), "depends_on": list(entry.depends_on)} for entry in diagnosis.left],
        "structures": [
            {**vars(each), "effects": [_suspect(own) for own in each.effects]} for each in diagnosis.structures
        ],
        "considered": [_considered(entry) for entry in diagnosis.considered[:CONSIDERED]],
        "data": [_source(entry) for entry in diagnosis.data],
        "notes": [*told, *diagnosis.notes],
        "seconds": diagnosis.seconds,
        "record": {**vars(diagnosis.record), "files": [_fields(entry) for entry in diagnosis.record.files]},
        "fit": None if diagnosis.fit is None else _statistics(diagnosis.fit),
        "shares": _fields(diagnosis.shares),
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


def _number(number: Number) -> dict[str, Any]:
    return {"value": number.value, "std": number.std, "interval": list(number.interval), "unit": number.unit}


def _suspect(entry: Suspect) -> dict[str, Any]:
    numbers = {name: _number(number) for name, number in entry.parameters.items()}
    return {"effect": entry.effect, "joint": entry.joint, "side": entry.side, **entry.place, "parameters": numbers}


def _considered(entry: Considered) -> dict[str, Any]:
    return {
        **_suspect(entry.suspect),
        "probability": entry.probability,
        "log_bayes_factor": entry.log_bayes_factor,
        "note": entry.note,
    }


def _fields(entry: object | None) -> dict[str, Any] | None:
    return None if entry is None else vars(entry).copy()


def _error(entry: JointError) -> dict[str, Any]:
    return {
        "torque": _signal(entry.torque),
        "position": _signal(entry.position),
        "force": None if entry.force is None else _signal(entry.force),
        "gap": dict(zip(("before", "calibrated", "after"), entry.gap, strict=True)) if entry.gap else None,
    }


def _signal(entry: SignalError) -> dict[str, Any]:
    found = {name: getattr(entry, name) for name in ("before", "calibrated", "after", "unit")}
    return found | ({"share_before": entry.share_before, "share_after": entry.share_after} if entry.size else {})


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
