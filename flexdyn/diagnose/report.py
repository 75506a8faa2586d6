"""What a diagnosis writes: report.json, model.yaml and report.html, all of them or nothing."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.diagnose.corrected import corrected_files
from flexdyn.diagnose.page import page
from flexdyn.diagnose.result import Diagnosis
from flexdyn.errors import InputError
from flexdyn.files import replacing

PAGE, JSON = "report.html", "report.json"


def write_report(diagnosis: Diagnosis, folder: Path) -> None:
    """Write all files of a diagnosis; those of an earlier one are replaced only when the new ones are complete.

    Raises:
        InputError: the folder cannot be made or written to.
        MissingExtra: matplotlib or plotly is not installed.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if folder.is_file() else f"the folder cannot be made ({error.strerror})"
        raise InputError(reason, file=folder, remedy="give a folder") from None
    try:
        files = corrected_files(diagnosis.model, folder)
    except InputError as problem:
        files, said = {}, f"model.yaml was not written: {problem.problem}."
        diagnosis = replace(diagnosis, notes=(*diagnosis.notes, said))
    files[JSON] = report_json(diagnosis)
    files[PAGE] = page(diagnosis)
    with ExitStack() as stack:
        for name, text in files.items():
            stack.enter_context(replacing(folder / name)).write_text(text, encoding="utf-8")


def report_json(diagnosis: Diagnosis) -> str:
    """Text of report.json (SPEC 8): strict JSON, in which a number that is not finite is null."""
    return json.dumps(_strict(diagnosis.to_dict()), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


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
