"""One chunk of a study's runs: made ready, integrated, measured and written, on one thread of any machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.batch.cases import Case, Cases, cases_of_text
from flexdyn.batch.layout import DONE, array_name
from flexdyn.batch.metrics import measure
from flexdyn.batch.store import Store
from flexdyn.errors import FlexdynError
from flexdyn.run import Run
from flexdyn.simulate import simulate_many

STARTS = ("q0", "v0", "theta0", "omega0")


@dataclass(frozen=True)
class Done:
    """A chunk that is written.

    Attributes:
        chunk: its number.
        runs: how many there are in it.
        failed: how many of them failed.
    """

    chunk: int
    runs: int
    failed: int


class Stopped(Exception):
    """The chunk was given up half way; nothing of it is written."""


@dataclass(frozen=True)
class Task:
    """The work on any chunk of one study, as plain data.

    Attributes:
        text: of the study.
        store: path of its store, the same wherever the task is done.
    """

    text: str
    store: str

    def __call__(self, chunk: int, stopped: Callable[[], bool] | None = None) -> Done:
        """Do a chunk.

        Args:
            chunk: its number.
            stopped: asked some ten times a second whether to give up.

        Raises:
            InputError: the store cannot be written to.
            Stopped: as asked for.
        """
        cases = cases_of_text(self.text)
        values = [cases.values(k) for k in cases.study.bounds(chunk)]
        runs = _simulated(cases, values, stopped)
        _opened(self).write(chunk, _columns(cases, values, runs))
        return Done(chunk, len(runs), sum(not isinstance(run, Run) for run in runs))


@lru_cache(maxsize=4)
def _opened(task: Task) -> Store:
    """The store of a task; kept for its next chunk."""
    return Store(Path(task.store))


def _simulated(
    cases: Cases, values: Sequence[Mapping[str, float]], stopped: Callable[[], bool] | None
) -> list[Run | FlexdynError]:
    """The runs with these numbers, or why there is none."""

    def poll(_: int) -> None:
        if stopped is not None and stopped():
            raise Stopped

    made = [_case(cases, each) for each in values]
    ready = [case for case in made if isinstance(case, Case)]
    if not ready:
        return [case for case in made if isinstance(case, FlexdynError)]
    starts: dict[str, Any] = {key: [case.starts.get(key) for case in ready] for key in STARTS}
    models, commands = [case.model for case in ready], [case.command for case in ready]
    study, solver = cases.study, cases.solver
    done = simulate_many(models, commands, study.duration, solver, **starts, rate=study.rate, threads=1, progress=poll)
    runs = iter(done)
    return [next(runs) if isinstance(case, Case) else case for case in made]


def _case(cases: Cases, values: Mapping[str, float]) -> Case | FlexdynError:
    try:
        return cases.case_of(values)
    except FlexdynError as error:
        return error


def _columns(cases: Cases, values: Sequence[Mapping[str, float]], runs: Sequence[Run | FlexdynError]) -> dict[str, Any]:
    """What the store takes of a chunk, by the name of its array."""
    study, metrics = cases.study, cases.metrics
    shape = (len(runs), len(cases.times), cases.model.n)
    channels = {signal: np.full(shape, np.nan) for signal in study.keep}
    measured = np.full((len(metrics), len(runs)), np.nan)
    status = np.full(len(runs), DONE, dtype=object)
    for i, run in enumerate(runs):
        if not isinstance(run, Run):
            status[i] = str(run)
            continue
        for signal, column in channels.items():
            column[i] = getattr(run, signal)
        measured[:, i], reasons = measure(metrics, run, cases.aim)
        if reasons:
            status[i] = "; ".join(reasons)
    parameters = {array_name(path): np.array([each[path] for each in values]) for path in study.vary}
    numbers = {array_name(metric.name): column for metric, column in zip(metrics, measured, strict=True)}
    return channels | parameters | numbers | {"status": status}
