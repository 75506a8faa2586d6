"""One of several models that are compared: its numbers with their uncertainty, its effects with their probability."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexdyn.diagnose.report.calibrated import FACTOR, given_number
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Number
from flexdyn.diagnose.report.words import effect_name, number_phrase, place_phrase
from flexdyn.effects import ParameterError
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.model.uncertain_parameters import file_numbers

Given = Diagnosis | FlexibleJointModel | str | os.PathLike[str]
REPORT, MODEL = "report.json", "model.yaml"


@dataclass(frozen=True)
class ComparedModel:
    """One of the models.

    Attributes:
        label: its name in the tables.
        joints: names of its joints, which identify the arm.
        numbers: by what they are of, in words.
        effects: probability of each by what it is and where, in words; 1 where the file gives it.
        absent: probability of effects that were compared and are not in the model.
    """

    label: str
    joints: tuple[str, ...]
    numbers: Mapping[str, Number]
    effects: Mapping[str, float]
    absent: Mapping[str, float]


def compared_model(given: Given, label: str) -> ComparedModel:
    """A model, a diagnosis, or the file or folder of either.

    Args:
        given: a model file, a folder that a diagnosis was saved in, or what they hold. With a report.json beside it,
            a model.yaml that a diagnosis wrote has the standard deviations of that diagnosis.
        label: its name in the tables.

    Raises:
        InputError: there is no such file or folder, or it holds no model or report.
    """
    if isinstance(given, Diagnosis):
        return _of_report(given.model, given.to_dict(), label)
    if isinstance(given, FlexibleJointModel):
        return _of_model(given, label)
    try:
        path = Path(given)
    except TypeError:
        remedy = "give model files, folders of diagnoses, models or diagnoses"
        raise InputError("no model and no diagnosis", key="models", value=given, remedy=remedy) from None
    folder = path if path.is_dir() else path.parent
    report = folder / REPORT
    if path.is_dir() and not (folder / MODEL).exists():
        remedy = f"a folder of a diagnosis with {MODEL} is needed; it is not written where it would be a worse model"
        raise InputError("the folder holds no corrected model", file=path, key=MODEL, remedy=remedy)
    model = load_model(folder / MODEL if path.is_dir() else path)
    if (path.is_dir() or path.name == MODEL) and report.exists():
        return _of_report(model, _read(report), label)
    return _of_model(model, label)


def _read(report: Path) -> dict[str, Any]:
    try:
        content = json.loads(report.read_text(encoding="utf-8"))
        found = dict(content)
        known = str(found["schema"]).startswith("flexdyn.diagnosis/")
    except (ValueError, KeyError, TypeError):
        known, found = False, {}
    if not known:
        remedy = "flexdyn diagnose writes one"
        raise InputError("it is no report of a diagnosis", file=report, key="schema", remedy=remedy)
    return found


def _of_model(model: FlexibleJointModel, label: str) -> ComparedModel:
    """A model without a report: its tolerances are the uncertainties of its numbers."""
    relative = {number_phrase(model, n.of, n.parameter): n.tolerance for n in file_numbers(model)}
    return ComparedModel(label, tuple(model.joint_names), _numbers(model, relative, {}), _acting(model), {})


def _of_report(model: FlexibleJointModel, report: Mapping[str, Any], label: str) -> ComparedModel:
    """A corrected model with the uncertainties and probabilities in the report of its diagnosis."""
    relative, factors = {}, {}
    for entry in report["calibration"]:
        phrase = number_phrase(model, entry["of"], entry["parameter"])
        factors[phrase] = _float(entry["factor"])
        relative[phrase] = _float(entry["std"]) / max(abs(factors[phrase]), 1e-300)
    named: dict[str, float] = {}
    for finding in report["findings"]:
        where = _told(finding)
        for parameter, number in finding["parameters"].items():
            phrase = f"{parameter.replace('_', ' ')} of {where}"
            if finding["effect"] == ParameterError.name:
                phrase = number_phrase(model, finding["of"], finding["parameter"])
            value, std = _float(number["value"]), _float(number["std"])
            factors[phrase], relative[phrase] = value, std / max(abs(value), 1e-300)
        named[where] = _float(finding["probability"])
    effects = {where: named.get(where, certain) for where, certain in _acting(model).items()}
    compared = {_told(each): _float(each["probability"]) for each in report["considered"]}
    absent = {where: p for where, p in compared.items() if where not in effects}
    return ComparedModel(label, tuple(model.joint_names), _numbers(model, relative, factors), effects, absent)


def _numbers(
    model: FlexibleJointModel, relative: Mapping[str, float], factors: Mapping[str, float]
) -> dict[str, Number]:
    """Of the model as it is true; those of links as factors on their URDF, which holds the number."""
    true, found = model.resolved(), {}
    for number in file_numbers(true):
        phrase = number_phrase(true, number.of, number.parameter)
        value, unit = given_number(true, number.of, number.parameter)
        value = factors.get(phrase, value) if unit == FACTOR else value
        found[phrase] = Number(value, relative.get(phrase, number.tolerance) * abs(value), unit)
    return found


def _acting(model: FlexibleJointModel) -> dict[str, float]:
    """Effects of the arm or its sensors, but no wrong numbers of the file; each has the probability 1."""
    acting = (each.to_dict() for each in model.effects if not each.is_neutral and not each.in_numbers)
    return {_told(each): 1.0 for each in acting}


def _told(entry: Mapping[str, Any]) -> str:
    """An effect and where it acts, in the words of `number_phrase`: of a model file's entry, or of a report's."""
    if "channel" in entry:
        return f"{effect_name(entry['effect'])} on channel {entry['channel']}"
    where = place_phrase(entry["joint"], entry.get("side")) if entry.get("joint") else ""
    return f"{effect_name(entry['effect'])} {where}".strip()


def _float(value: Any) -> float:
    """A number of a report; null is none."""
    return math.nan if value is None else float(value)
