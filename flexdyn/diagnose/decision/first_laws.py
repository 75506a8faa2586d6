"""First values of unknown numbers in which an effect's torque is not linear: the best of those that its class tries.

They are compared on the linear equations, together with the numbers of the file and the friction that every motor has.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import WORTHWHILE_GAIN
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.decision.unknown_laws import Choice, Unknown
from flexdyn.diagnose.decision.unknown_stiffnesses import weighted_regression
from flexdyn.diagnose.equations.columns import of_effect
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.weights import rows_of
from flexdyn.effects import Effect, effect_from_dict, registered
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.model.given_number import UNKNOWN
from flexdyn.model.uncertain_parameters import UNKNOWN_TOLERANCE

CHOICES_OF_ALL = 4
"""Number of times that the equations are weighted by what the last choice left, and the effects are chosen anew."""
Laws = dict[int, tuple[Effect, dict[str, float]]]


def first_laws(model: FlexibleJointModel, unknown: Mapping[int, Unknown], data: tuple[Measured, ...]) -> Laws:
    """Effects whose unknown numbers have the values that explain most, and prior widths of those that are not linear.

    Each effect is chosen beside the present choice of the others. A width is ten times the largest value that was
    compared, of an angle at least ten half turns.

    Args:
        model: with effects that do nothing in their places, without other unknown numbers.
        unknown: the effects by their places.
        data: of the fit.

    Raises:
        InputError: all rows are masked, or the data do not tell the numbers.
    """
    if not unknown:
        return {}
    compared = _Comparison.of(model, data)
    choices = {i: each.choices(compared.space.equations, compared.space.whiten) for i, each in unknown.items()}
    chosen: dict[int, Choice] = {}
    for _ in range(CHOICES_OF_ALL):
        for i, tried in choices.items():
            chosen.pop(i, None)
            allowed = [each for each in tried if compared.effect(each, chosen.values()) is not None]
            if not allowed:
                raise _untold(i, unknown[i])
            chosen[i] = min(allowed, key=lambda each: compared.left(each, *chosen.values()))
        compared = compared.weighted(tuple(chosen.values()))
    return {i: _begun_with(i, chosen, choices[i], compared) for i in unknown}


def _begun_with(
    i: int, chosen: Mapping[int, Choice], tried: Sequence[Choice], compared: _Comparison
) -> tuple[Effect, dict[str, float]]:
    """An effect with its first values, and the widths of its priors."""
    own, others = chosen[i], [each for k, each in chosen.items() if k != i]
    every = [compared.left(*others)] if own.unknown.may_be_none else [compared.left(each, *others) for each in tried]
    made = compared.effect(own, others)
    if made is None or 0.5 * (max(every) - compared.left(own, *others)) < WORTHWHILE_GAIN:
        raise _untold(i, own.unknown)
    laws = [each for each in (compared.effect(one, others) for one in tried) if each is not None]
    widths = {}
    for name in own.unknown.names:
        if name not in made.linear:
            largest = max(abs(getattr(each, name)) for each in laws if math.isfinite(getattr(each, name)))
            widths[name] = UNKNOWN_TOLERANCE * max(largest, math.pi if made.declared(name)["around"] else 0.0)
    return made, widths


def _untold(i: int, unknown: Unknown) -> InputError:
    name = next(each for each in unknown.names if each not in unknown.effect.linear)
    remedy = "give it a value with a tolerance, or leave the effect out: a diagnosis finds it where the data show it"
    return InputError("these data do not tell it", key=f"effects[{i}].{name}", value=UNKNOWN, remedy=remedy)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Least squares of effects beside the numbers of the file.

    Attributes:
        space: of the model without the effects.
        y: white residual (rows,).
        X: of the file's numbers and of the friction that every motor has (rows, columns).
        sigma: prior standard deviations of these columns; inf: none.
        size: what each equation leaves, in standard deviations of its noise (equations,).
    """

    space: Workspace
    y: Array
    X: Array
    sigma: Array
    size: Array

    @classmethod
    def of(cls, model: FlexibleJointModel, data: tuple[Measured, ...]) -> _Comparison:
        bare, start = prepared(model, data)
        space = weighed(bare)
        friction = [of_effect(bare.equations, each) for each in _of_every_motor(bare.equations)]
        sigma = [max(number.tolerance, 1e-9) for number in start.factors] + [math.inf] * len(friction)
        X = np.column_stack([space.numbers, space.whiten(np.column_stack(friction))])
        y = space.whiten(bare.equations.residual)
        return cls(space, y, X, np.array(sigma), np.ones(len(bare.equations.kinds))).weighted(())

    def weighted(self, chosen: Sequence[Choice]) -> _Comparison:
        """The same with the weights of what these effects leave."""
        plain = self._made(chosen)
        left = plain.left[: len(self.y)].reshape(-1, len(self.size)) * self.size
        seen = rows_of(self.space.bare)
        return dataclasses.replace(self, size=ModelError.of(left, seen).scale)

    def left(self, *chosen: Choice) -> float:
        """Sum of squares."""
        return self._made(chosen).chi2

    def effect(self, own: Choice, others: Iterable[Choice]) -> Effect | None:
        """A choice with its best linear numbers; None: it has none."""
        first = self.X.shape[1]
        return own.effect(self._made([own, *others]).values[first : first + len(own.free)])

    def _made(self, chosen: Sequence[Choice]) -> Regression:
        y = self.y + sum((each.held for each in chosen), np.zeros_like(self.y))
        X = np.column_stack([self.X, *(each.rows for each in chosen), self.space.nuisance])
        free = sum(each.rows.shape[1] for each in chosen)
        return weighted_regression(self.space, y, X, np.append(self.sigma, np.full(free, math.inf)), self.size)


def _of_every_motor(equations: Equations) -> list[Effect]:
    """Friction that every motor has, of unit size, at every joint."""
    kinds = [each for each in registered().values() if each.prevalence == "everywhere" and each.regressed]
    return [
        effect_from_dict({"effect": kind.name, "joint": joint, "side": "motor", **dict.fromkeys(kind.linear, 1.0)})
        for joint in equations.true.joint_names
        for kind in kinds
    ]
