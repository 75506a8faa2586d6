"""A study's runs as `simulate` takes them; robot and command are loaded once in a process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexdyn.batch.aim import Aim, aim_of
from flexdyn.batch.catalogue import Metric
from flexdyn.batch.draws import drawn
from flexdyn.batch.metrics import metrics_of
from flexdyn.batch.places import Changes, Place, places
from flexdyn.batch.study import Study
from flexdyn.commands import PD
from flexdyn.drive import make_drive
from flexdyn.job import prepare
from flexdyn.model import FlexibleJointModel
from flexdyn.modelfile import model_from_dict
from flexdyn.records import Recording, read_recording
from flexdyn.solvers import Solver, make_solver


@dataclass(frozen=True, eq=False)
class Case:
    """One run of a study: ``simulate(model, command, duration, solver, rate=rate, **starts)``.

    Attributes:
        model: with the numbers of this run.
        command: likewise.
        starts: first states that the command's own would hide: ``q0`` and the like -> joint -> value.
    """

    model: FlexibleJointModel
    command: Any
    starts: Mapping[str, Any]


class Cases:
    """What all runs of a study share, and each run made of it.

    Args:
        study: whose files are there.

    Raises:
        InputError: a file that is not there any more, or does not fit.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self.model = model_from_dict(study.model, Path("/"), name=study.name)
        self.command = load_command(study.command)
        self._first = make_drive(self.model, self.command, study.duration).initial

    @cached_property
    def places(self) -> dict[str, Place]:
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
        """What the command wants of the arm."""
        return aim_of(self.command, self.model, self.study.duration)

    @cached_property
    def metrics(self) -> tuple[Metric, ...]:
        """What is measured of every run."""
        return metrics_of(self.study.metrics, self.model, self.aim, folder=Path(self.study.folder))

    @cached_property
    def times(self) -> NDArray[np.float64]:
        """Of the samples that are stored (samples,) [s]."""
        starts = dict.fromkeys(("q", "v", "theta", "omega"))
        study = self.study
        job = prepare(self.model, self.command, study.duration, self.solver, starts, study.rate, None, None)
        return job.out["t"]

    def values(self, k: int) -> dict[str, float]:
        """The drawn numbers of run k, by path."""
        return drawn(self.study, k)

    def case(self, k: int) -> Case:
        """Run k.

        Raises:
            InputError: a number was drawn that the model or the command cannot have.
        """
        return self.case_of(self.values(k))

    def case_of(self, values: Mapping[str, float]) -> Case:
        """The run with these numbers.

        Args:
            values: by path.

        Raises:
            InputError: a number that the model or the command cannot have.
        """
        changes = Changes()
        for path in sorted(values, key=self._order.__getitem__):
            self.places[path].put(changes, values[path])
        starts = {
            f"{signal}0": {joint: value for joint, value in entries.items() if joint in self._first.get(signal, {})}
            for signal, entries in changes.initial.items()
        }
        command = changes.command(self.command, self.model.joint_names)
        return Case(changes.model(self.model), command, {key: given for key, given in starts.items() if given})

    @cached_property
    def _order(self) -> dict[str, int]:
        """Numbers of all joints before those of one, which stand over them."""
        return {path: i for i, path in enumerate(self.places)}


def load_command(command: Any) -> Recording | PD | None:
    """The command of a study, its recordings read.

    Args:
        command: as `Study` holds it.

    Raises:
        InputError: a recording that cannot be read, or a controller whose numbers make no sense.
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


@lru_cache(maxsize=4)
def cases_of_text(text: str) -> Cases:
    """The cases of a study given as text; kept for the next chunk of the same study.

    Args:
        text: from `Study.to_text`.
    """
    return Cases(Study.from_text(text))


def cases_of(study: Study) -> Cases:
    """The cases of a study; kept, so that asking again costs nothing.

    Args:
        study: the study.
    """
    return cases_of_text(study.to_text())
