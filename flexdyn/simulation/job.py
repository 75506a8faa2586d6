"""Prepare one run for the core, and convert the core's answer to a Run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn import _core
from flexdyn.checks import Array, as_numbers, number
from flexdyn.control.samples import Samples
from flexdyn.control.setting_checks import checked_rate
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import Drive, make_drive
from flexdyn.simulation.initial_state import first_state
from flexdyn.simulation.inputs_and_signals import SIGNALS, Inputs
from flexdyn.simulation.limits import exceeded
from flexdyn.simulation.plant import build_plant, check_model
from flexdyn.simulation.run import Run
from flexdyn.simulation.solver_choice import STIFF, budget, choose_solver, core_settings, switch_notes
from flexdyn.simulation.solvers import (
    DormandPrince,
    DormandPrinceThenRosenbrock,
    Rosenbrock,
    RungeKutta4,
    Solver,
    TimeStepping,
)
from flexdyn.simulation.stopped import stopped
from flexdyn.simulation.wrenches import lower_wrenches

MAX_STEPS = 1e15  # years of computing; beyond it the core's step counter would overflow
MAX_SAMPLES = 20_000_000  # 7.8 GB for seven joints: more is a typing error, and the process would be killed


@dataclass(frozen=True)
class Job:
    """A prepared run: the input of the core, and what is needed to read its answer."""

    core: _core.Job
    model: FlexibleJointModel
    solver: Solver
    notes: tuple[str, ...]
    out: Mapping[str, Array]
    drive: Drive
    x0: Array
    external: tuple[Any, ...]
    duration: float

    def finish(self, report: Mapping[str, Any]) -> Run:
        """Convert the core's answer to a run.

        Raises:
            SimulationError: the integration could not go on.
        """
        if report["reason"]:
            raise stopped(report, self.solver, self.model, self.out["tau"], self.duration)
        solver, switched = self.solver, float(report["switched"])
        if math.isfinite(switched) and not isinstance(solver, DormandPrinceThenRosenbrock):
            solver = DormandPrinceThenRosenbrock(until=switched)
        stats = {key: int(report[key]) for key in ("steps", "rejected", "evaluations", "events")}
        torques = played(self.drive, report, self.model.n, self.duration)
        inputs = Inputs(self.x0, torques, self.external, self.duration, self.drive.controller)
        signals = (self.out[name] for name in ("t", "q", "v", "tau_applied"))
        notes = (*switch_notes(self.notes, solver), *self.drive.notes, *map(str, exceeded(self.model.robot, *signals)))
        return Run(**self.out, model=self.model, solver=solver, notes=notes, stats=stats, inputs=inputs)


class Shared:
    """Parts that the runs of a batch share and that are made once: equal models and commands, sample grids.

    Args:
        rate: of the samples [Hz].
        times: of the samples [s], or None.
    """

    def __init__(self, rate: float, times: ArrayLike | None) -> None:
        self._rate, self._times = rate, times
        self._plants: dict[int, tuple[FlexibleJointModel, _core.Plant]] = {}  # keeps the model: ids are used again
        self._drives: dict[Any, tuple[Any, Drive]] = {}
        self._grids: dict[float, Array] = {}

    def drive(self, model: FlexibleJointModel, command: Any, duration: Any) -> Drive:
        """The command prepared for a model."""
        motors = tuple((joint.gear_ratio, joint.actuator) for joint in model.joints.values() if joint.actuator)
        key = (id(command), model.joint_names, model.elastic.tobytes(), motors, str(duration))
        if key not in self._drives:
            self._drives[key] = (command, make_drive(model, command, duration))
        return self._drives[key][1]

    def plant(self, model: FlexibleJointModel) -> _core.Plant:
        """The plant of a model."""
        if id(model) not in self._plants:
            self._plants[id(model)] = (model, build_plant(model))
        return self._plants[id(model)][1]

    def grid(self, span: float) -> Array:
        """Times of the samples of a run of this duration, read-only."""
        if span not in self._grids:
            self._grids[span] = _grid(span, self._rate, self._times)
            self._grids[span].setflags(write=False)
        return self._grids[span]


def prepare(
    model: FlexibleJointModel,
    command: Any,
    duration: float | None,
    solver: Solver | str,
    starts: Mapping[str, Any],
    external: Any,
    shared: Shared,
) -> Job:
    """Prepare a run; the arguments are those of `simulate`.

    Args:
        model: the arm.
        command: what drives it.
        duration: [s], or None: the command's.
        solver: settings, a name or ``auto``.
        starts: first q, v, theta, omega as given, by name.
        external: wrenches.
        shared: the times of the samples, and parts that runs of a batch share.

    Raises:
        InputError: an argument that does not fit.
    """
    check_model(model)
    drive = shared.drive(model, command, duration)
    span = _duration(duration, drive)
    plant = shared.plant(model)
    x0 = first_state(model, drive, starts)
    x0 = np.concatenate([x0, np.zeros(plant.state_size - len(x0))])  # internal states start at rest
    chosen, notes = choose_solver(model, solver, plant, x0)
    if isinstance(chosen, RungeKutta4 | TimeStepping) and span / chosen.step > MAX_STEPS:
        raise InputError(f"more than {MAX_STEPS:g} steps", key="solver.step", value=chosen.step)
    grid = shared.grid(span)
    out = {"t": grid} | {signal: np.empty((len(grid), model.n)) for signal in SIGNALS}
    out["z"] = np.empty((len(grid), plant.internal_states))
    wrenches = () if external is None else tuple(external) if isinstance(external, list | tuple) else (external,)
    lowered = lower_wrenches(model, wrenches, span)
    arrays = [out[name] for name in (*SIGNALS, "z")]
    may_switch = solver == "auto" and isinstance(chosen, DormandPrince)
    most = budget(Rosenbrock() if may_switch else chosen, span)
    settings = core_settings(chosen, max_steps=most, stiff_rate=STIFF if may_switch else math.inf)
    core = _core.job(plant, drive.command, lowered, x0, span, settings, grid, arrays, None)
    return Job(core, model, chosen, notes, out, drive, x0, wrenches, span)


def played(drive: Drive, report: Mapping[str, Any], n: int, duration: float) -> Samples | None:
    """The torques of a run over time: the command's own samples, or those that a controller commanded at its ticks.

    Args:
        drive: how the run was driven.
        report: of the core.
        n: number of joints.
        duration: of the run [s].
    """
    ticks = np.array(report["tick_times"])
    if not len(ticks):
        return drive.samples
    torques = np.array(report["tick_torques"]).reshape(-1, n)
    if ticks[-1] < duration:
        ticks, torques = np.append(ticks, duration), np.vstack([torques, torques[-1:]])
    return Samples(ticks, torques)


def _duration(duration: float | None, drive: Drive) -> float:
    span = drive.duration if duration is None else duration
    if span is None:
        raise InputError("the duration is missing", key="duration", remedy="give a duration in s or a command")
    return number("duration", span, "a time above 0 s is needed", above=0.0)


def _grid(span: float, rate: float, times: ArrayLike | None) -> Array:
    """Times of the samples: as given, else at this rate, the first at 0 and the last at the end."""
    if times is None:
        steps = span * checked_rate("rate", rate)
        if steps > MAX_SAMPLES:
            problem = f"more than {MAX_SAMPLES:.0e} samples in a run"
            raise InputError(problem, key="rate", value=rate, remedy="lower the rate; the integration does not change")
        count = max(1, round(steps))
        exact = abs(steps - count) < 1e-9 * count
        return np.arange(count + 1) / rate if exact else np.linspace(0.0, span, count + 1)
    grid = as_numbers("times", times, "times are numbers")
    if grid.ndim != 1 or not len(grid) or not (grid >= 0).all() or not (grid <= span).all():
        raise InputError(f"times must lie between 0 and the duration, {span:g} s", key="times", value=grid)
    if not (np.diff(grid) > 0).all():
        raise InputError("times must increase", key="times", value=grid)
    return grid
