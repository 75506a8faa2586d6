"""A trial of a study before it runs: an error that would stop every run is reported once, with its key."""

from __future__ import annotations

from flexdyn.batch.cases import Cases
from flexdyn.checks import check_known
from flexdyn.errors import FlexdynError, InputError


def rehearse(cases: Cases) -> None:
    """Prepare the run with every number at its median, then runs with each number at its bounds.

    Args:
        cases: of the study.

    Raises:
        InputError: an unknown path or metric, or a run that cannot be made.
    """
    kinds = cases.study.kinds
    for path in kinds:
        if path not in cases.places:
            beside = [each for each in cases.places if each.rpartition(".")[0] == path.rpartition(".")[0]]
            check_known(path, beside or cases.places, "no such number in the model or command", key=f"vary.{path}")
    _ = cases.metrics
    middle = {path: kind.centre for path, kind in kinds.items()}
    try:
        cases.job(cases.case_of(middle))
    except FlexdynError as error:
        cases.job(cases.case_of({}))  # it is reported directly if the varying numbers have no part in it
        key = f"vary.{next(iter(kinds))}" if len(kinds) == 1 else "vary"
        raise InputError(f"a run with every number at its median cannot be made ({error})", key=key) from None
    for path, kind in kinds.items():
        for value in kind.extremes:
            try:
                cases.job(cases.case_of(middle | {path: value}))
            except FlexdynError as error:
                raise InputError(f"a run with {value:g} cannot be made ({error})", key=f"vary.{path}") from None
