"""simulate: the one driver that brings model, command and solver together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexdyn import _core
from flexdyn.checks import as_number
from flexdyn.commands import PD, Controller, FrameWrench, Samples, checked_rate
from flexdyn.drive import Drive, lower_wrenches, make_drive
from flexdyn.errors import InputError, SimulationError
from flexdyn.model import FlexibleJointModel
from flexdyn.plant import LinkSide, build_plant
from flexdyn.run import SIGNALS, Run
from flexdyn.solvers import DormandPrince, RungeKutta4, Solver, make_solver

Array = NDArray[np.float64]
MAX_STEPS = 1e15  # years of computing; beyond it the core's step counter would overflow
MAX_SAMPLES = 20_000_000  # 7.8 GB for seven joints: more is a slip of the pen, and would end in a killed process
Start = ArrayLike | Mapping[str, float] | None


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
            ``pd:``, n torques that do not change [N m or N], or None: no torque. After its end the torque is zero.
        duration: [s]; default: the command's.
        solver: settings from `flexdyn.solvers`, a solver's name, or ``auto``.
        q0: first link positions (n,) or by joint [rad or m]; over the recording's first row, over the model's own.
        v0: first link velocities, likewise.
        theta0: first rotor positions, likewise; default q0; ``"equilibrium"``: springs loaded by gravity at q0.
        omega0: first rotor velocities, likewise; default v0.
        rate: of the samples in the run [Hz], both ends included; it changes nothing in how the run is integrated.
        times: of the samples instead of a uniform grid (samples,) [s].
        external: forces and moments at frames of the arm.
        progress: called with the time reached [s] some ten times a second.

    Returns:
        The run.

    Raises:
        InputError: a command, first state or setting that does not fit the model.
        SimulationError: the integration could not go on; it carries the time, the state and the reason.
    """
    if not isinstance(model, FlexibleJointModel):
        raise InputError("a FlexibleJointModel is needed", key="model", value=model, remedy="use fd.load_model(...)")
    drive = make_drive(model, command, duration)
    span = _duration(duration, drive)
    chosen, notes = choose_solver(model, solver)
    if isinstance(chosen, RungeKutta4) and span / chosen.step > MAX_STEPS:
        raise InputError(f"more than {MAX_STEPS:g} steps", key="solver.step", value=chosen.step)
    plant = build_plant(model)
    x0 = _first_state(model, drive, {"q": q0, "v": v0, "theta": theta0, "omega": omega0})
    x0 = np.concatenate([x0, np.zeros(plant.state_size - len(x0))])  # internal states start at rest
    grid = _grid(span, rate, times)
    out = {signal: np.empty((len(grid), model.n)) for signal in SIGNALS}
    wrenches = lower_wrenches(model, external, span)
    report = _core.simulate(
        plant, drive.command, wrenches, x0, span, _settings(chosen), grid, list(out.values()), progress
    )
    if report["reason"]:
        raise _failure(report, chosen, model)
    stats = {key: int(report[key]) for key in ("steps", "rejected", "evaluations", "events")}
    return Run(t=grid, **out, model=model, solver=chosen, notes=notes, stats=stats)


def choose_solver(model: FlexibleJointModel, solver: Solver | str) -> tuple[Solver, tuple[str, ...]]:
    """The solver that will run, and what is worth saying about the choice.

    Raises:
        InputError: no such solver, or one that cannot take the model's dry friction.
    """
    notes: list[str] = []
    if solver == "auto":
        solver = DormandPrince()
        notes.append("solver auto: DormandPrince, which takes every model of this version and holds its tolerance")
    elif isinstance(solver, str):
        solver = make_solver(solver)
    if not isinstance(solver, Solver):
        raise InputError("a solver is needed", key="solver", value=solver, remedy="use fd.solvers.DormandPrince()")
    dry = [effect for effect in model.all_effects if effect.stage == "dry" and not effect.is_neutral]
    if dry and isinstance(solver, RungeKutta4) and solver.smoothing is None:
        remedy = "use DormandPrince, or give RungeKutta4 a smoothing in rad/s"
        raise InputError(
            f"RungeKutta4 takes smooth laws only, and the model has {dry[0].name}", key="solver", remedy=remedy
        )
    width = getattr(solver, "smoothing", None)
    if dry and width is not None:
        notes.append(f"dry friction is smoothed over {width:g} rad/s: a loaded joint creeps instead of sticking")
    return solver, tuple(notes)


def _duration(duration: float | None, drive: Drive) -> float:
    span = drive.duration if duration is None else duration
    if span is None:
        raise InputError("how long to simulate is not said", key="duration", remedy="give a duration in s or a command")
    number = as_number(span)
    if not 0 < number < math.inf:
        raise InputError("a time above 0 s is needed", key="duration", value=span)
    return number


