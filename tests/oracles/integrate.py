"""SciPy's integrators at tight tolerance, stopped at every instant where the torque may jump."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import ode

Array = NDArray[np.float64]
Torque = Sequence[float]
Times = Sequence[float] | Array


def trajectory(f: Callable[[float, Sequence[float]], Sequence[float]], x0: Sequence[float], stops: Times) -> Array:
    """States at `stops`, the first of them the start, by DOP853; f may jump at a stop and nowhere else."""
    states = [np.array(x0, dtype=float)]
    for begin, end in itertools.pairwise(stops):
        inside = 0.5 * (begin + end)  # f of this piece, also where t rounds onto its ends

        def piece(
            t: float, x: Array, begin: float = begin, end: float = end, inside: float = inside
        ) -> Sequence[float]:
            return f(t if begin < t < end else np.nextafter(t, inside), x.tolist())

        solver = ode(piece).set_integrator("dop853", rtol=3e-14, atol=1e-14, nsteps=100_000)
        states.append(solver.set_initial_value(states[-1], begin).integrate(end).copy())
        assert solver.successful()
    return np.array(states)


def held(
    f: Callable[[Sequence[float], Torque], Sequence[float]],
    x0: Sequence[float],
    ticks: Times,
    torque: Callable[[float, Sequence[float]], Torque],
) -> tuple[Array, Array]:
    """States at `ticks` and the torques asked for there, each held to the next tick."""
    states, torques = [list(x0)], []
    step = ode(lambda _, x, tau: f(x.tolist(), tau)).set_integrator("dop853", rtol=1e-13, atol=1e-14)
    for begin, end in itertools.pairwise(ticks):
        tau = torque(begin, states[-1])
        torques.append(list(tau))
        step.set_initial_value(states[-1], begin).set_f_params(tau)
        states.append(step.integrate(end).tolist())
        assert step.successful()
    torques.append(list(torque(ticks[-1], states[-1])))
    return np.array(states), np.array(torques)
