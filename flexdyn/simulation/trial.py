"""Whether Rosenbrock would get through a run that DormandPrince could not finish: a short run of it tells."""

from __future__ import annotations

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import budget, core_settings
from flexdyn.simulation.solvers import Rosenbrock

TRIAL_STEPS = 2000  # some hundredths of a second of computing; a spent budget took a hundred times that
RESERVE = 2.0  # times as many steps as the trial foretells must be within the budget


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
        tried = _core.simulate(
            _core.job(plant, command, [], x, duration, settings, np.array([duration]), out, None), None
        )
    except Exception:  # a user's law that refuses where the trial goes
        return False
    if not tried["reason"]:
        return True
    needed = (int(tried["steps"]) + int(tried["rejected"])) * duration / max(float(tried["t"]), 1e-300)
    return tried["reason"] == "more steps than allowed" and RESERVE * needed <= budget(solver, duration)
