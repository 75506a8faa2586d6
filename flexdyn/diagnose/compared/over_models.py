"""Result of a comparison of models: its numbers and effects over the models, and their tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from flexdyn.diagnose.report.digits import probability_text, value_text
from flexdyn.diagnose.report.suspects import Number
from flexdyn.io.notebook import Public, card, html_table

Verdict = Literal["moved", "stayed", "not told"]
Course = Literal["in all", "appeared", "vanished", "in some"]


@dataclass(frozen=True)
class NumberOverModels:
    """A number over the models.

    Attributes:
        name: what it is of, such as "stiffness of elbow".
        unit: of its values; 1: a factor on what the URDF gives.
        values: one a model; None where the model has no such number.
        verdict: ``moved``: the values differ by more than their uncertainty; ``stayed``: they do not, and a change of a
            quarter would have been seen; ``not told``: they are too uncertain to say.
        probability: that equal numbers with these uncertainties differ so much by chance [1]; NaN of less than two.
    """

    name: str
    unit: str
    values: tuple[Number | None, ...]
    verdict: Verdict
    probability: float

    @property
    def ratio(self) -> float:
        """Largest over smallest size [1]."""
        sizes = [abs(each.value) for each in self.values if each is not None]
        return max(sizes) / min(sizes) if sizes and min(sizes) > 0.0 else math.inf


@dataclass(frozen=True)
class EffectOverModels:
    """An effect over the models.

    Attributes:
        name: what it is and where it acts, such as "backlash in the transmission of elbow".
        there: whether each model has it.
        probabilities: of the effect in each: 1 where the file gave it; NaN where nobody compared it.
        course: ``in all``; ``appeared``: the first models lack it and the last have it; ``vanished``: the other way
            round; ``in some``.
    """

    name: str
    there: tuple[bool, ...]
    probabilities: tuple[float, ...]
    course: Course


@dataclass(frozen=True, repr=False)
class ModelsCompared(Public):
    """Several models of one arm side by side; `print` shows it as a table.

    Attributes:
        labels: of the models, in the order given.
        numbers: those that two models or more have; what moved comes first.
        effects: of all models; what is not in all of them comes first.

    Example:
        >>> arm = fd.load_model("scara_two_link").replace(tolerance=0.01)
        >>> worn = arm.replace(joints={"elbow": {"stiffness": 0.8 * arm.joints["elbow"].stiffness}})
        >>> found = fd.compare_models([arm, worn], labels=["new", "worn"])
        >>> [number.name for number in found.moved]
        ['stiffness of elbow']
    """

    labels: tuple[str, ...]
    numbers: tuple[NumberOverModels, ...]
    effects: tuple[EffectOverModels, ...]

    @property
    def moved(self) -> tuple[NumberOverModels, ...]:
        """Numbers that differ by more than their uncertainty."""
        return tuple(each for each in self.numbers if each.verdict == "moved")

    @property
    def stayed(self) -> tuple[NumberOverModels, ...]:
        """Numbers that do not differ, and are known well enough to say so."""
        return tuple(each for each in self.numbers if each.verdict == "stayed")

    def to_dict(self) -> dict[str, Any]:
        """Everything, as JSON can hold it; a number that is not finite is NaN."""
        return {
            "labels": list(self.labels),
            "numbers": [asdict(each) for each in self.numbers],
            "effects": [asdict(each) for each in self.effects],
        }

    def number_rows(self) -> list[list[str]]:
        """A row a number: its name, a value a model, how often chance differs so much, and what became of it."""
        return [
            [
                f"{each.name} [{each.unit}]",
                *("-" if x is None else _estimate(x) for x in each.values),
                "-" if math.isnan(each.probability) else probability_text(each.probability),
                each.verdict,
            ]
            for each in self.numbers
        ]

    def effect_rows(self) -> list[list[str]]:
        """A row an effect: its name, its probability in each model, and what became of it."""
        return [
            [each.name, *(_there(here, p) for here, p in zip(each.there, each.probabilities, strict=True)), each.course]
            for each in self.effects
        ]

    @property
    def heads(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Heads of `number_rows` and of `effect_rows`."""
        return ("number", *self.labels, "by chance", ""), ("effect", *self.labels, "")

    def __repr__(self) -> str:
        """How many moved and how many stayed, in a line."""
        changed = sum(each.course != "in all" for each in self.effects)
        counts = f"{len(self.moved)} numbers moved, {len(self.stayed)} stayed, {changed} effects not in all"
        return f"<ModelsCompared of {', '.join(self.labels)}: {counts}>"

    def __str__(self) -> str:
        """The tables as text."""
        numbers, effects = self.heads
        return "\n".join([*_lined([numbers, *self.number_rows()]), *_lined([effects, *self.effect_rows()])])

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        numbers, effects = self.heads
        return card(
            repr(self)[1:-1], {}, html_table(numbers, self.number_rows()), html_table(effects, self.effect_rows())
        )


def _lined(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of a table as lines."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def _estimate(number: Number) -> str:
    text = value_text(number.value, number.std)
    return text if not number.std > 0.0 else f"{text} +- {value_text(number.std, number.std)}"


def _there(here: bool, probability: float) -> str:
    if here:
        return "yes" if not probability < 1.0 else f"yes ({probability_text(probability)})"
    return "no" if not math.isfinite(probability) else f"no ({probability_text(probability)})"
