"""simulate: combines model, command and solver, for one run or for many."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.checks import whole
from flexdyn.control.commands import PD, Controller, FrameWrench
from flexdyn.control.samples import Samples
from flexdyn.errors import FlexdynError, InputError, SimulationError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.initial_state import Start
from flexdyn.simulation.job import Job, Shared, prepare
from flexdyn.simulation.limits import LimitWarning
from flexdyn.simulation.run import Run
from flexdyn.simulation.solvers import Solver


def simulate(
    model: FlexibleJointModel,
    command: Samples | PD | Controller | ArrayLike | Any = None,
    duration: float | None = None,
    solver: Solver | str = "auto",
    *,
    q0: Start = None,
    v0: Start = None,
    theta0: Start | Literal["equilibrium"] = None,
    omega0: Start = None,
    rate: float = 1000.0,
    times: ArrayLike | None = None,
    external: FrameWrench | Sequence[FrameWrench] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Integrate the equations of motion of a model under a command.

    Args:
        model: the arm.
        command: `Samples`, `PD`, `Controller`, a recording (its tau columns, held) or its path, a YAML file with
            ``pd:``, n constant torques [N m or N], or None: no torque. After its end the torque is zero.
        duration: [s]; default: the command's.
        solver: settings from `flexdyn.solvers`, a solver's name, or ``auto``.
        q0: first link positions (n,) or by joint [rad or m]; default: the recording's first row, else the model's own.
        v0: first link velocities, likewise.
        theta0: first rotor positions, likewise; default q0; ``"equilibrium"``: springs loaded by gravity at q0.
        omega0: first rotor velocities, likewise; default v0.
        rate: of the samples in the run [Hz], both ends included; it has no influence on the integration.
        times: of the samples instead of a uniform grid (samples,) [s].
        external: forces and moments at frames of the arm.
        progress: called with the time reached [s] about ten times a second.

    Returns:
        The run.

    Warns:
        LimitWarning: it exceeds a limit of the URDF, see `Run.exceeded`. Limits are enforced only in a model from
            `enforce_limits`.

    Raises:
        InputError: a command, first state or setting that does not fit the model.
        SimulationError: the integration could not continue; the error has the time, the state and the reason.

    Example:
        >>> model = fd.load_model("scara_two_link")
        >>> run = fd.simulate(model, [0.1, 0.0], duration=1.0, solver=fd.solvers.TimeStepping(step=1e-3))
        >>> run.t[-1].item(), run.theta.shape
        (1.0, (1001, 2))
    """
    starts = {"q": q0, "v": v0, "theta": theta0, "omega": omega0}
    job = prepare(model, command, duration, solver, starts, external, Shared(rate, times))
    run = job.finish(_core.simulate(job.core, progress))
    # Runs that flexdyn makes itself, such as those of the paper's study, only have a note.
    asked = not str(sys._getframe(1).f_globals.get("__name__", "")).startswith("flexdyn.")
    for each in run.exceeded if asked else ():
        remedy = "fd.enforce_limits(model) puts end stops and saturation there"
        warnings.warn(f"{model.name}: {each}; {remedy}", LimitWarning, stacklevel=2)
    return run


def simulate_many(
    models: FlexibleJointModel | Sequence[FlexibleJointModel],
    commands: Any = None,
    duration: Any = None,
    solver: Any = "auto",
    *,
    q0: Any = None,
    v0: Any = None,
    theta0: Any = None,
    omega0: Any = None,
    rate: float = 1000.0,
    times: ArrayLike | None = None,
    external: Any = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Run | FlexdynError]:
    """Simulate many runs on native threads, without the interpreter's lock; a run that fails does not stop the others.

    Every argument is as in `simulate`. A list whose entries are not numbers gives one entry for each run; anything else
    applies to all runs. All lists have the same length.

    Args:
        models: one, or a list of them.
        commands: one, or a list.
        duration: [s], one for all.
        solver: one, or a list.
        q0: one, or a list.
        v0: one, or a list.
        theta0: one, or a list.
        omega0: one, or a list.
        rate: of the samples [Hz].
        times: of the samples [s].
        external: one wrench or a tuple of them, or a list of such.
        threads: default: the processors this process may use.
        progress: called with the number of finished runs about ten times a second.

    Returns:
        For each run, in the order of the lists, a `Run`, or the error that says why it failed.

    Raises:
        InputError: lists of different lengths, or no list at all.

    Example:
        >>> model = fd.load_model("scara_two_link")
        >>> runs = fd.simulate_many([model, model.rigid()], [0.1, 0.0], 0.5)
        >>> [run.t.size for run in runs]
        [501, 501]
    """
    given = {"model": models, "command": commands, "duration": duration, "solver": solver, "external": external}
    given |= {"q": q0, "v": v0, "theta": theta0, "omega": omega0}
    shared = Shared(rate, times)
    runs = [_prepared(each, shared) for each in _spread(given)]
    jobs = [job for job in runs if isinstance(job, Job)]
    count = threads if threads is not None else len(os.sched_getaffinity(0))
    whole("threads", count, 1, problem="a number of threads is needed")
    reports = iter(_core.simulate_many([job.core for job in jobs], count, progress))
    return [_finished(job, next(reports)) if isinstance(job, Job) else job for job in runs]


def _spread(given: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A mapping of arguments for each run."""
    lists = {key: value for key, value in given.items() if _is_list(value)}
    lengths = {len(value) for value in lists.values()}
    if len(lengths) != 1:
        found = {key: len(value) for key, value in lists.items()}
        remedy = "give lists of the same length, with an entry for each run"
        raise InputError("how many runs is not clear", key="simulate_many", value=found, remedy=remedy)
    (count,) = lengths
    return [{key: value[i] if key in lists else value for key, value in given.items()} for i in range(count)]


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and not all(isinstance(entry, int | float | np.number) for entry in value)


def _prepared(each: Mapping[str, Any], shared: Shared) -> Job | FlexdynError:
    """The job, or the error if it cannot be prepared."""
    starts = {key: each[key] for key in ("q", "v", "theta", "omega")}
    model = each["model"]
    try:
        command, duration, solver, external = (each[key] for key in ("command", "duration", "solver", "external"))
        return prepare(model, command, duration, solver, starts, external, shared)
    except FlexdynError as error:
        return error
    except Exception as error:  # a user's law that raises an error where auto evaluates it
        return _stopped(model, error, 0.0)


def _stopped(model: FlexibleJointModel, error: Any, t: float) -> SimulationError:
    return SimulationError(f"{model.name}: stopped by {error!r}", reason=str(error), t=t, cause=error)


def _finished(job: Job, report: Mapping[str, Any]) -> Run | FlexdynError:
    """The run, or the error that ended it."""
    error = report["error"]
    if error is not None:
        return error if isinstance(error, FlexdynError) else _stopped(job.model, error, report["t"])
    try:
        return job.finish(report)
    except SimulationError as failure:
        return failure
