"""One chunk of a study's runs: prepared, integrated, measured and written, on one thread of any machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.batch.cases import Case, Cases, cases_of_text
from flexdyn.batch.draws import draws_of_runs
from flexdyn.batch.layout import DONE, array_name
from flexdyn.batch.metrics import metrics_of_runs
from flexdyn.batch.motion import RunsMotion
from flexdyn.batch.store import Store
from flexdyn.errors import FlexdynError
from flexdyn.robot import Robot
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate_many

Numbers = Mapping[str, Array]
STARTS = ("q0", "v0", "theta0", "omega0")


@dataclass(frozen=True)
class Done:
    """A chunk that was written.

    Attributes:
        chunk: its number.
        runs: number of its runs.
        failed: number of failed runs.
    """

    chunk: int
    runs: int
    failed: int


class Stopped(Exception):
    """The chunk was stopped before its end; nothing of it is written."""


@dataclass(frozen=True)
class Task:
    """The work on any chunk of one study, as plain data.

    Attributes:
        text: of the study.
        store: path of its store, the same on all machines.
    """

    text: str
    store: str

    def __call__(self, chunk: int, stopped: Callable[[], bool] | None = None) -> Done:
        """Simulate and store a chunk.

        Args:
            chunk: its number.
            stopped: called about ten times a second; True stops the work.

        Raises:
            InputError: the store cannot be written to.
            Stopped: `stopped` returned True.
        """
        cases = cases_of_text(self.text)
        runs = cases.study.bounds(chunk)
        numbers = draws_of_runs(cases.study, runs)
        made = _simulated(cases, numbers, len(runs), stopped)
        _opened(self).write(chunk, _store_columns(cases, numbers, made))
        return Done(chunk, len(runs), sum(reason != "" for reason in made.reasons))


@dataclass(frozen=True)
class Made:
    """The runs of a chunk.

    Attributes:
        signals: (runs, samples, n) by name, NaN for a failed run.
        reasons: why each run failed; empty if it did not.
        runs: those that were made one by one, by their index in the chunk.
    """

    signals: dict[str, Array]
    reasons: list[str]
    runs: dict[int, Run]


@lru_cache(maxsize=4)
def _opened(task: Task) -> Store:
    """The store of a task; it is kept for the next chunk."""
    return Store(Path(task.store), cases_of_text(task.text).study)


def _simulated(cases: Cases, numbers: Numbers, count: int, stopped: Callable[[], bool] | None) -> Made:
    """All runs with these numbers: together where possible, the others one by one."""

    def poll(_: int) -> None:
        """Leave the chunk where it is to stop."""
        if stopped is not None and stopped():
            raise Stopped

    signals = {signal: np.empty((count, len(cases.times), cases.model.n)) for signal in SIGNALS}
    done = cases.together(numbers, signals, poll)
    made = Made(signals, [""] * count, {})
    left = np.flatnonzero(~done)
    for i, run in zip(left.tolist(), _one_by_one(cases, numbers, left, poll), strict=True):
        if isinstance(run, Run):
            made.runs[i] = run
        else:
            made.reasons[i] = str(run)
        for signal, column in signals.items():
            column[i] = getattr(run, signal) if isinstance(run, Run) else np.nan
    return made


def _one_by_one(
    cases: Cases, numbers: Numbers, which: Indices, poll: Callable[[int], None]
) -> list[Run | FlexdynError]:
    """Single runs, or the reasons why they failed."""
    made = [_case(cases, {path: float(column[i]) for path, column in numbers.items()}) for i in which]
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


def _store_columns(cases: Cases, numbers: Numbers, made: Made) -> dict[str, Any]:
    """The data of a chunk for the store, by the name of the array."""
    metrics, count = cases.metrics, len(made.reasons)
    measured = np.full((len(metrics), count), np.nan)
    status = np.array([reason or DONE for reason in made.reasons], dtype=object)
    for motion, which in _motions(cases, made):
        measured[:, which], reasons = metrics_of_runs(metrics, motion)
        for i, lines in zip(which, reasons, strict=True):
            if lines:
                status[i] = "; ".join(lines)
    channels = {signal: made.signals[signal] for signal in cases.study.keep}
    parameters = {array_name(path): column for path, column in numbers.items()}
    values = {array_name(metric.name): row for metric, row in zip(metrics, measured, strict=True)}
    return channels | parameters | values | {"status": status}


def _motions(cases: Cases, made: Made) -> Iterator[tuple[RunsMotion, list[int]]]:
    """The successful runs with their indices in the chunk, grouped by robot."""
    groups: dict[int, tuple[Robot, list[int]]] = {}
    for i in (i for i, reason in enumerate(made.reasons) if not reason):
        robot = made.runs[i].model.robot if i in made.runs else cases.model.robot
        groups.setdefault(id(robot), (robot, []))[1].append(i)
    for robot, which in groups.values():
        whole = len(which) == len(made.reasons)
        signals = made.signals if whole else {name: column[which] for name, column in made.signals.items()}
        runs = [made.runs[i] for i in which if i in made.runs]
        yield RunsMotion(robot, cases.times, signals, cases.aim, runs), which
