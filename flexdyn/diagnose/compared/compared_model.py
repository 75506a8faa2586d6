"""One of several models that are compared: its numbers with their uncertainty, its effects with their probability."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexdyn.diagnose.compared.report_file import read_report
from flexdyn.diagnose.report.calibrated import FACTOR, number_as_given
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Number
from flexdyn.diagnose.report.words import effect_name, names_number, number_phrase, place_phrase
from flexdyn.diagnose.report.write import MODEL
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import load_model
from flexdyn.model.uncertain_parameters import file_numbers

Given = Diagnosis | FlexibleJointModel | str | os.PathLike[str]
REPORT = "report.json"


@dataclass(frozen=True)
class ComparedModel:
    """One of the models.

    Attributes:
        label: its name in the tables.
        joints: names of its joints, which identify the arm.
        numbers: by what they are of, in words.
        effects: what each is and where, in words.
        probability: of these, 1 where the file gives it, and of others that were compared.
    """

    label: str
    joints: tuple[str, ...]
    numbers: Mapping[str, Number]
    effects: tuple[str, ...]
    probability: Mapping[str, float]


def compared_model(given: Given, label: str) -> ComparedModel:
    """A model, a diagnosis, or the file or folder of either.

    Args:
        given: a model file, a folder that a diagnosis was saved in, or what they hold. With a report.json beside it,
            a model.yaml that a diagnosis wrote has the standard deviations of that diagnosis.
        label: its name in the tables.

    Raises:
        InputError: there is no such file or folder, or it holds no model, or a report that is not read.
    """
    if isinstance(given, Diagnosis):
        return _with_report(given.model, given.to_dict(), label)
    if isinstance(given, FlexibleJointModel):
        return _with_report(given, {}, label)
    try:
        path = Path(given)
    except TypeError:
        remedy = "give model files, folders of diagnoses, models or diagnoses"
        raise InputError("no model and no diagnosis", key="models", value=given, remedy=remedy) from None
    file = path / MODEL if path.is_dir() else path
    if path.is_dir() and not file.exists():
        remedy = f"a folder of a diagnosis with {MODEL} is needed; it is not written where it would be a worse model"
        raise InputError("the folder holds no corrected model", file=path, key=MODEL, remedy=remedy)
    model, report = load_model(file), file.with_name(REPORT)
    return _with_report(model, read_report(report) if file.name == MODEL and report.exists() else {}, label)


def _with_report(model: FlexibleJointModel, report: Mapping[str, Any], label: str) -> ComparedModel:
    """A model with the uncertainties and probabilities in the report of its diagnosis, else with its tolerances."""
    relative = {number_phrase(model, n.of, n.parameter): n.tolerance for n in file_numbers(model)}
    factors = {}
    # Effects of the arm or its sensors, but no wrong numbers of the file.
    there = (each.to_dict() for each in model.effects if not each.is_neutral and not each.in_numbers)
    acting = tuple(dict.fromkeys(map(_told, there)))
    probability = {_told(each): _float(each["probability"]) for each in report.get("considered", ())}
    probability |= dict.fromkeys(acting, 1.0)
    for entry in report.get("calibration", ()):
        phrase = number_phrase(model, entry["of"], entry["parameter"])
        factors[phrase] = _float(entry["factor"])
        relative[phrase] = _float(entry["std"]) / max(abs(factors[phrase]), 1e-300)
    for finding in report.get("findings", ()):
        where = _told(finding)
        for parameter, number in finding["parameters"].items():
            phrase = f"{parameter.replace('_', ' ')} of {where}"
            if names_number(finding["effect"]):
                phrase = number_phrase(model, finding["of"], finding["parameter"])
            value, std = _float(number["value"]), _float(number["std"])
            factors[phrase], relative[phrase] = value, std / max(abs(value), 1e-300)
        if where in acting:
            probability[where] = _float(finding["probability"])
    numbers = _numbers_of_model(model.resolved(), relative, factors)
    return ComparedModel(label, tuple(model.joint_names), numbers, acting, probability)


def _numbers_of_model(
    true: FlexibleJointModel, relative: Mapping[str, float], factors: Mapping[str, float]
) -> dict[str, Number]:
    """Of the model as it is true; those of links as factors on their URDF, which holds the number."""
    found = {}
    for number in file_numbers(true):
        phrase = number_phrase(true, number.of, number.parameter)
        value, unit = number_as_given(true, number.of, number.parameter)
        value = factors.get(phrase, value) if unit == FACTOR else value
        found[phrase] = Number(value, relative.get(phrase, number.tolerance) * abs(value), unit)
    return found


def _told(entry: Mapping[str, Any]) -> str:
    """An effect and where it acts, in the words of `number_phrase`: of a model file's entry, or of a report's."""
    if "channel" in entry:
        return f"{effect_name(entry['effect'])} on channel {entry['channel']}"
    where = place_phrase(entry["joint"], entry.get("side")) if entry.get("joint") else ""
    return f"{effect_name(entry['effect'])} {where}".strip()


def _float(value: Any) -> float:
    """A number of a report; null is none."""
    return math.nan if value is None else float(value)
