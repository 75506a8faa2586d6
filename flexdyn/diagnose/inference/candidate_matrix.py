"""The columns of all candidates in one matrix, with their priors and sizes; refined grid points make it wider."""

from __future__ import annotations

import dataclasses

import numpy as np

from flexdyn.arrays import Array, Indices
from flexdyn.diagnose.constants import EFFECT_TORQUE_SHARE, NEGLIGIBLE_SHARE, SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.hypothesis.proposal import Point
from flexdyn.diagnose.inference.candidate import Candidate, Column
from flexdyn.diagnose.inference.evidence import Prior
from flexdyn.diagnose.inference.library import Library
from flexdyn.diagnose.inference.model_error import Seen
from flexdyn.diagnose.inference.products import Products

SPARE_COLUMNS = 400
"""Columns for refined grid points."""


class CandidateMatrix:
    """The columns that structures are made of; those that every structure has come first.

    Args:
        library: that makes the columns.
        rows: what the start leaves, white but for the model error (rows,).
        seen: rows that say something.

    Attributes:
        candidates: whose columns they are.
        products: of the columns with each other and with what they explain.
        base: the first so many columns are in every structure: numbers of the file, offsets of encoders, and a small
            amount of every law.
        used: columns so far.
        prior: of the coefficients.
        size, cost, gained, smallest: see `Column`; cost and gained stand at the first column of a block.
        of: the equation that each column is about most (columns,).
    """

    def __init__(self, library: Library, rows: Array, seen: Seen) -> None:
        times, many = seen.valid.shape
        capacity = library.most_columns() + SPARE_COLUMNS
        self.products = Products(many, times, capacity)
        self.candidates, made = library.candidates(self.products)
        always, small = library.always(), self._negligible(made)
        self.base = len(always.std) + sum(len(each.std) for each, _ in small)
        shift = self.base - len(always.std)
        for candidate in self.candidates:
            candidate.columns = [each + shift for each in candidate.columns]
        standing = [column for each, column in zip(self._owners(), made, strict=True) if each.stands is not None]
        rows = rows - sum((each.white[:, 0] for each in standing), np.zeros_like(rows))
        self.products.explain(-rows.reshape(times, many))
        self.size, self.cost, self.gained = np.zeros(capacity), np.zeros(capacity), np.zeros(capacity)
        self.smallest, self.of = np.zeros(capacity), np.zeros(capacity, np.intp)
        self.prior = Prior(np.ones(capacity), np.zeros(capacity), np.zeros(capacity, bool))
        self._put(0, always)
        self.used = self.base
        for column in made:
            self.used = self._put(self.used, column)
        place = len(always.std)
        for column, alike in small:
            place = self._put(place, column, alike + self.base)
        self.of[: self.used] = self.products.diagonals().argmax(axis=0)

    def _negligible(self, made: list[Column]) -> list[tuple[Column, Indices]]:
        """Small amounts of every law without nonlinear parameters: no model is free of them; they are no findings.

        Each with its place among the columns that were made.
        """
        found, first = [], 0
        for candidate, column in zip(self._owners(), made, strict=True):
            here = np.arange(first, first + len(column.std))
            first += len(column.std)
            proposal = candidate.proposal
            if proposal is None or len(proposal.grid) > 1 or proposal.fixed:
                continue
            if candidate.stands:
                column, here = _tangents(column), here[1:]
            share = NEGLIGIBLE_SHARE * min(1.0, column.smallest / SMALLEST_TORQUE_SHARE)
            std = share * np.minimum(column.std, EFFECT_TORQUE_SHARE / np.maximum(column.size, 1e-300))
            mean, free = np.zeros_like(column.mean), column.positive & False
            found.append((dataclasses.replace(column, std=std, mean=mean, positive=free), here))
        return found

    def _owners(self) -> list[Candidate]:
        """The candidate of each block of columns."""
        return [candidate for candidate in self.candidates for _ in candidate.columns]

    def _put(self, first: int, column: Column, alike: Indices | None = None) -> int:
        """Add a block of columns, or the same columns again with another prior; the place after it.

        Args:
            first: place of its first column.
            column: the block.
            alike: where the same columns are already; None: they are new.
        """
        if alike is None:
            end = self.products.put(first, column.apart, column.kept)
        else:
            end = self.products.again(first, alike)
        here = slice(first, end)
        self.prior.precision[here], self.prior.mean[here] = 1.0 / column.std**2, column.mean
        self.prior.positive[here], self.smallest[here] = column.positive, column.smallest
        self.size[here] = column.size
        if end > first:
            self.cost[first], self.gained[first] = column.log_jacobian, column.gained
        return end

    def add(self, candidate: Candidate, point: Point, column: Column) -> bool:
        """Give a candidate one more grid point; whether there was room for it."""
        if self.used + len(column.std) > len(self.size) or len(column.std) > self.products.room:
            return False
        first, self.used = self.used, self._put(self.used, column)
        self.of[first : self.used] = self.products.diagonals()[:, first:].argmax(axis=0)
        candidate.points.append(point)
        candidate.columns.append(np.arange(first, self.used))
        return True


def _tangents(column: Column) -> Column:
    """Of an effect that stands, without what it does as it is."""
    kept = {name: getattr(column, name)[1:] for name in ("std", "mean", "positive", "size")}
    return dataclasses.replace(column, apart=column.apart[:, 1:], log_jacobian=0.0, gained=0, kept=None, **kept)
