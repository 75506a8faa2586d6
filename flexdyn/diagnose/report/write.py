"""What a diagnosis writes: report.json, model.yaml and report.html, all of them or nothing."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from flexdyn.diagnose.report.document import report_json
from flexdyn.diagnose.report.model_files import MARK, MODEL, corrected_files
from flexdyn.diagnose.report.page import page
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.errors import InputError
from flexdyn.io.files import replacing

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
    files, diagnosis = _model_files(diagnosis, folder)
    files[JSON] = report_json(diagnosis)
    files[PAGE] = page(diagnosis)
    with ExitStack() as stack:
        for name, text in files.items():
            stack.enter_context(replacing(folder / name)).write_text(text, encoding="utf-8")
    if MODEL not in files:
        _remove_earlier(folder / MODEL)


def _model_files(diagnosis: Diagnosis, folder: Path) -> tuple[dict[str, str], Diagnosis]:
    """Texts of the corrected model, and the diagnosis that says so where there can be none."""
    if not diagnosis.write_model:
        return {}, diagnosis
    try:
        return corrected_files(diagnosis.model, folder), diagnosis
    except InputError as problem:
        decisions = {**diagnosis.decisions, MODEL: f"{MODEL} was not written: {problem.problem}."}
        return {}, replace(diagnosis, write_model=False, decisions=decisions)


def _remove_earlier(path: Path) -> None:
    """A corrected model of an earlier report would be taken for this one's; a file of anybody else stays."""
    try:
        with open(path, encoding="utf-8") as stream:
            ours = MARK in stream.readline()
        if ours:
            path.unlink()
    except (OSError, UnicodeDecodeError):
        return
