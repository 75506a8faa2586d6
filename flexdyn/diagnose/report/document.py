"""A diagnosis as report.json holds it: the schema ``flexdyn.diagnosis/2`` of the contract, section 8."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flexdyn.diagnose.report.calibrated import estimate
from flexdyn.diagnose.report.measures import JointError, SignalError, Statistics
from flexdyn.diagnose.report.origin import RecordingSpan
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.sentences import model_sentence, stopped_sentence
from flexdyn.diagnose.report.suspects import Considered, Finding, Number, Suspect
from flexdyn.io.locked import thawed

SCHEMA = "flexdyn.diagnosis/2"
CONSIDERED = 40
"""So many of the candidates that were compared are written, the most probable first."""


def document(diagnosis: Diagnosis) -> dict[str, Any]:
    """The document; numbers in it may be infinite or NaN, which become null in the file."""
    told = [text for text in (stopped_sentence(diagnosis), model_sentence(diagnosis)) if text]
    return {
        "schema": SCHEMA,
        "verdict": diagnosis.verdict,
        "stopped_at": diagnosis.stopped_at or None,
        "findings": [_finding_entry(entry) for entry in diagnosis.findings],
        "calibration": [
            {**vars(e), "estimate": _number_entry(estimate(diagnosis.model, e))} for e in diagnosis.calibration
        ],
        "gap": {"fit": _fields(diagnosis.gap_fit), "test": _fields(diagnosis.gap_test)},
        "errors": {joint: _error_entry(entry) for joint, entry in diagnosis.errors.items()},
        "where": [_fields(entry) for entry in diagnosis.where],
        "left": [_fields(entry) for entry in diagnosis.left],
        "structures": [{**vars(each), "effects": [*map(_suspect, each.effects)]} for each in diagnosis.structures],
        "considered": [_considered_entry(entry) for entry in diagnosis.considered[:CONSIDERED]],
        "data": [_span_entry(entry) for entry in diagnosis.data],
        "notes": [*told, *diagnosis.notes],
        "seconds": diagnosis.seconds,
        "record": _fields(diagnosis.record),
        "fit": _statistics(diagnosis.fit) if diagnosis.fit else None,
        "shares": _fields(diagnosis.shares),
    }


def _fields(entry: Any) -> dict[str, Any] | None:
    """A dataclass as mappings and lists."""
    return None if entry is None else thawed(asdict(entry))


def _span_entry(entry: RecordingSpan) -> dict[str, Any]:
    whole = thawed(asdict(entry))
    return {"from": whole.pop("start"), "to": whole.pop("end"), **whole}


def _finding_entry(entry: Finding) -> dict[str, Any]:
    return {
        **_suspect(entry.suspect),
        "probability": entry.probability,
        "evidence": {"log_bayes_factor": entry.log_bayes_factor, "test_gain": entry.test_gain},
        "indistinguishable_from": [{**_suspect(rival), "probability": rival.probability} for rival in entry.rivals],
        "experiment": entry.experiment,
    }


def _considered_entry(entry: Considered) -> dict[str, Any]:
    return _suspect(entry.suspect) | {key: value for key, value in vars(entry).items() if key != "suspect"}


def _number_entry(number: Number) -> dict[str, Any]:
    return {"value": number.value, "std": number.std, "interval": list(number.interval), "unit": number.unit}


def _suspect(entry: Suspect) -> dict[str, Any]:
    numbers = {name: _number_entry(number) for name, number in entry.parameters.items()}
    return {"effect": entry.effect, "joint": entry.joint, "side": entry.side, **entry.place, "parameters": numbers}


def _error_entry(entry: JointError) -> dict[str, Any]:
    signals = {name: _signal_entry(getattr(entry, name)) for name in ("torque", "position", "force")}
    return {**signals, "gap": dict(zip(("before", "calibrated", "after"), entry.gap, strict=False)) or None}


def _statistics(entry: Statistics) -> dict[str, Any]:
    return {**vars(entry), "correlations": [{"of": pair, "value": value} for *pair, value in entry.correlations]}


def _signal_entry(entry: SignalError | None) -> dict[str, Any] | None:
    if entry is None:
        return None
    shares = ("share_before", "share_after") if entry.size else ()
    return {name: getattr(entry, name) for name in ("before", "calibrated", "after", "unit", *shares)}
