"""The error of an integration that stopped: reason, time, and the solver to use instead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.errors import SimulationError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.fastest_motion import fastest_motion
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import STIFF, budget, core_settings
from flexdyn.simulation.solvers import Rosenbrock, RungeKutta4, Solver

SPENT = "more steps than allowed"
RUNAWAY = 1e6  # rad/s or m/s: no joint is as fast
EVENTFUL = 0.2  # events per step: the events make the steps short
TRIAL_STEPS = 2000  # some hundredths of a second of computing; a spent budget took a hundred times that
RESERVE = 2.0  # times as many steps as the trial foretells must be within the budget


def stopped(
    report: Mapping[str, Any], solver: Solver, model: FlexibleJointModel, tau: Array, duration: float
) -> SimulationError:
    """The error of a run that could not continue.

    Args:
        report: of the core.
        solver: of the run.
        model: that moved.
        tau: torques at its samples (samples, n), as far as it came.
        duration: that was asked for [s].
    """
    t, reason, state = float(report["t"]), str(report["reason"]), np.array(report["x"])
    asked = tau[max(0, int(report["written"]) - 1)] if report["written"] else np.zeros(model.n)
    name = type(solver).__name__ if report["switched"] > t else "Rosenbrock"
    tried = int(report["steps"]) + int(report["rejected"])
    endless = "infinitely many events" in reason
    short = reason == SPENT or endless or "step fell below" in reason
    fastest = fastest_motion(model, state, asked, t) if short and np.isfinite(state).all() else None
    often = endless or int(report["events"]) > EVENTFUL * max(1, int(report["steps"]))
    # With a fixed step a motion diverges because the step is too large.
    runaway = "" if isinstance(solver, RungeKutta4) else _runaway(model, state)
    # Where nothing is fast, or events make the steps short, Rosenbrock has to take them too.
    stiff = name == "DormandPrince" and fastest is not None and fastest.rate > STIFF and not often and not runaway
    implicit = stiff and rosenbrock_gets_through(model, state, asked, duration)
    remedy = runaway or _remedy(solver, short=short, often=often, implicit=implicit)
    why = f"{reason} ({tried} tried, {int(report['events'])} events)" if reason == SPENT else reason
    where = "" if fastest is None else f"; {fastest}"
    told = f"{model.name}: {name} stopped at t = {t:.6g} s: {why}{where}; {remedy}"
    return SimulationError(told, t=t, state=state, solver=solver, reason=reason, fastest=fastest, remedy=remedy)


def _runaway(model: FlexibleJointModel, state: Array) -> str:
    """The message for a motion that no arm makes; empty for others."""
    n, elastic = model.n, np.flatnonzero(model.elastic)
    speeds = np.abs(state[n + len(elastic) : 2 * (n + len(elastic))])
    if not np.isfinite(speeds).all() or speeds.max() < RUNAWAY:
        return ""
    which = int(speeds.argmax())
    joint = model.joint_names[which if which < n else elastic[which - n]]
    unit = model.robot.angle_unit(model.index(joint))
    return f"{joint} runs away at {speeds.max():.3g} {unit}/s: check the gains of its controller and its numbers"


def _remedy(solver: Solver, *, short: bool, often: bool, implicit: bool) -> str:
    """What to do about it.

    Args:
        solver: of the run.
        short: its steps are too many.
        often: for the sake of events.
        implicit: Rosenbrock was seen to get on with longer ones.
    """
    if isinstance(solver, RungeKutta4):
        return "take a smaller step"
    if not short:
        return "check the model's numbers and first state"
    stepping = "take TimeStepping, whose steps are fixed: halve them until the motion stays the same"
    if implicit:
        # What the motion meets later, the trial could not see.
        return f"take Rosenbrock or auto, whose steps need not follow that; if these stop too, {stepping}"
    return f"{stepping}; it does not look for single events" if often else f"{stepping}; or give a greater max_steps"


def rosenbrock_gets_through(model: FlexibleJointModel, x: Array, tau: Array, duration: float) -> bool:
    """Whether its budget would be enough, by the steps that it takes from a state on.

    Where a fast vibration swings on, or friction excites it again and again, Rosenbrock has to follow it too. No
    eigenvalue tells that.

    Args:
        model: that moves.
        x: state at which the trial begins.
        tau: torques asked for, held (n,) [N m or N].
        duration: of the run [s].
    """
    solver, plant = Rosenbrock(), build_plant(model)
    out = [np.empty((1, model.n)) for _ in SIGNALS] + [np.empty((1, plant.internal_states))]
    command = make_drive(model, [float(torque) for torque in tau], duration).command
    settings = core_settings(solver, max_steps=TRIAL_STEPS)
    try:
        job = _core.job(plant, command, [], x, duration, settings, np.array([duration]), out, None)
        tried = _core.simulate(job, None)
    except Exception:  # a user's law that refuses where the trial goes
        return False
    if not tried["reason"]:
        return True
    needed = (int(tried["steps"]) + int(tried["rejected"])) * duration / max(float(tried["t"]), 1e-300)
    return tried["reason"] == SPENT and RESERVE * needed <= budget(solver, duration)
