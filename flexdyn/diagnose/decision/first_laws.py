"""First values of unknown numbers in which an effect's torque is not linear: the best of those that its class tries.

They are compared on the linear equations, together with the numbers of the file and the friction that every motor has.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from flexdyn.arrays import Array
from flexdyn.diagnose.constants import WORTHWHILE_GAIN
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.decision.first_regression import FirstRegression
from flexdyn.diagnose.decision.unknown_laws import Choice, Unknown
from flexdyn.diagnose.equations.columns import of_effect
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.regression import Regression
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
    plain = FirstRegression.of(model, data, _friction_of_motors)
    compared = plain.weighted(plain.solved())
    choices = {i: each.choices(compared.space.equations, compared.space.whiten) for i, each in unknown.items()}
    chosen: dict[int, Choice] = {}
    for _ in range(CHOICES_OF_ALL):
        for i, tried in choices.items():
            chosen.pop(i, None)
            allowed = [each for each in tried if _with_best_numbers(compared, each, chosen.values()) is not None]
            if not allowed:
                raise _untold(i, unknown[i])
            chosen[i] = min(allowed, key=lambda each: _fitted(compared, [each, *chosen.values()]).chi2)
        compared = compared.weighted(_fitted(compared, list(chosen.values())))
    return {i: _begun_with(i, chosen, choices[i], compared) for i in unknown}


def _begun_with(
    i: int, chosen: Mapping[int, Choice], tried: Sequence[Choice], compared: FirstRegression
) -> tuple[Effect, dict[str, float]]:
    """An effect with its first values, and the widths of its priors."""
    own, others = chosen[i], [each for k, each in chosen.items() if k != i]
    sets = [others] if own.unknown.may_be_none else [[each, *others] for each in tried]
    gain = max(_fitted(compared, each).chi2 for each in sets) - _fitted(compared, [own, *others]).chi2
    made = _with_best_numbers(compared, own, others)
    if made is None or 0.5 * gain < WORTHWHILE_GAIN:
        raise _untold(i, own.unknown)
    laws = [each for each in (_with_best_numbers(compared, one, others) for one in tried) if each is not None]
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


def _fitted(compared: FirstRegression, chosen: Sequence[Choice]) -> Regression:
    """The regression of some effects beside the numbers of the file."""
    return compared.solved([each.rows for each in chosen], [each.held for each in chosen])


def _with_best_numbers(compared: FirstRegression, own: Choice, others: Iterable[Choice]) -> Effect | None:
    """A choice with its best linear numbers beside others; None: it has none."""
    first = compared.X.shape[1]
    return own.effect(_fitted(compared, [own, *others]).values[first : first + len(own.free)])


def _friction_of_motors(equations: Equations) -> list[Array]:
    """Rows (rows,) of the friction that every motor has, of unit size, at every joint."""
    kinds = [each for each in registered().values() if each.prevalence == "everywhere" and each.regressed]
    made = (
        effect_from_dict({"effect": kind.name, "joint": joint, "side": "motor", **dict.fromkeys(kind.linear, 1.0)})
        for joint in equations.true.joint_names
        for kind in kinds
    )
    return [of_effect(equations, each) for each in made]
