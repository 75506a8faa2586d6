"""All additions to a structure, compared at once; and which laws may not stand beside each other."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from scipy.special import betaln

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.diagnose.constants import OCCAM_WINDOW
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_prior import log_harmonic, odds_of


class Scan:
    """Compares all additions to a structure at once."""

    def __init__(self, space: Space) -> None:
        self.space = space
        self.kinds = sorted(space.places.counts)
        self.total = np.array([space.places.counts[kind] for kind in self.kinds])
        self.clash = self._clashing()
        self._tabled()

    def _tabled(self) -> None:
        """Grid points as tables of columns, one for each width."""
        candidates = self.space.candidates
        self.size = self.space.matrix.used
        self.owner: list[tuple[int, int]] = []
        self.tables = []
        for width in sorted({each.width for each in candidates}):
            rows = []
            for c, each in enumerate(candidates):
                if each.width == width:
                    rows += each.columns
                    self.owner += [(c, p) for p in range(len(each.points))]
            self.tables.append(np.array(rows))
        self.of = np.array([c for c, _ in self.owner])
        self.clashes: dict[int, Flags] = {}
        cost = [self.space.costs(c, p) for c, p in self.owner]
        self.grid = np.array(cost) - np.log([candidates[c].choices for c in self.of])
        self.grid += [log_harmonic(candidates[c], p) for c, p in self.owner]
        groups = [self.space.places.groups[c] for c in self.of]
        self.counts = np.array([[kind in each for kind in self.kinds] for each in groups], float)
        self.alike: dict[tuple[str, object], list[int]] = {}
        for k, c in enumerate(self.of.tolist()):
            for group in self.space.places.groups[c]:
                self.alike.setdefault((group, self.space.places.place_in(group, c)), []).append(k)

    def _clashing(self) -> list[Indices]:
        """Candidates that may not stand beside each: itself, and laws that contain it or that it contains."""
        candidates = self.space.candidates
        late = {c: signal for c, each in enumerate(candidates) if (signal := _late(each)) is not None}
        places: dict[tuple[str | None, ...], list[int]] = {}
        for c, each in enumerate(candidates):
            places.setdefault(_where(each), []).append(c)
        found = []
        for c, me in enumerate(candidates):
            there = {c, *(k for k in places[_where(me)] if nested(me, candidates[k]))}
            if c in late:
                there |= {k for k, other in late.items() if _undo(late[c], other, late.values())}
            found.append(np.array(sorted(there)))
        return found

    def additions(self, structure: Structure) -> list[tuple[float, tuple[int, int]]]:
        """Log posterior that the best grid point of each candidate would gain, best first."""
        gain = self._gains(structure)
        order = np.lexsort((np.arange(len(gain)), -gain))
        firsts = np.sort(np.unique(self.of[order], return_index=True)[1])  # the best point of each candidate
        best = order[firsts]
        return [(float(gain[k]), self.owner[k]) for k in best[np.isfinite(gain[best])].tolist()]

    def undecided(self, structure: Structure) -> list[tuple[int, int]]:
        """Grid points of laws without a linear number that would gain nearly as much as another one of their law."""
        gain, candidates, found = self._gains(structure), self.space.candidates, []
        for c in np.unique(self.of[np.isfinite(gain)]).tolist():
            proposal, own = candidates[c].proposal, np.flatnonzero(self.of == c)
            near = own[gain[own] > gain[own].max() - OCCAM_WINDOW].tolist()
            if proposal is not None and proposal.fixed and len(near) > 1:
                found += [self.owner[k] for k in near]
        return found

    def _gains(self, structure: Structure) -> Array:
        """Log posterior that each grid point would gain (points,)."""
        if self.size != self.space.matrix.used:
            self._tabled()
        gain: Array = self.space.gram.additions(self.space.columns(structure), self.tables) + self.grid
        held = self.space.places.taken(c for c, _ in structure)
        there = [group for group, _ in held]
        counts = np.array([float(there.count(kind)) for kind in self.kinds])
        a, b = np.array([odds_of(kind) for kind in self.kinds]).T
        left = np.maximum(self.total - counts - 1.0, 0.0)
        price = betaln(counts + 1 + a, left + b) - betaln(counts + a, np.maximum(self.total - counts, 0.0) + b)
        gain = gain + self.counts @ price
        for each in held:  # another law of a place that counts already
            gain[self.alike[each]] -= price[self.kinds.index(each[0])]
        for c, _ in structure:
            gain[self._clashes(c)] = -np.inf
        return np.asarray(gain)

    def _clashes(self, c: int) -> Flags:
        """Grid points that may not stand beside a candidate (points,)."""
        if c not in self.clashes:
            self.clashes[c] = np.isin(self.of, self.clash[c])
        return self.clashes[c]


def nested(one: Candidate, other: Candidate) -> bool:
    """Whether one of two laws at the same place contains the other."""
    contains = other.kind in one.law.contains or one.kind in other.law.contains
    return contains and _where(one) == _where(other)


def _undo(one: tuple[str, str], other: tuple[str, str], late: Collection[tuple[str, str]]) -> bool:
    """Whether two delays at one joint undo one another: those of its torque, or of its torque and its only encoder.

    Of a torque and two encoders, two can be late against the third one.
    """
    joint, signals = one[1], {one[0], other[0]}
    encoders = {signal for signal, place in late if place == joint} & {"q", "theta"}
    return other[1] == joint and (len(encoders) < 2 or not signals & encoders)


def _late(candidate: Candidate) -> tuple[str, str] | None:
    """Which signal comes late, and of which joint, if any."""
    if candidate.proposal is None or not candidate.law.late_by:
        return None
    asked = candidate.law.stage == "actuator"
    return "asked" if asked else candidate.place["channel"].partition(".")[0], candidate.proposal.joint


def _where(candidate: Candidate) -> tuple[str | None, ...]:
    return tuple(candidate.place.get(key) for key in ("joint", "side", "channel", "frame"))
