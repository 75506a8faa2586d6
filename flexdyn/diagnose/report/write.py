"""What a diagnosis writes: report.json, model.yaml and report.html, all of them or nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from flexdyn.diagnose.report.document import document
from flexdyn.diagnose.report.page import report_page
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.effects import Effect
from flexdyn.effects.model_error import is_number_error
from flexdyn.errors import InputError, printable
from flexdyn.io.files import replacing
from flexdyn.io.json_text import json_text
from flexdyn.io.yaml import dump_yaml
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_to_dict
from flexdyn.model.resolved_parameters import OF_LINK, OF_URDF, factors_of
from flexdyn.model.stated_tolerances import kept_tolerances
from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE
from flexdyn.robot.rewrite import corrected_urdf

PAGE, JSON = "report.html", "report.json"
MODEL = "model.yaml"
MARK = "corrected by flexdyn diagnose"
"""Text in the first line of every model file that a diagnosis wrote."""
HEAD = f"# {{}}, {MARK}. SI units; rotor_inertia on the motor side, everything else reflected.\n"


def write_report(diagnosis: Diagnosis, folder: Path) -> None:
    """Write all files of a diagnosis; those of an earlier one are replaced only when the new ones are complete.

    Raises:
        InputError: the folder cannot be made or written to.
        MissingExtra: plotly is not installed.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if folder.is_file() else f"the folder cannot be made ({error.strerror})"
        raise InputError(reason, file=folder, remedy="give a folder") from None
    files, diagnosis = _model_files(diagnosis, folder)
    files[JSON] = json_text(document(diagnosis)) + "\n"
    files[PAGE] = report_page(diagnosis)
    with ExitStack() as stack:
        for name, text in files.items():
            stack.enter_context(replacing(folder / name)).write_text(text, encoding="utf-8")
    if MODEL not in files:
        _remove_earlier(folder / MODEL)


def _model_files(diagnosis: Diagnosis, folder: Path) -> tuple[dict[str, str], Diagnosis]:
    """Texts of the corrected model, and the diagnosis, which has the reason if there can be none."""
    if diagnosis.no_model:
        return {}, diagnosis
    try:
        return corrected_files(diagnosis.model, folder), diagnosis
    except InputError as problem:
        return {}, replace(diagnosis, no_model=problem.problem)


def _remove_earlier(path: Path) -> None:
    """A corrected model of an earlier report would be taken for this one's; a file of anybody else stays."""
    with suppress(OSError, UnicodeDecodeError):
        with open(path, encoding="utf-8") as stream:
            ours = MARK in stream.readline()
        if ours:
            path.unlink()


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
    true = model.replace(effects=_without_errors(model, of_urdf)).resolved()
    kept = [effect for effect in true.effects if not is_number_error(effect)]
    content = model_to_dict(true.replace(effects=kept, tolerance=_tolerance(model)), folder)
    if links:
        content["links"] = links
    files = {}
    wrong = [effect for effect in of_urdf if not effect.is_neutral]
    if wrong:
        name = f"{Path(str(model.robot.source)).stem}_corrected.urdf"
        try:
            files[name] = corrected_urdf(model.robot, factors_of(wrong, OF_LINK), factors_of(wrong, OF_URDF), folder)
            content["robot"]["urdf"] = name
        except InputError:
            content["effects"] += [effect.to_dict() for effect in wrong]
    return {MODEL: HEAD.format(printable(model.name)) + dump_yaml(content), **files}


def _links_folded(model: FlexibleJointModel) -> tuple[FlexibleJointModel, dict[str, Any]]:
    """The model without its own inertias of links, and the corrected values of these, which the URDF does not have."""
    errors = [e for e in model.effects if is_number_error(e) and e.of in model.links and e.parameter == "link_inertia"]
    factors = {link: number["inertia"] for link, number in factors_of(errors, {"link_inertia": "inertia"}).items()}
    true = {link: {"inertia": factors.get(link, 1.0) * number.value} for link, number in model.links.items()}
    return model.replace(effects=_without_errors(model, errors), links=None), true


def _without_errors(model: FlexibleJointModel, errors: Sequence[Effect]) -> list[Effect]:
    """Effects of a model in which these errors are none, in their places."""
    return [effect.replace(factor=1.0) if effect in errors else effect for effect in model.effects]


def _is_of_urdf(effect: Effect) -> bool:
    """Whether it says that a number of the URDF is wrong."""
    if not is_number_error(effect):
        return False
    return effect.parameter in OF_LINK or (effect.parameter in OF_URDF and not effect.of.startswith("effects["))


def _tolerance(model: FlexibleJointModel) -> Any:
    """The tolerances with the places of effects counted without those that are folded into numbers."""
    kept = [i for i, effect in enumerate(model.effects) if not effect.in_numbers]
    tolerance = kept_tolerances(model.tolerance, kept)
    if not isinstance(tolerance, Mapping):
        return tolerance
    # What was unknown has its estimate in this model.
    return {path: share for path, share in tolerance.items() if share < UNKNOWN_TOLERANCE}
