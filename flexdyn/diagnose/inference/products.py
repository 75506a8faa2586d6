"""Products of columns in every equation: with any column for those that structures hold, else within its own block."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexdyn import _core
from flexdyn.arrays import Array, Indices

Columns = NDArray[np.float32]
COLUMNS_AT_ONCE = 256
"""Columns that are held in double precision at once."""
SPARE_ROWS = 64
"""Columns that get their products with all others without moving what is there."""


class Products:
    """White columns, and ``X^T X`` and ``X^T y`` of each equation.

    To add any block of columns to a structure takes the products of the structure's columns with all others, and those
    of every block with itself. Products of two candidates that no structure holds together are never needed, and most
    pairs are such. So a column gets its products with all others when a structure takes it up.

    Columns are kept in single precision, which changes each of them by 6e-8 of itself, far less than any column is
    known; half of the memory is worth that. The products are those of the rounded columns, in double precision.

    Args:
        equations: how many there are.
        rows: of each.
        capacity: columns at most.

    Attributes:
        X: columns where they are kept (equations, capacity, rows); of those that nobody puts no memory is taken.
        y: rows of each equation (equations, rows).
        b: X^T y (equations, capacity).
        count: columns that are there.
        held: X^T X of the columns that every structure has (equations, base, base).
    """

    def __init__(self, equations: int, rows: int, capacity: int) -> None:
        many = equations
        self.explain(np.zeros((rows, many)))
        self.X = np.zeros((many, capacity, rows), np.float32)
        self.b = np.zeros((many, capacity))
        self.count = 0
        self._kept = 0
        self._source = np.zeros(capacity, np.intp)  # where a column is kept: one that is there twice is kept once
        self._block = np.zeros(capacity, np.intp)
        self._own = np.zeros((many, capacity, 1))  # of a column with itself and the next ones of its block
        self._row = np.full(capacity, -1)  # where the products of a kept column with all others are
        self._rows = np.zeros((many, SPARE_ROWS, capacity))
        self._full = 0
        self.held = np.zeros((many, 0, 0))

    def explain(self, rows: Array) -> None:
        """What the columns are to explain (rows, equations), before any is put."""
        self.y = np.ascontiguousarray(rows.T)
        self.yy: Array = np.einsum("er,er->e", self.y, self.y)

    @property
    def room(self) -> int:
        """Columns that can still be kept; reserved ones that nobody puts take room, too."""
        return int(self.X.shape[1]) - self._kept

    def reserve(self, width: int) -> int:
        """Room for a block of columns, whose rows may be written into `X`; where it begins."""
        first, self._kept = self._kept, self._kept + width
        return first

    def put(self, place: int, white: Columns, kept: int | None = None) -> int:
        """Put a block of white columns (equations, columns, rows) at a place; the next place.

        Args:
            place: of the first one.
            white: their rows.
            kept: where in `X` they have been written; None: nowhere.
        """
        many, width = len(white), int(white.shape[1])
        first = self.reserve(width) if kept is None else kept
        here, end = slice(first, first + width), place + width
        if kept is None:
            self.X[:, here] = white
        self._source[place:end], self._block[here] = np.arange(first, first + width), first
        exact = white.astype(float)
        self.b[:, place:end] = np.einsum("ekr,er->ek", exact, self.y)
        if width > self._own.shape[2]:
            more = width - self._own.shape[2]
            self._own = np.concatenate([self._own, np.zeros((many, self._own.shape[1], more))], axis=2)
        for d in range(width):
            self._own[:, first : first + width - d, d] = np.einsum("ekr,ekr->ek", exact[:, : width - d], exact[:, d:])
        full = np.flatnonzero(self._row >= 0)
        products = np.empty((len(full), width))
        for X, rows, new in zip(self.X, self._rows, exact, strict=True):
            _core.mixed_products(X, full, np.ascontiguousarray(new), products)
            rows[self._row[full], here] = products
        self.count = max(self.count, end)
        return end

    def again(self, place: int, columns: Indices) -> int:
        """Put columns that are there at a further place; the next place."""
        end = place + len(columns)
        self._source[place:end], self.b[:, place:end] = self._source[columns], self.b[:, columns]
        self.count = max(self.count, end)
        return end

    def take_up(self, columns: Indices) -> None:
        """Multiply columns with all that are there, and from now on with all that come."""
        kept = np.unique(self._source[columns])
        new = kept[self._row[kept] < 0]
        if not len(new):
            return
        first, self._full = self._full, self._full + len(new)
        if self._full > self._rows.shape[1]:
            more = np.zeros((len(self.y), self._full - self._rows.shape[1] + SPARE_ROWS, self._rows.shape[2]))
            self._rows = np.concatenate([self._rows, more], axis=1)
        self._row[new] = np.arange(first, self._full)
        for X, rows in zip(self.X, self._rows, strict=True):
            mine = X[new].astype(float)
            for begin in range(0, self._kept, COLUMNS_AT_ONCE):
                part = slice(begin, min(begin + COLUMNS_AT_ONCE, self._kept))
                rows[first : self._full, part] = mine @ X[part].astype(float).T

    def hold(self, count: int) -> None:
        """Take up the first columns, which every structure has."""
        first = np.arange(count)
        if count != self.held.shape[1]:
            self.take_up(first)
            self.held = self.of(first, first)

    def prepare(self, columns: Indices) -> None:
        """Make sure that the products of all pairs of these columns are there."""
        kept = self._source[columns]
        blocks = np.unique(self._block[kept[self._row[kept] < 0]])
        if len(blocks) > 1:  # those of one block are there
            self.take_up(columns[np.isin(self._block[kept], blocks[:-1])])

    def of(self, columns: Indices, others: Indices) -> Array:
        """X^T X of some columns with others (equations, columns, others)."""
        self.prepare(np.concatenate([columns, others]))
        i, j = np.broadcast_arrays(self._source[columns][:, None], self._source[others][None, :])
        turned = self._row[i] < 0
        i, j = np.where(turned, j, i), np.where(turned, i, j)
        own = self._row[i] < 0  # neither has products with all: they are of one block
        found = self._rows[:, np.where(own, 0, self._row[i]), j]
        low, high = np.minimum(i[own], j[own]), np.maximum(i[own], j[own])
        found[:, own] = self._own[:, low, high - low]
        return np.asarray(found)

    def weighted(self, weights: Array, columns: Indices, first: int = 0) -> Array:
        """``sum_e w_e X_e^T X_e`` of columns that were taken up with all from the first one on (columns, ...)."""
        which = self._source[first : self.count]
        low, mine = int(which.min(initial=self._kept)), self._row[self._source[columns]]
        found = np.zeros((len(columns), self._kept - low))
        for weight, rows in zip(weights, self._rows, strict=True):
            found += weight * rows[mine, low : self._kept]
        return found[:, which - low]

    def weighted_own(self, weights: Array, first: int = 0) -> Array:
        """The same of columns from the first one on with those that follow them in their block (columns, width)."""
        return np.asarray(np.tensordot(weights, self._own[:, self._source[first : self.count]], 1))

    def diagonals(self) -> Array:
        """Squares of all columns (equations, count)."""
        return self._own[:, self._source[: self.count], 0]

    def sum(self, columns: Indices, values: Array) -> Array:
        """X beta (equations, rows)."""
        return np.stack([values @ X[self._source[columns]] for X in self.X])
