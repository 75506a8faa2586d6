"""Effects with unknown numbers, and what their classes try of them."""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.columns import of_effect
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.proposal import Point, Proposal, declared, extent_of
from flexdyn.effects import Effect, JointEffect
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.stated_tolerances import known_tolerances, unknown_parameters

Whiten = Callable[[Array], Array]


def by_effect(model: FlexibleJointModel) -> dict[int, tuple[str, ...]]:
    """Unknown numbers of effects by the effect's place."""
    found: defaultdict[int, tuple[str, ...]] = defaultdict(tuple)
    for i, name in unknown_parameters(model.tolerance, model.effects):
        found[i] += (name,)
    return dict(found)


def without_unknown(model: FlexibleJointModel) -> FlexibleJointModel:
    """The model whose effects with unknown numbers do nothing; they keep their places."""
    effects = list(model.effects)
    for i, names in by_effect(model).items():
        usual = type(effects[i]).example()
        changed = {name: getattr(usual, name) for name in names} | dict(effects[i].neutral)
        effects[i] = effects[i].replace(**changed)
    return model.replace(effects=effects, tolerance=known_tolerances(model.tolerance))


@dataclass(frozen=True)
class Unknown:
    """An effect with unknown numbers.

    Attributes:
        effect: that has a placeholder for each of them.
        names: of these numbers.
    """

    effect: JointEffect
    names: tuple[str, ...]

    @classmethod
    def of(cls, model: FlexibleJointModel, names: Mapping[int, tuple[str, ...]]) -> dict[int, Unknown]:
        """Those of a model, by the effect's place."""
        effects = ((i, model.effects[i]) for i in names)
        return {i: cls(effect, names[i]) for i, effect in effects if isinstance(effect, JointEffect)}

    @property
    def may_be_none(self) -> bool:
        """Whether no known number says that there is such an effect at all."""
        return set(self.effect.neutral) <= set(self.names)

    def proposal(self, equations: Equations) -> Proposal:
        """What its class tries along the motion, with the known numbers of the axes."""
        effect, kind = self.effect, type(self.effect)
        place = {key: getattr(effect, key) for key in ("joint", "side", "other") if hasattr(effect, key)}
        made = declared(kind, place, extent_of(equations, equations.true.index(effect.joint)))
        known = {k: getattr(effect, name) for k, name in enumerate(kind.axes) if name not in self.names}
        points = (tuple(known.get(k, value) for k, value in enumerate(point)) for point in made.grid)
        return dataclasses.replace(made, grid=tuple(dict.fromkeys(points)))

    def choices(self, equations: Equations, whiten: Whiten) -> list[Choice]:
        """What it does at every point of the grid.

        Args:
            equations: of the model without it.
            whiten: makes rows white, one or several columns of them.
        """
        proposal = self.proposal(equations)
        return [self._choice(proposal, point, equations, whiten) for point in proposal.grid]

    def _choice(self, proposal: Proposal, point: Point, equations: Equations, whiten: Whiten) -> Choice:
        kind, held = type(self.effect), np.zeros_like(equations.residual)
        free = [name in self.names for name in kind.linear] or [True] * len(proposal.sizes)
        known = [0.0 if each else getattr(self.effect, name) for each, name in zip(free, kind.linear, strict=False)]
        alone = proposal.make(point, known) if any(known) or proposal.fixed else None
        if alone is not None:
            held = of_effect(equations, self._with_known(alone))
        units = [] if proposal.fixed else [each for each, own in zip(proposal.units(point), free, strict=True) if own]
        rows = [of_effect(equations, self._with_known(effect), size) for effect, size in units]
        white = whiten(np.column_stack([held, *rows]))
        return Choice(self, proposal, point, white[:, 0], white[:, 1:], tuple(np.flatnonzero(free)))

    def _with_known(self, made: Effect) -> Effect:
        """An effect of the proposal with the known ones of the numbers that a proposal leaves at their default."""
        kept = {each.name for each in made.parameters() if each.default is not dataclasses.MISSING}
        return made.replace(**{name: getattr(self.effect, name) for name in kept - set(self.names)})


@dataclass(frozen=True, eq=False)
class Choice:
    """An effect at a point of its grid.

    Attributes:
        unknown: the effect.
        proposal: that has the grid.
        point: of it.
        held: what its known numbers do to the white residual (rows,).
        rows: what its unknown linear numbers do (rows, numbers).
        free: places of these among all linear numbers.
    """

    unknown: Unknown
    proposal: Proposal
    point: Point
    held: Array
    rows: Array
    free: tuple[int, ...]

    def effect(self, x: Array) -> Effect | None:
        """With the values of its unknown linear numbers; None: there is no such effect, or no value to start from."""
        effect, names = self.unknown.effect, self.unknown.names
        values = np.array([getattr(effect, name) for name in type(effect).linear] or [0.0] * len(self.proposal.sizes))
        values[list(self.free)] = np.where(np.array(self.proposal.positive)[list(self.free)], np.maximum(x, 0.0), x)
        made = self.proposal.make(self.point, values)
        if made is None:
            return None
        shape = [getattr(made, name) for name in names if name not in made.linear]
        known = {each.name: getattr(effect, each.name) for each in made.parameters() if each.name not in names}
        return made.replace(**known) if all(map(math.isfinite, shape)) and any(shape) else None
