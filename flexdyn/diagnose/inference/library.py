"""All candidates and their columns: every effect at every place and grid point, every number without its tolerance."""

from __future__ import annotations

import itertools

import numpy as np

from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.inference.candidate import Candidate, Column
from flexdyn.diagnose.inference.column_maker import ColumnMaker
from flexdyn.diagnose.inference.products import Products
from flexdyn.diagnose.inference.standing_effects import beliefs, standing_columns
from flexdyn.diagnose.parallel import in_parallel

POINTS_AT_ONCE = 16
"""Grid points whose columns are made white at once: more would not be faster, and take memory."""


class Library(ColumnMaker):
    """Lists the candidates and makes their columns."""

    @property
    def _open(self) -> list[Proposal]:
        """Proposals of effects that the start does not hold."""
        return [p for p in self.proposals if not any(p.is_of(effect) for effect in self.start.effects)]

    def most_columns(self) -> int:
        """Columns that all candidates and every structure have, at most."""
        numbers = 2 * int(self.numbers.shape[1]) + int(self.work.nuisance.shape[1]) + len(self.start.effects)
        tangents = len(self.start.unknowns())
        laws = [len(p.units(point)) for p in self._open for point in p.grid]
        plain = [len(p.units(p.grid[0])) for p in self._open if len(p.grid) == 1]  # small amounts of every law
        return numbers + 2 * tangents + sum(laws) + sum(plain)

    def candidates(self, products: Products) -> tuple[list[Candidate], list[Column]]:
        """All of them, with the columns of their grids in the order of their places; many are written into products."""
        first = self.numbers.shape[1] + self.work.nuisance.shape[1]
        found, columns = [], []
        for k, number in enumerate(self.start.factors):
            found.append(Candidate(number.parameter, None, number, [()], [np.array([first])], 1))
            columns.append(self.freed(k))
            first += 1
        belief = beliefs(self, self.start.effects)
        for effect in self.start.effects:
            proposal = next(p for p in self.proposals if p.is_of(effect))
            column, estimated = standing_columns(self, effect, proposal, belief)
            place = first + np.arange(len(column.std))
            first += len(column.std)
            choices = 1 if set(estimated) & set(proposal.axes) else len(proposal.grid)  # a tangent has a prior itself
            ratio, tangents = self.gear_ratio(proposal), tuple(estimated)
            found.append(Candidate(effect.name, proposal, None, [()], [place], choices, effect, ratio, tangents))
            columns.append(column)
        jobs = []
        for p in (open_ := self._open):
            for k in range(0, len(p.grid), POINTS_AT_ONCE):
                some = p.grid[k : k + POINTS_AT_ONCE]
                width = sum(len(p.units(point)) for point in some)
                begin = products.reserve(width)
                jobs.append((p, some, products.X[:, begin : begin + width], begin))
        made = itertools.chain.from_iterable(in_parallel(lambda job: self.of_points(*job), jobs))
        for proposal in open_:
            pairs = [(point, next(made)) for point in proposal.grid]
            kept = [(point, each) for point, each in pairs if each is not None]
            if not kept:
                continue
            places = []
            for _, column in kept:
                places.append(first + np.arange(len(column.std)))
                first += len(column.std)
                columns.append(column)
            kind = proposal.place["effect"]
            ratio = self.gear_ratio(proposal)
            points = [point for point, _ in kept]
            found.append(Candidate(kind, proposal, None, points, places, len(kept), ratio=ratio))
        return found, columns
