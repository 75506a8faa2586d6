"""Products of columns in every equation, those of every structure eliminated, for the pairs that structures hold."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.diagnose.inference.products import Products

FIRST_ROOM = 64
"""Columns that there is room for at first; the room doubles as more are needed."""


class Eliminated:
    """What own columns of structures leave, whatever their coefficients are.

    With the coefficients ``a - B beta`` of the columns ``X0`` that every structure has, the rows left are
    ``z - Z beta``, where ``z = y - X0 a`` and ``Z = X - X0 B``. Their products are computed once for each pair of
    columns that a structure holds. A structure then takes the products of its own columns alone.

    Args:
        products: of all columns; those of every structure come first.
        weights: of the equations' squared rows.
        precision: of the priors of the columns of every structure (base,).
        alone: coefficients `a` of these, where nothing else is there (base,).
        by: coefficients B of these by other columns, of which it is given the places (base, columns).
    """

    def __init__(
        self, products: Products, weights: Array, precision: Array, alone: Array, by: Callable[[Indices], Array]
    ) -> None:
        self.products, self.weights, self.precision, self.alone, self.by = products, weights, precision, alone, by
        many, base = len(weights), len(alone)
        first = np.arange(base)
        self._held, g = products.held, products.b[:, :base]
        self._left = g - self._held @ alone  # X0^T z of each equation
        self.zz: Array = products.yy - 2.0 * g @ alone + (self._held @ alone) @ alone
        self._first = first
        self._place: dict[int, int] = {}
        self._b = np.zeros((many, FIRST_ROOM))  # Z^T z
        self._B = np.zeros((FIRST_ROOM, base))
        self._R, self._T = (np.zeros((many, FIRST_ROOM, base)) for _ in range(2))  # X^T X0, Z^T X0
        self._pairs = np.zeros((many + 1, FIRST_ROOM, FIRST_ROOM))  # Z^T Z; the last one weighted, with the priors
        self._known = np.zeros((FIRST_ROOM, FIRST_ROOM), bool)

    def between(self, columns: Indices, others: Indices) -> Array:
        """``sum_e w_e X^T X`` of columns with others, the columns of every structure eliminated (columns, others).

        Args:
            columns: of one side.
            others: of the other.
        """
        both = np.concatenate([columns, others])
        at = self._at(both)
        return np.asarray(self._pairs[-1, at[: len(columns), None], at[None, len(columns) :]])

    def squares(self, columns: Indices, values: Array) -> Array:
        """Sums of the squares of ``z - Z beta`` (equations,).

        Args:
            columns: of a structure, without those that every structure has (k,).
            values: their coefficients (k,).
        """
        at = self._at(columns)
        crossed = (self._pairs[:-1, at[:, None], at[None, :]] @ values) @ values
        return np.asarray(np.maximum(self.zz - 2.0 * self._b[:, at] @ values + crossed, 0.0))

    def _at(self, columns: Indices) -> Indices:
        """Places of columns whose pairs are all there."""
        wanted = columns.tolist()
        new = list(dict.fromkeys(c for c in wanted if c not in self._place))
        if new:
            self._put(np.array(new, np.intp))
        at = np.array([self._place[c] for c in wanted], np.intp)
        missing = ~self._known[at[:, None], at[None, :]]
        if missing.any():
            self._multiply(columns, at, _covering(missing))
        return at

    def _put(self, new: Indices) -> None:
        """Products of new columns with those of every structure, and with what these leave."""
        first = len(self._place)
        self._place.update({int(c): first + k for k, c in enumerate(new)})
        self._make_room(len(self._place))
        here = slice(first, len(self._place))
        b = self._B[here] = self.by(new).T
        R = self._R[:, here] = self.products.of(new, self._first)
        self._T[:, here] = R - b @ self._held
        self._b[:, here] = self.products.b[:, new] - R @ self.alone - self._left @ b.T

    def _multiply(self, columns: Indices, at: Indices, which: Indices) -> None:
        """Pairs of columns with some of them."""
        some = at[which]
        found = self.products.of(columns, columns[which])
        B, b = self._B[at], self._B[some]
        found -= self._R[:, at] @ b.T
        found -= (self._T[:, some] @ B.T).transpose(0, 2, 1)
        whole = np.tensordot(self.weights, found, 1) + B @ (self.precision * b).T
        for pairs, new in zip(self._pairs, (*found, whole), strict=True):
            pairs[at[:, None], some[None, :]] = new
            pairs[some[:, None], at[None, :]] = new.T
        self._known[at[:, None], some[None, :]] = self._known[some[:, None], at[None, :]] = True

    def _make_room(self, count: int) -> None:
        room = len(self._known)
        if count <= room:
            return
        more = max(count, 2 * room) - room
        self._b, self._B = np.pad(self._b, ((0, 0), (0, more))), np.pad(self._B, ((0, more), (0, 0)))
        self._R, self._T = (np.pad(each, ((0, 0), (0, more), (0, 0))) for each in (self._R, self._T))
        self._pairs = np.pad(self._pairs, ((0, 0), (0, more), (0, more)))
        self._known = np.pad(self._known, ((0, more), (0, more)))


def _covering(missing: Flags) -> Indices:
    """Few columns in which, or in whose rows, all missing pairs are."""
    left, found = missing.copy(), []
    while left.any():
        most = int(left.sum(axis=0).argmax())
        found.append(most)
        left[most], left[:, most] = False, False
    return np.array(found, np.intp)
