"""Where motions are tried: each is simulated with one hypothesis, and the others are fitted to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexdyn.arrays import Array
from flexdyn.control.commands import PD
from flexdyn.control.samples import Samples
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.experiment.apart import Known, Refit, refitted, space_along, windowed
from flexdyn.diagnose.experiment.moves import PlannedMotion
from flexdyn.diagnose.experiment.reach import Reach, with_load
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.workspace import Workspace
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import JointEffect, MemoryEffect
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.simulation.laws import acting_effects
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate
from flexdyn.simulation.solver_choice import STIFF
from flexdyn.simulation.solvers import Rosenbrock, Solver

WINDOWS = 10
"""Largest number of windows of a motion that are used."""
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
class RehearsalBench:
    """Hypotheses about an arm, and the data with which they are tried.

    Attributes:
        space: of the recordings.
        known: the named hypothesis, then its rivals.
        reach: of the arm.
    """

    space: Workspace
    known: tuple[Known, ...]
    reach: Reach

    @classmethod
    def of(cls, fits: Sequence[Fit]) -> RehearsalBench:
        """Of the fit with the finding, then of those with each rival instead."""
        space = fits[0].space
        calibrated = replace(fits[0].hypothesis, effects=()).model()
        return cls(space, tuple(map(Known.of, fits)), Reach.of(space.equations, calibrated))

    def loaded(self, mass: float) -> RehearsalBench:
        """The same arm with a payload [kg] at its tip."""
        if not mass:
            return self
        equations = self.space.equations
        space = self.space.with_equations(replace(equations, model=with_load(equations.model, mass)))
        return replace(self, space=space, known=tuple(each.loaded(mass) for each in self.known))

    def side(self, truth: int, move: PlannedMotion) -> Side:
        """The motion simulated with a hypothesis, evaluated by the equations.

        Raises:
            InputError: it exceeds the motions in the recordings.
            SimulationError: it cannot be simulated.
        """
        run = self._run(truth, move)
        whole = run.to_recording().channels.items()
        kept = {name: values for name, values in whole if self._is_measured(name)}
        recording = Recording(run.t, kept, name="rehearsal")
        data = measured(self.space.equations.true, recording)
        space = space_along(self.space, self.known[0].hypothesis.factors, data)
        own = refitted(self.known[truth], space, steps=1)
        return Side(truth, run, recording, space, self._pairs(truth, own, lambda other: refitted(other, space)))

    def with_windows(self, side: Side, worth: float) -> Side:
        """The same, also evaluated by simulated windows, which include reversals.

        Args:
            side: a motion.
            worth: sum of squares below which windows give no information.
        """
        own = self.known[side.truth]
        shot = shoot(own.hypothesis.seen(), self.windows(side.recording))
        made = windowed(own, shot)
        limit = made.chi2() + worth
        return replace(side, by_windows=self._pairs(side.truth, made, lambda other: windowed(other, shot, limit)))

    def windows(self, recording: Recording) -> Windows:
        """A few windows of a simulated motion."""
        return Windows.of(self.space.equations.true, [recording], self.space.noise, most=WINDOWS)

    def _pairs(self, truth: int, own: Refit, refit: Callable[[Known], Refit]) -> tuple[Pair, ...]:
        """With the refits of those to compare with: of the rivals for the named hypothesis, of that one for a rival."""
        return tuple((own, refit(other)) for other in (self.known[1:] if truth == 0 else self.known[:1]))

    def command(self, truth: int, move: PlannedMotion) -> PD:
        """Joint control with what the rigid arm and a hypothesis' friction and offsets need fed forward."""
        reach, true, dt = self.reach, self.space.equations.true, self.reach.dt
        links = LinkSide(true)
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
        for effect in self.known[truth].hypothesis.effects:
            if not isinstance(effect, JointEffect) or isinstance(effect, MemoryEffect) or effect.is_python:
                continue
            j = self.space.equations.true.index(effect.joint)
            if effect.is_constant:
                total[:, j] -= effect.torque(path[:, j], v[:, j])
            elif effect.stage in ("friction", "dry") and not effect.takes_load:
                total[:, j] += effect.torque(path[:, j], v[:, j])
        return total

    def _run(self, truth: int, move: PlannedMotion) -> Run:
        """The motion as a truth makes it, under its controller; refuses one that leaves what the recordings cover."""
        model, command, rate = self.known[truth].hypothesis.seen(), self.command(truth, move), 1.0 / self.reach.dt
        solver, seconds = _solver(model, move.path, self.reach.dt), command.reference.duration
        run = simulate(model, command, seconds, solver, q0=move.path[0], theta0="equilibrium", rate=rate)
        if not self.reach.holds(run.q, run.v, run.tau):
            raise InputError("beyond the motions in the recordings", key="motion", value=move.words)
        return run

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
