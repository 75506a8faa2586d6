"""Runs of one model that differ only in numbers: they are integrated together, without a model for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexdyn import _core
from flexdyn.arrays import Array, Flags
from flexdyn.effects import Effect, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.simulation.command_input import Drive
from flexdyn.simulation.initial_state import first_states
from flexdyn.simulation.inputs_and_signals import SIGNALS
from flexdyn.simulation.laws import acting_effects, core_law
from flexdyn.simulation.link_side import build_links, moves_inertia
from flexdyn.simulation.solver_choice import budget, core_settings
from flexdyn.simulation.solvers import Solver

Numbers = Mapping[Any, Mapping[str, Array]]
Progress = Callable[[int], None] | None


@dataclass(frozen=True, kw_only=True)
class VariantColumns:
    """The numbers that differ, each a column (runs,).

    Attributes:
        joints: joint -> number of its drive -> column.
        effects: index of the effect in the model -> parameter -> column.
        initial: signal -> joint -> a column, or a number that is the same for all.
        starts: the arguments q0, v0, theta0, omega0 of `simulate`: signal -> joint -> column.
    """

    joints: Numbers
    effects: Numbers
    initial: Mapping[str, Mapping[str, Any]]
    starts: Numbers


class Variants:
    """A model whose numbers differ from run to run.

    Args:
        model: one of the runs' models.
        drive: the prepared command of all runs.
        duration: of each [s].
        solver: of all.
        grid: times of the samples [s].
    """

    def __init__(self, model: FlexibleJointModel, drive: Drive, duration: float, solver: Solver, grid: Array) -> None:
        self.model, self.drive, self.duration, self.solver, self.grid = model, drive, duration, solver, grid

    def covers(self, columns: VariantColumns) -> bool:
        """Whether these numbers enter the plant directly: through springs, rotors, laws and the first state.

        They do not if they change other numbers or the links, or if they need more checks than their own bounds.
        """
        model, effects = self.model, [self.model.effects[i] for i in columns.effects]
        return (
            model.resolved() is model
            and model.rotor_coupling == "reduced"
            and not any(effect.is_python for effect in self._acting)
            and all(model.joints[joint].elastic for joint in columns.joints)
            and all(model.joints[joint].actuator is None for joint in columns.joints)
            and all(any(effect is each for each in self._acting) and _is_plain(effect) for effect in effects)
        )

    def simulate(self, columns: VariantColumns, out: Mapping[str, Array], progress: Progress) -> Flags:
        """Integrate the runs on this thread, without the interpreter's lock; each result equals that of `simulate`.

        Args:
            columns: numbers that the model `covers`.
            out: filled by this function: signal -> (runs, samples, n).
            progress: called with the number of finished runs about ten times a second.

        Returns:
            (runs,) whether a run is finished. The rows of other runs have no meaning: these runs failed or might fail.

        Raises:
            InputError: the first states are not allowed in any run.
        """
        count = len(out["q"])
        done = np.ones(count, dtype=bool)
        drives = self._drives(columns.joints, done)
        parameters = self._parameters(columns.effects, done)
        for numbers in (*columns.initial.values(), *columns.starts.values()):
            for value in numbers.values():
                done &= np.isfinite(value)
        done &= self._moves(columns.initial.get("q", {}), count)
        x0 = first_states(self.model, self.drive, columns.initial, columns.starts, count)
        settings = core_settings(self.solver, max_steps=budget(self.solver, self.duration))
        arrays = [out[signal] for signal in SIGNALS]
        made = (*drives, parameters, self.drive.command, x0, self.duration, settings, self.grid, arrays, done)
        _core.simulate_pack(self._links, self._laws, *made, 1, progress)
        return done

    @cached_property
    def _acting(self) -> list[Effect]:
        return acting_effects(self.model)

    @cached_property
    def _laws(self) -> list[_core.Law]:
        return [core_law(self.model, effect) for effect in self._acting]

    @cached_property
    def _links(self) -> _core.LinkDynamics:
        return build_links(self.model)

    def _drives(self, joints: Numbers, sound: Flags) -> tuple[Array, Array, Array]:
        """K, D and J (runs, n); `sound` is cleared where a number might be refused."""
        model, shape = self.model, (len(sound), self.model.n)
        own = (model.stiffness, model.damping, model.rotor_inertia)
        K, D, J = (np.array(np.broadcast_to(base, shape)) for base in own)
        for name, columns in joints.items():
            j, numbers = model.index(name), {**model.joints[name].values(), **columns}
            for column in columns.values():
                sound &= (column > 0.0) & np.isfinite(column)
            K[:, j], D[:, j] = numbers["stiffness"], numbers["damping"]
            with np.errstate(over="ignore"):
                J[:, j] = numbers["gear_ratio"] * numbers["gear_ratio"] * numbers["rotor_inertia"]
            sound &= (J[:, j] > 0.0) & np.isfinite(J[:, j])
        return K, D, J

    def _parameters(self, effects: Numbers, sound: Flags) -> Array:
        """Parameters of the laws (runs, laws, max_law_parameters); clears `sound` if one is refused or neutral."""
        base = np.zeros((len(self._acting), _core.max_law_parameters))
        for law, effect in enumerate(self._acting):
            base[law, : len(effect.values)] = effect.values
        table = np.array(np.broadcast_to(base, (len(sound), *base.shape)))
        for i, columns in effects.items():
            effect = self.model.effects[i]
            law = next(law for law, each in enumerate(self._acting) if each is effect)
            for place, parameter in enumerate(effect.parameters()):
                if parameter.name not in columns:
                    continue
                column = columns[parameter.name]
                table[:, law, place] = column
                sound &= (column > parameter.metadata["lower"]) & np.isfinite(column)
                sound &= column != effect.neutral.get(parameter.name, np.nan)
        return table

    def _moves(self, q: Mapping[str, Any], count: int) -> Flags:
        """Whether every joint moves an inertia at the model's own first positions (runs,)."""
        entries = [np.broadcast_to(q.get(joint, 0.0), count) for joint in self.model.joint_names]
        return moves_inertia(self._links, np.nan_to_num(np.stack(entries, axis=1)))


def _is_plain(effect: Effect) -> bool:
    """Whether its numbers are checked only against their own bounds."""
    return type(effect).__post_init__ in (Effect.__post_init__, JointEffect.__post_init__)
