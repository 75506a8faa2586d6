"""What is believed of drives before any data: how many joints have an effect, and which harmonics are likely."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from scipy.special import betaln

from flexdyn.diagnose.constants import PLACE_BETA, PLAIN_BETA, UBIQUITOUS_BETA, WHOLE_NUMBER_LOG_ODDS
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.priors import EVERY_MOTOR
from flexdyn.diagnose.lazy import kept, lazy
from flexdyn.effects import Effect, registered


def odds_of(group: str) -> tuple[float, float]:
    """Beta prior of the share of places at which effects of a group are."""
    if group.startswith(EVERY_MOTOR):
        return UBIQUITOUS_BETA
    return PLAIN_BETA if registered().get(group, Effect).prevalence == "everywhere" else PLACE_BETA


class PriorOfPlaces:
    """Log prior of which laws are where: what is believed of drives beforehand, whatever the data say.

    Args:
        candidates: all of them.

    Attributes:
        counts: places of all candidates, by group.
    """

    def __init__(self, candidates: Sequence[Candidate]) -> None:
        self.candidates = candidates
        self.counts = Counter(each.group for each in candidates)

    def log_prior(self, structure: Iterable[tuple[int, int]]) -> float:
        """Of a structure's candidates, whatever their grid points: see `_of_candidates`."""
        return self._of_candidates(frozenset(c for c, _ in structure))

    def log_odds(self, c: int) -> float:
        """Prior log odds that a candidate is there, and nothing else of its kind."""
        return self._of_candidates(frozenset({c}))

    @kept
    def _of_candidates(self, held: frozenset[int]) -> float:
        """``log B(m + a, n - m + b) - log B(a, n + b)`` for m of n places of a kind, added up."""
        total = 0.0
        for kind, m in Counter(group for group, _ in self.taken(held)).items():
            n, (a, b) = self.counts[kind], odds_of(kind)
            total += float(betaln(m + a, n - m + b) - betaln(a, n + b))
        return total

    def taken(self, held: Iterable[int]) -> list[tuple[str, object]]:
        """Groups of which some candidates are, with the places where; two laws of one place count once there."""
        there = ((group, self.place_in(group, c)) for c in sorted(held) for group in self.groups[c])
        return list(dict.fromkeys(there))

    def place_in(self, group: str, c: int) -> object:
        """The place at which a candidate counts in a group: its joint and side, where several laws are of the group."""
        return self.candidates[c].spot if group.startswith(EVERY_MOTOR) else c

    @lazy
    def groups(self) -> list[tuple[str, ...]]:
        """Groups in which each candidate counts: its own, and what every motor has where it contains that."""
        plain = {(each.kind, each.spot): each.group for each in self.candidates if each.group.startswith(EVERY_MOTOR)}
        more = (
            [plain[k] for kind in each.law.plainer if (k := (kind, each.spot)) in plain] for each in self.candidates
        )
        return [(each.group, *groups) for each, groups in zip(self.candidates, more, strict=True)]


def log_harmonic(candidate: Candidate, p: int) -> float:
    """Log prior of a grid point that is a harmonic, if it is one; of an effect that stands nothing is asked."""
    if not candidate.law.cycles or candidate.stands is not None:
        return 0.0
    harmonic = candidate.points[p][0]
    return 0.0 if harmonic in candidate.natural(harmonic) else -WHOLE_NUMBER_LOG_ODDS
