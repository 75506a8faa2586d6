"""Who runs the batch: flexdyn's simulate_many from Python threads, and mujoco.rollout with its own pool."""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np
from arms import Array
from batch_problem import DURATION, RATE, Batch
from mujoco_arm import MujocoArm
from mujoco_friction import harden

import flexdyn as fd
from flexdyn import _core
from flexdyn.simulation.job import Shared, prepare

CHUNK = 128  # runs: what a thread of flexdyn takes at a time, as a study does
STEP = 1e-3  # s, MuJoCo's


class Flexdyn:
    """The batch by `simulate_many`, chunk by chunk, each chunk on one thread.

    Args:
        batch: what to run.
        solver: settings.
        threads: Python threads; the core releases the interpreter's lock.
    """

    def __init__(self, batch: Batch, solver: fd.solvers.Solver, threads: int) -> None:
        self.batch, self.solver, self.threads = batch, solver, threads
        self._command = batch.command

    def run(self, which: range) -> None:
        """Do some of the runs and let the results go."""
        chunks = [which[i : i + CHUNK] for i in range(0, len(which), CHUNK)]
        with ThreadPoolExecutor(self.threads) as pool:
            for runs in pool.map(self.chunk, chunks):
                del runs

    def processor_seconds(self, which: range) -> float:
        """Processor time of some of the runs [s]."""
        begin = time.process_time()
        self.run(which)
        return time.process_time() - begin

    def chunk(self, which: Sequence[int]) -> list[Any]:
        """Some of the runs, models made on the way."""
        models = [self.batch.varied(k) for k in which]
        starts = [self.batch.starts[k] for k in which]
        grid = self.batch.grid
        return fd.simulate_many(models, self._command, DURATION, self.solver, q0=starts, times=grid, threads=1)

    def bare_seconds(self, which: range) -> float:
        """Processor time of the integration alone [s]: everything is made ready before."""
        starts = dict.fromkeys(("q", "v", "theta", "omega"))
        grid = self.batch.grid
        jobs = [
            prepare(
                self.batch.varied(k),
                self._command,
                DURATION,
                self.solver,
                starts | {"q": self.batch.starts[k]},
                None,
                Shared(1.0, grid),
            )
            for k in which
        ]
        begin = time.process_time()
        _core.simulate_many([job.core for job in jobs], 1, None)
        return time.process_time() - begin

    def positions(self, which: range) -> Array:
        """[q, theta] on the grid (runs, samples, 4) [rad]."""
        return np.array([np.hstack([run.q, run.theta]) for run in self.chunk(which)])


class Rollout:
    """The batch by `mujoco.rollout` at 1 ms, Euler; models, torques and memory for results are made beforehand.

    Args:
        batch: what to run.
        threads: of its pool.
        block: the most runs at a time.
        hard: friction as hard as it gets, instead of MuJoCo's default.
    """

    def __init__(self, batch: Batch, threads: int, block: int, *, hard: bool) -> None:
        peer = MujocoArm(batch.arm(), "Euler", STEP)
        if hard:
            harden(peer, STEP)
        self.batch, self._model, self._steps = batch, peer.model, round(DURATION / STEP)
        self._data = [mujoco.MjData(self._model) for _ in range(threads)]
        self._pool = mujoco.rollout.Rollout(nthread=threads if threads > 1 else 0)
        command = batch.command
        held = np.searchsorted(command.t, np.arange(self._steps) * STEP + 1e-9, side="right") - 1
        self._torques = np.zeros((block, self._steps, self._model.nv))
        self._torques[:, :, 2:] = command.values[held]
        self._states = np.empty((block, self._steps, 1 + 2 * self._model.nv))
        self._sensors = np.empty((block, self._steps, 0))
        self._models: dict[int, mujoco.MjModel] = {}

    def prepare(self, which: range) -> None:
        """Make the models of some of the runs; it is not timed."""
        self._models = {k: self._varied(k) for k in which}

    def run(self, which: range) -> None:
        """Do some of the runs, every step of theirs stored (rollout knows no other way)."""
        first = np.zeros((len(which), 1 + 2 * self._model.nv))
        first[:, 1:3] = first[:, 3:5] = self.batch.starts[which]
        models = [self._models[k] for k in which]
        self._pool.rollout(
            models,
            self._data,
            first,
            self._torques[: len(which)],
            control_spec=mujoco.mjtState.mjSTATE_QFRC_APPLIED.value,
            state=self._states[: len(which)],
            sensordata=self._sensors[: len(which)],
        )

    def positions(self, which: range) -> Array:
        """[q, theta] on the grid (runs, samples, 4) [rad]."""
        self.prepare(which)
        self.run(which)
        between = round(1.0 / (RATE * STEP))
        first = np.hstack([self.batch.starts[which]] * 2)[:, None]
        return np.concatenate([first, self._states[: len(which), between - 1 :: between, 1:5]], axis=1)

    def _varied(self, k: int) -> mujoco.MjModel:
        if not self.batch.numbers:
            return self._model
        model = copy(self._model)
        stiffness, inertia, level = self.batch.factors[k]
        model.tendon_stiffness[:] *= stiffness
        model.body_inertia[3:] *= inertia[:, None]  # world, two links, two rotors
        model.dof_frictionloss[:2] *= level
        mujoco.mj_setConst(model, self._data[0])
        return model