def _grid(span: float, rate: float, times: ArrayLike | None) -> Array:
    if times is None:
        steps = span * checked_rate("rate", rate)
        if steps > MAX_SAMPLES:
            problem = f"more than {MAX_SAMPLES:.0e} samples in a run"
            raise InputError(problem, key="rate", value=rate, remedy="lower the rate; the integration does not change")
        count = max(1, round(steps))
        exact = abs(steps - count) < 1e-9 * count
        return np.arange(count + 1) / rate if exact else np.linspace(0.0, span, count + 1)
    try:
        grid = np.array(times, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError("times are numbers", key="times", value=times) from None
    if grid.ndim != 1 or not len(grid) or not (grid >= 0).all() or not (grid <= span).all():
        raise InputError(f"times must lie between 0 and the duration, {span:g} s", key="times", value=grid)
    if not (np.diff(grid) > 0).all():
        raise InputError("times must increase", key="times", value=grid)
    return grid


def _first_state(model: FlexibleJointModel, drive: Drive, given: dict[str, Any]) -> Array:
    """X = [q, theta, v, omega] from the arguments, over the recording's first row, over the model's `initial`."""
    values = {
        signal: _start(model, signal, given[signal], {**model.initial.get(signal, {}), **drive.initial.get(signal, {})})
        for signal in ("q", "v", "theta", "omega")
    }
    for rotor, link in (("theta", "q"), ("omega", "v")):  # a link put elsewhere takes its rotor along
        if given[rotor] is None and given[link] is not None:
            values[rotor][_named(model, given[link])] = math.nan
    q, v = (np.nan_to_num(values[signal], nan=0.0) for signal in ("q", "v"))
    theta = np.where(np.isnan(values["theta"]), q, values["theta"])
    omega = np.where(np.isnan(values["omega"]), v, values["omega"])
    if isinstance(given["theta"], str):
        theta = equilibrium_theta(model, q)
    for signal, turned, moved in (("theta", theta, q), ("omega", omega, v)):
        different = ~model.elastic & (turned != moved)
        if different.any():
            joint = model.joint_names[int(np.argmax(different))]
            twin = {"theta": "q", "omega": "v"}[signal]
            problem = f"the joint is rigid: {signal} is {twin}"
            raise InputError(problem, key=f"{signal}0.{joint}", value=float(turned[model.index(joint)]))
    return np.concatenate([q, theta[model.elastic], v, omega[model.elastic]])


def _named(model: FlexibleJointModel, given: Start) -> list[int]:
    """Joints that a first state was given for."""
    return [model.index(joint) for joint in given] if isinstance(given, Mapping) else list(range(model.n))


def equilibrium_theta(model: FlexibleJointModel, q: Array) -> Array:
    """Rotor positions (n,) at which the springs carry gravity at rest: K (theta - q) = h(q, 0)."""
    weight = LinkSide(model).bias(q, np.zeros(model.n))
    elastic = model.elastic
    theta = q.copy()
    theta[elastic] += weight[elastic] / model.resolved().stiffness[elastic]
    return theta


def _start(model: FlexibleJointModel, signal: str, given: Any, known: Mapping[str, float]) -> Array:
    """One signal of the first state (n,), NaN where nothing is said."""
    names, key = model.joint_names, f"{signal}0"
    start = np.array([known.get(joint, math.nan) for joint in names])
    if given is None:
        return start
    if isinstance(given, str):
        if signal == "theta" and given == "equilibrium":
            return start
        raise InputError("numbers are needed", key=key, value=given, remedy="give one for each joint")
    if isinstance(given, Mapping):
        for joint, value in given.items():
            start[model.index(joint)] = _number(f"{key}.{joint}", value)
        return start
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError("numbers are needed", key=key, value=given) from None
    if array.shape != (model.n,) or not np.isfinite(array).all():
        remedy = f"the joints are {', '.join(names)}"
        raise InputError(f"{model.n} finite numbers are needed", key=key, value=given, remedy=remedy)
    return array


def _number(key: str, value: Any) -> float:
    number = as_number(value)
    if not math.isfinite(number):
        raise InputError("a finite number is needed", key=key, value=value)
    return number


def _settings(solver: Solver) -> _core.SolverSettings:
    settings = {key: float(value) for key, value in asdict(solver).items() if value is not None}
    return _core.solver_settings(type(solver).__name__, **settings)


def _failure(report: dict[str, Any], solver: Solver, model: FlexibleJointModel) -> SimulationError:
    t, reason = float(report["t"]), str(report["reason"])
    remedy = "take a smaller step" if isinstance(solver, RungeKutta4) else "check the model's numbers and first state"
    return SimulationError(
        f"{model.name}: {type(solver).__name__} stopped at t = {t:.6g} s: {reason}; {remedy}",
        t=t,
        state=np.array(report["x"]),
        solver=solver,
        reason=reason,
    )
