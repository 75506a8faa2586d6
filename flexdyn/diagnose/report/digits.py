"""Numbers as text: with as many digits as their uncertainty allows, in percent, as probabilities."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from flexdyn.diagnose.report.measures import SignalError
from flexdyn.diagnose.report.suspects import Number

UNCHANGED = 1e-3
"""A smaller change counts as none [%]."""
MINUS, NARROW = "\N{MINUS SIGN}", "\N{NARROW NO-BREAK SPACE}"
LIKELY = (
    (0.99, "virtually certain"),
    (0.95, "extremely likely"),
    (0.90, "very likely"),
    (0.66, "likely"),
    (0.50, "more likely than not"),
    (0.33, "about as likely as not"),
    (0.10, "unlikely"),
    (0.01, "very unlikely"),
    (0.0, "exceptionally unlikely"),
)
"""Words for a probability of so much or more: the calibrated language of the IPCC (Mastrandrea et al. 2010)."""
EVIDENCE = ((5.0, "very strong"), (3.0, "strong"), (1.0, "positive"), (0.0, "weak"))
"""Words for a log Bayes factor of so much or more: the scale of Kass and Raftery (1995), halved."""


def likely(probability: float) -> str:
    """A probability in words."""
    return next((word for least, word in LIKELY if probability >= least), "of unknown probability")


def probability_text(probability: float) -> str:
    """A probability with three decimals at most; never rounded up to one, nor above a half to the next threshold."""
    if not math.isfinite(probability):
        return "unknown"
    if probability > 0.999:
        return "above 0.999"
    if probability < 0.001:
        return "below 0.001"
    held = math.floor(1e3 * probability + 1e-9) / 1e3 if probability > 0.5 else probability
    return f"{held:.3f}".rstrip("0").rstrip(".")


def evidence_text(log_bayes_factor: float) -> str:
    """A log Bayes factor and how strong that is: ``406 (very strong evidence)``."""
    if math.isnan(log_bayes_factor):
        return "unknown"
    size, against = abs(log_bayes_factor), " against it" if log_bayes_factor < 0.0 else ""
    word = next(word for least, word in EVIDENCE if size >= least)
    return f"{log_text(log_bayes_factor)} ({word} evidence{against})"


def log_text(value: float) -> str:
    """A logarithm of an evidence or of a Bayes factor."""
    if not math.isfinite(value):
        return "unknown" if math.isnan(value) else f"{MINUS if value < 0.0 else ''}beyond measure"
    return grouped(value) if abs(value) >= 100.0 else signed(f"{value:.1f}")


def grouped(value: float) -> str:
    """A large number in groups of three digits."""
    return signed(f"{value:,.0f}".replace(",", NARROW))


def times(value: float) -> str:
    """A gap in units of noise."""
    if not math.isfinite(value):
        return _not_finite(value)
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"


def percent(share: float) -> str:
    """A share: whole percent, one decimal below ten percent."""
    if not math.isfinite(share):
        return _not_finite(share)
    size = 100.0 * share
    return signed(f"{size:.0f} %" if abs(size) >= 10.0 else f"{size:z.1f} %")  # z: no minus before what rounds to 0


def factor_text(factor: float) -> str:
    """A factor as what it changes: ``+23 %``, ``none``; from 3 on as it is."""
    if not math.isfinite(factor):
        return "unknown"
    if factor >= 3.0 or factor <= 1.0 / 3.0:
        return f"{factor:.3g} times what is given"
    size, sign = abs(100.0 * (factor - 1.0)), MINUS if factor < 1.0 else "+"
    if size < UNCHANGED:
        return "none"
    return f"{sign}{size:.0f} %" if size >= 10.0 else f"{sign}{size:.2g} %"


def rounded(value: float, digits: int = 3) -> str:
    """A number with so many significant digits."""
    if not math.isfinite(value):
        return _not_finite(value)
    return signed(f"{value:#.{digits}g}".rstrip(".")) if value else "0"


def errors_text(error: SignalError) -> str:
    """The errors of two models, as given and corrected, with their unit."""
    return f"{rounded(error.before)}, {rounded(error.after)} {error.unit}"


def value_text(value: float, std: float) -> str:
    """A number with as many digits as its uncertainty allows."""
    if not math.isfinite(value):
        return "unknown"
    if not math.isfinite(std) or std <= 0.0:
        return signed(f"{value:.4g}")
    size, last = (math.floor(math.log10(x)) for x in (max(abs(value), std), std))
    if -3 <= size < 5:
        return signed(f"{value:.{max(0, 1 - last)}f}")
    return signed(f"{value:.{size - last + 1}e}")


def estimate_text(number: Number) -> str:
    """A number with its 95 % interval in brackets and its unit: ``1.200 [1.102, 1.298] N m``."""
    value, ends = value_text(number.value, number.std), ""
    if math.isfinite(number.value) and math.isfinite(number.std) and number.std > 0.0:
        low, high = (value_text(end, number.std) for end in number.interval)
        ends = f" [{low}, {high}]"
    return f"{value}{ends} {unit_text(number.unit)}".strip()


def interval_text(number: Number) -> str:
    """The 95 % interval of a number, with its unit."""
    if not (math.isfinite(number.value) and math.isfinite(number.std)):
        return "not known"
    if number.std <= 0.0:
        return "chosen among a few, not measured"
    ends = " to ".join(value_text(end, number.std) for end in number.interval)
    return f"{ends} {unit_text(number.unit)}".strip()


def unit_text(unit: str) -> str:
    """A unit as it is written behind a number; empty if it is 1."""
    return "" if unit == "1" else unit


def largest(values: Iterable[float]) -> float:
    """The scale of several bars: the largest of the finite values; 1 where that is none or zero."""
    return max((value for value in values if math.isfinite(value)), default=1.0) or 1.0


def estimates(numbers: Mapping[str, Number]) -> str:
    """All numbers of an effect in a line."""
    return ", ".join(f"{name} {estimate_text(number)}" for name, number in numbers.items())


def counted(count: int, noun: str) -> str:
    """``1 number``, ``2 numbers``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def signed(text: str) -> str:
    """With a minus sign in place of the hyphen."""
    return text.replace("-", MINUS)


def _not_finite(value: float) -> str:
    return "unknown" if math.isnan(value) else "beyond measure"
