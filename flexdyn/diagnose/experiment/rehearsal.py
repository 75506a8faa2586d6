"""A motion tried by simulation: simulated with one hypothesis, and fitted with the others."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.control.commands import PD, Samples
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.experiment.apart import Known, Refit, as_made, loaded, refitted, space_along, windowed
from flexdyn.diagnose.experiment.moves import PlannedMotion
from flexdyn.diagnose.experiment.reach import Reach
from flexdyn.diagnose.hypothesis.fitted import Workspace
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import JointEffect, MemoryEffect, Payload
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.plant import LinkSide, acting_effects
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solver_choice import STIFF
from flexdyn.simulation.solvers import Rosenbrock, Solver

RUNAWAY_TIME = 20.0
"""Processor time after which a motion counts as divergent and is stopped [s]: others need a hundredth of it."""
WINDOWS = 10
"""Largest number of windows of a motion that are used; their result is scaled to all windows."""
Pair = tuple[Refit, Refit]


@dataclass(frozen=True, eq=False)
class Side:
    """A motion that is simulated with one hypothesis.

    Attributes:
        truth: index of this hypothesis.
        run: the motion.
        recording: its recording, without noise.
        space: the equations along it.
        by_equations: residuals of this hypothesis, and of each one that it is compared with.
        by_windows: the same for simulated windows; empty if they were not used.
    """

    truth: int
    run: Run
    recording: Recording
    space: Workspace
    by_equations: tuple[Pair, ...]
    by_windows: tuple[Pair, ...] = ()

    def apart(self, passes: int) -> list[float]:
        """Expected delta BIC of this hypothesis to each of the others."""
        kinds = [pairs for pairs in (self.by_equations, self.by_windows) if pairs]
        return [
            max(*(other.chi2(passes) - own.chi2(passes) for own, other in pairs), 0.0)
            for pairs in zip(*kinds, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """A motion, and the differences of the hypotheses for it.

    Attributes:
        move: the motion.
        command: that makes it.
        sides: simulated with the named hypothesis, then, if needed, with each of its rivals.
    """

    move: PlannedMotion
    command: PD
    sides: tuple[Side, ...]

    @property
    def seconds(self) -> float:
        """Duration of one pass [s]."""
        return float(self.command.reference.duration)

    def apart(self, passes: int = 1) -> float:
        """Expected delta BIC of the right hypothesis to the nearest other one, if the motion is repeated."""
        return min(min(side.apart(passes)) for side in self.sides)

    @property
    def reversals(self) -> int:
        """Number of reversals of the joint."""
        way = np.sign(np.round(np.diff(self.sides[0].run.theta[:, self.move.joint]), 9))
        way = way[way != 0.0]
        return int((way[1:] != way[:-1]).sum())

    @property
    def nearest(self) -> int:
        """Index of the rival with the smallest difference from the named hypothesis."""
        return int(np.argmin(self.sides[0].apart(1)))


@dataclass(frozen=True, eq=False)
class RehearsalBench:
    """Hypotheses, and the data with which they are tried.

    Attributes:
        space: of the recordings.
        noise: of their channels.
        known: the named hypothesis, then its rivals.
        reach: of the arm.
    """

    space: Workspace
    noise: SampleNoise
    known: tuple[Known, ...]
    reach: Reach

    def rehearse(self, move: PlannedMotion) -> Rehearsal:
        """The motion simulated with the named hypothesis, evaluated by the equations.

        Raises:
            InputError: it exceeds the motions in the recordings.
            SimulationError: it cannot be simulated.
        """
        command = self._command(move)
        return Rehearsal(move, command, (self._side(0, move, command),))

    def closer(self, made: Rehearsal, worth: float) -> Rehearsal:
        """The same, also evaluated by simulated windows, which include reversals.

        Args:
            made: of one motion.
            worth: sum of squares below which windows give no information.
        """
        return replace(made, sides=tuple(self._windowed(side, made.move, worth) for side in made.sides))

    def from_all_sides(self, made: Rehearsal, worth: float) -> Rehearsal:
        """The same motion, also simulated with each of the rivals.

        A rival that would make the arm leave what it has been seen to do is left out: the arm itself would show that.

        Raises:
            SimulationError: it cannot be simulated.
        """
        sides = list(made.sides[:1])
        for k in range(1, len(self.known)):
            with contextlib.suppress(InputError):
                side = self._side(k, made.move, self._command(made.move, k))
                sides.append(self._windowed(side, made.move, worth) if sides[0].by_windows else side)
        return replace(made, sides=tuple(sides))

    def windows(self, recording: Recording) -> Windows:
        """A few windows of a simulated motion."""
        return Windows.of(self.space.equations.true, [recording], self.noise, most=WINDOWS)

    def load(self, move: PlannedMotion) -> Payload | None:
        """The payload in a motion."""
        return Payload(mass=move.mass, frame=self.space.equations.true.robot.tip) if move.mass else None

    def others(self, truth: int) -> list[Known]:
        """The hypotheses to compare with: for the named one its rivals, for a rival the named one."""
        return list(self.known[1:] if truth == 0 else self.known[:1])

    def _side(self, truth: int, move: PlannedMotion, command: PD) -> Side:
        load = self.load(move)
        run, recording = self._made(truth, move, command)
        numbers = self.known[0].fitted.hypothesis.factors
        space = space_along(self.space, numbers, measured(self.space.equations.true, recording), self.noise, load)
        own = refitted(self.known[truth], space, load, steps=1)
        pairs = tuple((own, refitted(other, space, load)) for other in self.others(truth))
        return Side(truth, run, recording, space, pairs)

    def _windowed(self, side: Side, move: PlannedMotion, worth: float) -> Side:
        load = self.load(move)
        model = self.known[side.truth].with_load(load).seen()
        shot = shoot(model, self.windows(side.recording))
        own = as_made(shot)
        pairs = tuple((own, windowed(other, shot, load, own.chi2() + worth)) for other in self.others(side.truth))
        return replace(side, by_windows=pairs)

    def _command(self, move: PlannedMotion, truth: int = 0) -> PD:
        """Joint control with what the rigid arm and a hypothesis' friction and offsets need fed forward."""
        reach, true = self.reach, self.space.equations.true
        links, dt = LinkSide(loaded(true, self.load(move))), reach.dt
        t = np.arange(len(move.path)) * dt
        v = np.gradient(move.path, dt, axis=0)
        a = np.gradient(v, dt, axis=0)
        needed = np.einsum("tij,tj->ti", links.mass_matrix(move.path), a) + links.bias(move.path, v)
        needed += np.where(true.elastic, true.rotor_inertia, 0.0) * a
        needed += move.push + self._opposed(truth, move.path, v)
        path, torques = Samples(t, move.path, "cubic"), Samples(t, needed)
        return PD(path, reach.kp, reach.kd, 1.0 / dt, feedforward=torques)

    def _opposed(self, truth: int, path: Array, v: Array) -> Array:
        """Torque (samples, n) against friction and offsets of a hypothesis: a real arm follows its path anyway."""
        total = np.zeros_like(path)
        for effect in self.known[truth].fitted.hypothesis.effects:
            if not isinstance(effect, JointEffect) or isinstance(effect, MemoryEffect) or effect.is_python:
                continue
            j = self.space.equations.true.index(effect.joint)
            if effect.is_constant:
                total[:, j] -= effect.torque(path[:, j], v[:, j])
            elif effect.stage in ("friction", "dry") and not effect.takes_load:
                total[:, j] += effect.torque(path[:, j], v[:, j])
        return total

    def _made(self, truth: int, move: PlannedMotion, command: PD) -> tuple[Run, Recording]:
        """The run and its recording."""
        model = self.known[truth].with_load(self.load(move)).seen()
        seconds, rate, start = command.reference.duration, 1.0 / self.reach.dt, move.path[0]
        end = time.process_time() + RUNAWAY_TIME

        def watch(reached: float) -> None:
            if time.process_time() > end:
                raise InputError("it runs away", key="t", value=reached)

        solver = _solver(model, move.path, self.reach.dt)
        run = simulate(model, command, seconds, solver, q0=start, theta0="equilibrium", rate=rate, progress=watch)
        if not self.reach.holds(run.q, run.v, run.tau):
            raise InputError("beyond the motions in the recordings", key="motion", value=move.words)
        whole = run.to_recording()
        kept = {name: values for name, values in whole.channels.items() if self._is_measured(name)}
        units = {name: unit for name, unit in whole.meta.get("units", {}).items() if name in kept}
        return run, Recording(run.t, kept, meta={"units": units} if units else None, name="rehearsal")

    def _is_measured(self, channel: str) -> bool:
        signal, _, joint = channel.partition(".")
        there = getattr(self.space.equations.data[0], f"has_{signal}", None)
        return signal == "tau" or (there is not None and bool(there[self.space.equations.true.index(joint)]))


def _solver(model: FlexibleJointModel, path: Array, dt: float) -> Solver | str:
    """The solver; for stiff bristles the implicit one, because at rest, where the arm starts, they are stiff.

    Args:
        model: that is simulated.
        path: that it is to follow (samples, n).
        dt: between its samples [s].
    """
    fastest = float(np.abs(np.gradient(path, dt, axis=0)).max())
    memories = (each for each in acting_effects(model.resolved()) if isinstance(each, MemoryEffect))
    stiff = any(fastest > STIFF * each.reach for each in memories if each.reach > 0.0)
    return Rosenbrock() if stiff else "auto"
