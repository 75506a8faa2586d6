"""The corrected model as files: every wrong number is corrected at its place."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeGuard

from flexdyn.effects import Effect, JointElasticity, ParameterError
from flexdyn.errors import InputError
from flexdyn.io.yaml import dump_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_to_dict
from flexdyn.model.resolved_parameters import OF_LINK, OF_URDF
from flexdyn.robot.rewrite import corrected_urdf

MODEL = "model.yaml"
MARK = "corrected by flexdyn diagnose"
"""Text in the first line of every model file that a diagnosis wrote."""
HEAD = f"# {{}}, {MARK}. SI units; rotor_inertia on the motor side, everything else reflected.\n"
EFFECT_PATH = re.compile(r"effects\[(\d+)\](\..*)")


def corrected_files(model: FlexibleJointModel, folder: Path) -> dict[str, str]:
    """Texts of model.yaml and, if numbers of its URDF are wrong, of the corrected URDF, by file name.

    Parameter errors and joint elasticities are applied to the numbers that they change; sensor effects and all others
    stay effects. If the URDF cannot be read any more, errors of its numbers stay parameter errors.

    Args:
        model: with the findings among its effects.
        folder: of the files.

    Raises:
        InputError: the robot has no URDF: it came from a pin.Model.
    """
    model, links = _links_folded(model)
    of_urdf = [effect for effect in model.effects if _is_of_urdf(effect)]
    inside = [replace(effect, factor=1.0) if _is_of_urdf(effect) else effect for effect in model.effects]
    true = model.replace(effects=inside).resolved()
    kept = [effect for effect in true.effects if not isinstance(effect, ParameterError)]
    tolerance = _tolerance(model)
    content = model_to_dict(true.replace(effects=kept, tolerance=tolerance), folder)
    if links:
        content["links"] = links
    files = {}
    wrong = [effect for effect in of_urdf if not effect.is_neutral]
    if wrong:
        name = f"{Path(str(model.robot.source)).stem}_corrected.urdf"
        try:
            files[name] = corrected_urdf(model.robot, _factors(wrong, OF_LINK), _factors(wrong, OF_URDF), folder)
            content["robot"]["urdf"] = name
        except InputError:
            content["effects"] += [effect.to_dict() for effect in wrong]
    title = "".join(letter if letter.isprintable() else " " for letter in model.name)
    return {MODEL: HEAD.format(title) + dump_yaml(content), **files}


def _links_folded(model: FlexibleJointModel) -> tuple[FlexibleJointModel, dict[str, Any]]:
    """The model without inertias of links of its own, and these as they are true: its URDF does not have them."""
    errors = [e for e in model.effects if isinstance(e, ParameterError)]
    factors = _factors(errors, {"link_inertia": "inertia"})
    true = {
        link: {"inertia": factors.get(link, {}).get("inertia", 1.0) * number.value}
        for link, number in model.links.items()
    }
    effects = [
        replace(effect, factor=1.0)
        if isinstance(effect, ParameterError) and effect.parameter == "link_inertia" and effect.of in true
        else effect
        for effect in model.effects
    ]
    return model.replace(effects=effects, links=None), true


def _is_of_urdf(effect: Effect) -> TypeGuard[ParameterError]:
    """Whether it says that a number of the URDF is wrong."""
    if not isinstance(effect, ParameterError):
        return False
    return effect.parameter in OF_LINK or (effect.parameter in OF_URDF and not effect.of.startswith("effects["))


def _factors(errors: Sequence[ParameterError], words: Mapping[str, str]) -> dict[str, dict[str, float]]:
    """Of every link or joint, by the URDF's word for the number; several on one number multiply."""
    found: dict[str, dict[str, float]] = {}
    for error in errors:
        if error.parameter in words:
            numbers, word = found.setdefault(error.of, {}), words[error.parameter]
            numbers[word] = numbers.get(word, 1.0) * error.factor
    return found


def _tolerance(model: FlexibleJointModel) -> Any:
    """With effects counted as they stand once those that are folded are gone."""
    if not isinstance(model.tolerance, Mapping):
        return model.tolerance
    kept = [i for i, effect in enumerate(model.effects) if not isinstance(effect, ParameterError | JointElasticity)]
    places = {old: new for new, old in enumerate(kept)}
    found = {}
    for path, value in model.tolerance.items():
        match = EFFECT_PATH.fullmatch(path)
        if match is None:
            found[path] = value
        elif int(match[1]) in places:
            found[f"effects[{places[int(match[1])]}]{match[2]}"] = value
    return found
