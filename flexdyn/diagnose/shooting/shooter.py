"""Simulate the windows of a recording in the core, on native threads."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn import _core
from flexdyn.analysis.analysed_model import without
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.lazy import lazy
from flexdyn.diagnose.progress import check
from flexdyn.diagnose.shooting.sensing import early, of_windows, sensors
from flexdyn.diagnose.shooting.window_torques import held_signal, torque_shifts, torques_of_windows
from flexdyn.diagnose.shooting.windows import PerWindow, Windows
from flexdyn.effects import MemoryEffect
from flexdyn.effects.channels import lag, measure
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.at_time import at_time, is_timed
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.laws import acting_effects
from flexdyn.simulation.plant import build_plant
from flexdyn.simulation.solver_choice import STIFF, core_settings, fastest_rate
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver

LARGEST_PHASE_STEP = 0.25
"""Largest rate times step for the classical method [rad]: then the error of a vibration after 0.5 s is below 0.5 %."""
MOST_EVALUATIONS = 100_000
"""Largest number of evaluations for a window: as many as for 0.5 s in classical steps of 20 us."""
INTERNAL_STATE_LIMIT = 2.0
"""Largest internal state in a first state, as a multiple of its reach [1]: linear corrections may be too large."""
AT_ONCE = 256
"""Number of runs that are given to the threads together."""


@dataclass(frozen=True, eq=False)
class SimulatedWindows(PerWindow):
    """Simulated windows.

    Attributes:
        q: (windows, rows, n).
        theta: likewise; q for a rigid joint.
        x: states at the first sample of every block (windows, blocks, nx).
        written: number of samples of each window that were reached; fewer than its rows if it failed (windows,).
    """

    q: Array
    theta: Array
    x: Array
    written: NDArray[np.int64]


class Shooter:
    """One model, prepared for the simulation of windows.

    A command delay, and a lag of the recorded torque, become a shift of the torque in time, so that a window has the
    torques from before its start. Laws that depend on the time since the run's start are shifted to that of the window.

    Args:
        model: the arm.
        windows: that will be simulated.
        extra: torque added to the recorded one (windows, rows, n) [N m].
    """

    def __init__(self, model: FlexibleJointModel, windows: Windows, extra: Array | None = None) -> None:
        self.given = model
        self.model = without(model.resolved(), lambda effect: effect.stage == "actuator" and effect.lateness > 0.0)
        self.windows = windows
        self.elastic = np.flatnonzero(self.model.elastic)
        self.memory = [effect for effect in acting_effects(self.model) if isinstance(effect, MemoryEffect)]
        timed = any(is_timed(effect) for effect in self.model.all_effects)
        count = len(windows)
        self.begins = windows.t[:, 0] - np.array([windows.recordings[k].t[0] for k in windows.places[:, 0]])
        of_run = self.begins + np.array(windows.since)[windows.places[:, 0]]
        models = [at_time(self.model, begin) for begin in of_run.tolist()] if timed else [self.model]
        plants = [build_plant(each) for each in models]
        self.plants = plants if timed else plants * count
        self._held = torques_of_windows(model.resolved(), windows, extra)
        self.signals = [held_signal(*each) for each in self._held]

    @property
    def size(self) -> int:
        """Size of the state."""
        return self.plants[0].state_size

    def run(
        self,
        x0: Array,
        tight: float = 1.0,
        *,
        which: NDArray[np.int64] | None = None,
        others: SimulatedWindows | None = None,
    ) -> SimulatedWindows:
        """Simulate windows.

        Args:
            x0: first states of all (windows, nx).
            tight: factor on step or tolerance, below 1 for a check.
            which: windows to simulate; None: all.
            others: results of the other windows.
        """
        windows, n = self.windows, self.model.n
        count, rows = len(windows), windows.rows
        solver = core_settings(self._solver(x0, tight), MOST_EVALUATIONS)
        q, theta, x = (np.zeros((count, *each)) for each in ((rows, n), (rows, n), (windows.blocks, self.size)))
        motion = SimulatedWindows(q, theta, x, np.zeros(count, np.int64))
        motion = motion if others is None else others.part(np.arange(count))
        which = np.arange(count) if which is None else which
        for begin in range(0, len(which), AT_ONCE):
            check()
            self._some(which[begin : begin + AT_ONCE], x0, solver, motion)
        return motion

    def _some(
        self, which: NDArray[np.int64], x0: Array, solver: _core.SolverSettings, motion: SimulatedWindows
    ) -> None:
        rows, n = self.windows.rows, self.model.n
        out = np.full((len(which), len(SIGNALS), rows, n), np.nan)
        z = np.full((len(which), rows, self.plants[0].internal_states), np.nan)
        jobs = []
        for place, w in enumerate(which.tolist()):
            times = self.windows.t[w] - self.windows.t[w, 0]
            command = _core.open_loop(self.signals[w])
            start, arrays = np.ascontiguousarray(x0[w]), [*out[place], z[place]]
            jobs.append(_core.job(self.plants[w], command, [], start, float(times[-1]), solver, times, arrays, None))
        python = any(effect.is_python for effect in self.model.all_effects)
        reached = _simulated(jobs, out[:, 0], python=python)
        q, theta, v, omega = (out[:, k] for k in range(4))
        every = slice(None, None, self.windows.block)
        parts = (q, theta[..., self.elastic], v, omega[..., self.elastic], z)
        motion.q[which], motion.theta[which] = q, theta
        motion.x[which] = np.nan_to_num(np.concatenate([part[:, every] for part in parts], axis=2))
        motion.written[which] = reached

    def bounded(self, x0: Array) -> Array:
        """First states with internal states that are limited to possible values (windows, nx)."""
        reach = INTERNAL_STATE_LIMIT * np.array([effect.reach for effect in self.memory])
        x0 = x0.copy()
        x0[:, x0.shape[1] - len(reach) :] = np.clip(x0[:, x0.shape[1] - len(reach) :], -reach, reach)
        return x0

    def torques(self, w: int) -> Array:
        """Torques that arrive at the first sample of every block of a window (blocks, n)."""
        breaks, values = self._held[w]
        times = self.windows.t[w, :: self.windows.block] - self.windows.t[w, 0]
        return np.ascontiguousarray(values[np.searchsorted(breaks, times + 1e-9, side="right") - 1])

    @lazy
    def measured(self) -> Array:
        """The measured channels, without the lags of the model (windows, rows, channels); NaN if unmeasured."""
        windows, table = self.windows, self.windows.measured
        for column, name in enumerate(windows.channels):
            late = lag(sensors(self.model, name))
            if late == 0.0:
                continue
            table = table.copy()
            for k, recording in enumerate(windows.recordings):
                mine = windows.places[:, 0] == k
                if name in recording:
                    table[mine, :, column] = early(recording, name, late, windows.t[mine])
        return table

    @property
    def torques_known(self) -> Flags:
        """Windows that need no torques from before the recording (windows,)."""
        return np.asarray(self.begins >= torque_shifts(self.given.resolved()).max())

    def reported(self, motion: SimulatedWindows) -> Array:
        """The readings of the model's sensors, without their lag (windows, rows, channels)."""
        windows = self.windows
        table = np.empty((len(windows), windows.rows, len(windows.channels)))
        for k, name in enumerate(windows.channels):
            signal, _, joint = name.partition(".")
            table[:, :, k] = getattr(motion, signal)[:, :, self.model.index(joint)]
            effects = sensors(self.model, name)
            if effects:
                table[:, :, k] = of_windows(measure, effects, table[:, :, k], windows.t)
        return table

    def _solver(self, x0: Array, tight: float) -> Solver:
        """Solver settings for errors well below the sensors' noise."""
        some = range(0, len(x0), max(1, len(x0) // 5))
        rate = max(fastest_rate(self.plants[w], np.ascontiguousarray(x0[w])) for w in some)
        fast = np.abs(x0[:, self.model.n + len(self.elastic) :]).max()
        rate = max([rate, *(fast / effect.reach for effect in self.memory if effect.reach > 0)])
        if rate * self.windows.period < (
            LARGEST_PHASE_STEP if self.plants[0].has_dry_friction else 8 * LARGEST_PHASE_STEP
        ):
            return RungeKutta4(step=tight * min(LARGEST_PHASE_STEP / max(rate, 1e-9), self.windows.period))
        if rate > STIFF:
            return Rosenbrock(rtol=1e-5 * tight, atol=1e-7 * tight)
        return DormandPrince(rtol=1e-5 * tight, atol=1e-7 * tight)


def _simulated(jobs: Sequence[_core.Job], q: Array, *, python: bool) -> NDArray[np.int64]:
    """Run jobs and return how many samples each reached; those with too many steps are stopped."""
    if python:  # laws in Python run one at a time, and in this thread
        for each in jobs:
            with contextlib.suppress(Exception):
                _core.simulate(each, None)
    else:
        _core.simulate_many(jobs, len(os.sched_getaffinity(0)), None)
    finite = np.asarray(np.isfinite(q).all(axis=2))
    return np.where(finite.all(axis=1), np.int64(q.shape[1]), finite.argmin(axis=1)).astype(np.int64)
