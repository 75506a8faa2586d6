"""fd.compare_models: numbers and effects over several models of one arm."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path

from flexdyn.diagnose.compared.compared_model import ComparedModel, Given, compared_model
from flexdyn.diagnose.compared.over_models import Course, EffectOverModels, ModelsCompared, NumberOverModels, Verdict
from flexdyn.diagnose.report.result import Diagnosis
from flexdyn.diagnose.report.suspects import Number
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel

CHANCE = 0.0027
"""Numbers moved where chance alone makes them differ so much less often than this [1]: three standard deviations."""
SMALL_CHANGE = 0.25
"""Numbers stayed where a change by so much of their mean would have been seen [1]."""


def compare_models(models: Sequence[Given], labels: Sequence[str] = ()) -> ModelsCompared:
    """Say which numbers of one arm's models moved by more than their uncertainty, and which effects came or went.

    Values are compared by a chi-squared test of the hypothesis that they are one number (Cochran's Q). They are
    uncertain by the standard deviations of the diagnosis, or by the tolerance of a model file that no diagnosis wrote.
    Numbers of links are factors on their URDF, so the models should have the same one.

    Args:
        models: two or more, each a `Diagnosis`, a model, a model file, or a folder that a diagnosis was saved in.
        labels: their names in the tables; none: names of the files, or A, B, C.

    Raises:
        InputError: less than two models, models of different arms, or labels that are not one a model.

    Example:
        >>> arm = fd.load_model("scara_two_link").replace(effects=[])
        >>> worn = arm.replace(effects=[fd.effects.Backlash("elbow", half_gap=1e-3)])
        >>> [(effect.name, effect.course) for effect in fd.compare_models([arm, worn]).effects]
        [('backlash in the transmission of elbow', 'appeared')]
    """
    if isinstance(models, str | Path | Diagnosis | FlexibleJointModel) or len(models) < 2:
        remedy = "give a list of two models or more"
        raise InputError("one model alone cannot be compared", key="models", remedy=remedy)
    if labels and (len(labels) != len(models) or len(set(labels)) != len(labels)):
        remedy = f"give {len(models)} different ones, or none"
        raise InputError("a label for each model is needed", key="labels", value=list(labels), remedy=remedy)
    models_ = [compared_model(*each) for each in zip(models, labels or _labels(models), strict=True)]
    for side in models_[1:]:
        if side.joints != models_[0].joints:
            remedy = f"{models_[0].label} has {', '.join(models_[0].joints)}"
            raise InputError("models of different arms", key=side.label, value=", ".join(side.joints), remedy=remedy)
    names = dict.fromkeys(name for side in models_ for name in side.numbers)
    numbers = [_number_over_models(name, models_) for name in names]
    effects = [_effect(name, models_) for name in dict.fromkeys(name for side in models_ for name in side.effects)]
    order = {"moved": 0, "stayed": 1, "not told": 2}
    shared = [each for each in numbers if sum(x is not None for x in each.values) > 1]
    return ModelsCompared(
        tuple(side.label for side in models_),
        tuple(sorted(shared, key=lambda each: order[each.verdict])),
        tuple(sorted(effects, key=lambda each: each.course == "in all")),
    )


def _labels(models: Sequence[Given]) -> list[str]:
    """Names of files and folders where they differ; else letters."""
    letters = [chr(ord("A") + k) if k < 26 else str(k + 1) for k in range(len(models))]
    found = []
    for given, letter in zip(models, letters, strict=True):
        path = Path(given) if isinstance(given, str | Path) else None
        name = "" if path is None else path.parent.name if path.name == "model.yaml" else path.stem or path.name
        found.append(name or letter)
    return found if len(set(found)) == len(found) else letters


def _number_over_models(name: str, models_: Sequence[ComparedModel]) -> NumberOverModels:
    values = tuple(side.numbers.get(name) for side in models_)
    there = [each for each in values if each is not None]
    probability, verdict = _same(there)
    return NumberOverModels(name, there[0].unit, values, verdict, probability)


def _same(values: Sequence[Number]) -> tuple[float, Verdict]:
    """How often chance makes one number look so different, and what that says.

    With weights w = 1/std^2 and the weighted mean m, ``Q = sum w (x - m)^2`` is chi-squared with one degree of freedom
    less than there are values (Cochran, 1954). A number without a standard deviation that is finite tells nothing; one
    whose standard deviation is 0 was given, or chosen among a few values.
    """
    known = [each for each in values if math.isfinite(each.value) and math.isfinite(each.std)]
    if len(known) < 2:
        return math.nan, "not told"
    scale = max(max(abs(each.value), each.std) for each in known) or 1.0  # huge and tiny numbers have no squares
    x, std = ([part / scale for part in parts] for parts in zip(*((e.value, e.std) for e in known), strict=True))
    widest = max(std)
    if widest == 0.0:
        same = all(each == x[0] for each in x)
        return (1.0, "stayed") if same else (0.0, "moved")
    from scipy.special import gammaincc

    weights = [max(each / widest, 1e-9) ** -2.0 for each in std]
    middle = sum(w * each for w, each in zip(weights, x, strict=True)) / sum(weights)
    away = [(each - middle) / widest for each in x]
    Q = sum(w * each * each for w, each in zip(weights, away, strict=True))
    probability = float(gammaincc(0.5 * (len(known) - 1), 0.5 * Q))
    if probability < CHANCE:
        return probability, "moved"
    least = 3.0 * math.sqrt(2.0) * widest  # a change between two that three standard deviations of it would show
    return probability, "stayed" if least <= SMALL_CHANGE * abs(sum(x) / len(x)) else "not told"


def _effect(name: str, models_: Sequence[ComparedModel]) -> EffectOverModels:
    there = tuple(name in side.effects for side in models_)
    odds = tuple(side.probability.get(name, math.nan) for side in models_)
    return EffectOverModels(name, there, odds, _course(there))


def _course(there: Sequence[bool]) -> Course:
    changes = [one != other for one, other in itertools.pairwise(there)]
    if all(there):
        return "in all"
    if sum(changes) == 1:
        return "appeared" if there[-1] else "vanished"
    return "in some"
