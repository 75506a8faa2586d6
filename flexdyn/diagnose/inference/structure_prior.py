"""What is believed of drives before any data: how many joints have an effect, and which harmonics are likely."""

from __future__ import annotations

from collections import Counter

from scipy.special import betaln

from flexdyn.diagnose.constants import PLACE_BETA, PLAIN_BETA, UBIQUITOUS_BETA, WHOLE_NUMBER_LOG_ODDS
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.priors import EVERY_MOTOR
from flexdyn.effects import Effect, registered


def odds_of(group: str) -> tuple[float, float]:
    """Beta prior of the share of places at which effects of a group are."""
    if group.startswith(EVERY_MOTOR):
        return UBIQUITOUS_BETA
    return PLAIN_BETA if registered().get(group, Effect).prevalence == "everywhere" else PLACE_BETA


def log_places(chosen: Counter[str], places: Counter[str]) -> float:
    """Log prior of which laws are where: ``log B(m + a, n - m + b) - log B(a, n + b)`` for m of n places of a kind.

    Args:
        chosen: places of a structure, by group.
        places: places of all candidates, by group.
    """
    total = 0.0
    for kind, m in chosen.items():
        n, (a, b) = places[kind], odds_of(kind)
        total += float(betaln(m + a, n - m + b) - betaln(a, n + b))
    return total


def log_harmonic(candidate: Candidate, p: int) -> float:
    """Log prior of a grid point that is a harmonic, if it is one; of an effect that stands nothing is asked."""
    if not candidate.law.cycles or candidate.stands is not None:
        return 0.0
    harmonic = candidate.points[p][0]
    return 0.0 if harmonic in candidate.natural(harmonic) else -WHOLE_NUMBER_LOG_ODDS
