"""A study's runs in the form for `simulate`; robot and command are loaded once in a process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.batch.aim import Aim, aim_of
from flexdyn.batch.catalogue import Metric
from flexdyn.batch.draws import draws_of_run
from flexdyn.batch.metrics import metrics_of
from flexdyn.batch.places import Changes, NumberPlace, places
from flexdyn.batch.study import Study
from flexdyn.control.commands import PD
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.model_file import model_from_dict
from flexdyn.records import Recording, read_recording
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.job import Job, Shared, prepare
from flexdyn.simulation.parameter_variants import Progress, VariantColumns, Variants
from flexdyn.simulation.solvers import Solver, make_solver

MOST_KEPT = 4
"""Number of studies whose cases are kept in memory."""


@dataclass(frozen=True, eq=False)
class Case:
    """One run of a study: ``simulate(model, command, duration, solver, rate=rate, **starts)``.

    Attributes:
        model: with the numbers of this run.
        command: likewise.
        starts: first states that override those of the command: ``q0``, ``v0``, ... -> joint -> value.
    """

    model: FlexibleJointModel
    command: Any
    starts: Mapping[str, Any]


class Cases:
    """The common parts of all runs of a study, from which each run is made.

    Args:
        study: whose files exist.

    Raises:
        InputError: a file that does not exist any more, or does not fit.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self.model = model_from_dict(study.model, Path("/"), name=study.name)
        self.command = load_command(study.command)
        self._first = make_drive(self.model, self.command, study.duration).initial

    @cached_property
    def places(self) -> dict[str, NumberPlace]:
        """Every number that can vary, by its path."""
        return places(self.model, self.command)

    @cached_property
    def solver(self) -> Solver | str:
        """The solver of every run."""
        settings = dict(self.study.solver)
        name = settings.pop("name")
        return name if name == "auto" else make_solver(name, **settings)

    @cached_property
    def aim(self) -> Aim:
        """Properties of the command that metrics need."""
        return aim_of(self.command, self.model, self.study.duration)

    @cached_property
    def metrics(self) -> tuple[Metric, ...]:
        """The metrics of every run."""
        return metrics_of(self.study.metrics, self.model, self.aim, folder=Path(self.study.folder))

    @cached_property
    def times(self) -> Array:
        """Times of the stored samples (samples,) [s]."""
        return self.job(Case(self.model, self.command, {})).out["t"]

    def case(self, k: int) -> Case:
        """Run k.

        Raises:
            InputError: a number was drawn that the model or the command cannot have.
        """
        return self.case_of(draws_of_run(self.study, k))

    def case_of(self, values: Mapping[str, float]) -> Case:
        """The run with these numbers.

        Args:
            values: by path.

        Raises:
            InputError: a number that the model or the command cannot have.
        """
        changes = self._changes(values)
        command = changes.command(self.command, self.model.joint_names)
        starts = {f"{signal}0": given for signal, given in self._starts(changes).items()}
        return Case(changes.model(self.model), command, starts)

    def together(self, table: Mapping[str, Array], out: Mapping[str, Array], progress: Progress) -> Flags:
        """Integrate runs together if they differ only in numbers of one plant.

        Args:
            table: their numbers (runs,) by path.
            out: filled by this function: signal -> (runs, samples, n).
            progress: called with the number of finished runs about ten times a second.

        Returns:
            (runs,) whether each run is finished; the others must be made one by one with `case_of`.
        """
        changes = self._changes(table)
        initial, starts = changes.initial_of(self.model), self._starts(changes)
        columns = VariantColumns(joints=changes.joints, effects=changes.effects, initial=initial, starts=starts)
        same_links = not (changes.gravity or changes.lock)
        same_command = not (changes.gains or changes.scale is not None or changes.rate is not None)
        plain = self.solver != "auto" and not any("runs" in metric.needs for metric in self.metrics)
        try:
            if same_links and same_command and plain and self._variants.covers(columns):
                return self._variants.simulate(columns, out, progress)
        except InputError:  # each run reports it itself
            pass
        return np.zeros(len(out["q"]), dtype=bool)

    def _changes(self, values: Mapping[str, Any]) -> Changes:
        """The changes of a run with these numbers, or columns of numbers, by path."""
        changes = Changes()
        for path in sorted(values, key=self._order.__getitem__):
            self.places[path].put(changes, values[path])
        return changes

    def _starts(self, changes: Changes) -> dict[str, dict[str, Any]]:
        """First states that override those of the command, by signal and joint."""
        found = {
            signal: {joint: value for joint, value in entries.items() if joint in self._first.get(signal, {})}
            for signal, entries in changes.initial.items()
        }
        return {signal: entries for signal, entries in found.items() if entries}

    @cached_property
    def _variants(self) -> Variants:
        """A run in which no law is neutral because of a number that is zero, as it may be at a median."""
        case = self.case_of({path: kind.usual for path, kind in self.study.kinds.items()})
        job = self.job(case)
        return Variants(case.model, job.drive, job.duration, job.solver, job.out["t"])

    def job(self, case: Case) -> Job:
        """A run with everything done but its integration.

        Raises:
            InputError: a number that the run cannot have.
        """
        study, starts = self.study, {signal: case.starts.get(f"{signal}0") for signal in ("q", "v", "theta", "omega")}
        return prepare(case.model, case.command, study.duration, self.solver, starts, None, Shared(study.rate, None))

    @cached_property
    def _order(self) -> dict[str, int]:
        """Sort numbers of all joints before those of one joint, which override them."""
        return {path: i for i, path in enumerate(self.places)}


_KEPT: dict[str, Cases] = {}
"""Cases by the study's text."""
_KEEPING = Lock()


def load_command(command: Any) -> Recording | PD | None:
    """The command of a study, its recordings read.

    Args:
        command: as `Study` holds it.

    Raises:
        InputError: a recording that cannot be read, or a controller with numbers that are not allowed.
    """
    if command is None:
        return None
    if isinstance(command, str):
        return read_recording(command, name=command)
    settings = dict(command["pd"])
    for key in ("reference", "feedforward"):
        if settings.get(key) is not None:
            settings[key] = read_recording(settings[key], name=settings[key])
    return PD(**settings)


def cases_of_text(text: str) -> Cases:
    """The cases of a study given as text; kept for the next chunk of the same study.

    Args:
        text: from `Study.to_text`.
    """
    found = _KEPT.get(text)
    return keep(Cases(Study.from_text(text))) if found is None else found


def cases_of(study: Study) -> Cases:
    """The cases of a study; they are kept, so that a second call is fast.

    Args:
        study: the study.
    """
    return cases_of_text(study.to_text())


def keep(cases: Cases) -> Cases:
    """Keep cases for later calls with the same study; they replace the oldest kept cases.

    Args:
        cases: of a complete study.

    Returns:
        The cases to use, which another thread may have stored meanwhile.
    """
    text = cases.study.to_text()
    with _KEEPING:
        if text not in _KEPT:
            while len(_KEPT) >= MOST_KEPT:
                del _KEPT[next(iter(_KEPT))]
            _KEPT[text] = cases
        return _KEPT[text]
