"""Products of all columns in every equation, computed once: any weights of the equations only add them up."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

Array = NDArray[np.float64]
Columns = NDArray[np.float32]
Indices = NDArray[np.intp]
Place = TypeVar("Place", int, Indices)


class Products:
    """White columns, and ``X^T X`` and ``X^T y`` of each equation.

    Columns are kept in single precision, which changes each of them by 6e-8 of itself, far less than any column is
    known; half of the memory is worth that. The products are those of the rounded columns, in double precision.
    They are kept as lower triangles, row by row: products of further columns follow those that are there.

    Args:
        rows: what the columns are to explain (rows, equations).
        capacity: columns at most.

    Attributes:
        y: rows of each equation (equations, rows).
        b: X^T y (equations, capacity).
        count: columns whose products are there.
    """

    def __init__(self, rows: Array, capacity: int) -> None:
        self.y = np.ascontiguousarray(rows.T)
        self.yy: Array = np.einsum("er,er->e", self.y, self.y)
        many = len(self.y)
        self.X = np.zeros((many, capacity, len(rows)), np.float32)
        self.b = np.zeros((many, capacity))
        self.count = 0
        self._triangles = np.zeros((many, capacity * (capacity + 1) // 2))

    def put(self, place: int, white: Columns) -> int:
        """Put white columns (rows times equations, columns) at a place; the next place."""
        end = place + int(white.shape[1])
        self.X[:, place:end] = white.reshape(self.y.shape[1], len(self.y), -1).transpose(1, 2, 0)
        return end

    def multiply(self, end: int) -> None:
        """Multiply the columns up to a place that have no products yet with all before them."""
        first = self.count
        for X, y, b, triangle in zip(self.X, self.y, self.b, self._triangles, strict=True):
            new = X[first:end].astype(float)
            b[first:end] = new @ y
            before, own = X[:first] @ new.T, dsyrk(1.0, new.T, trans=1)
            for k, i in enumerate(range(first, end)):
                place = _place(i, 0)
                triangle[place : place + first] = before[:, k]
                triangle[place + first : place + i + 1] = own[: k + 1, k]
        self.count = end

    def weighted(self, weights: Array) -> tuple[Array, Array]:
        """``sum_e w_e X_e^T X_e`` (count, count) and ``sum_e w_e X_e^T y_e`` (count,)."""
        triangle = weights @ self._triangles[:, : _place(self.count, 0)]
        G = np.empty((self.count, self.count))
        for i in range(self.count):
            place = _place(i, 0)
            G[i, : i + 1] = triangle[place : place + i + 1]
        upper = np.triu_indices(self.count, 1)
        G[upper] = G.T[upper]
        return G, weights @ self.b[:, : self.count]

    def of(self, columns: Indices, others: Indices) -> Array:
        """X^T X of some columns with others (equations, columns, others)."""
        i, j = columns[:, None], others[None, :]
        return self._triangles[:, _place(np.maximum(i, j), np.minimum(i, j))]

    def diagonals(self) -> Array:
        """Squares of all columns (equations, count)."""
        i = np.arange(self.count)
        return self._triangles[:, _place(i, i)]

    def squares(self, columns: Indices, values: Array) -> Array:
        """Sums of the squares of y - X beta (equations,)."""
        crossed = np.einsum("ekl,k,l->e", self.of(columns, columns), values, values, optimize=True)
        return np.asarray(np.maximum(self.yy - 2.0 * self.b[:, columns] @ values + crossed, 0.0))

    def sum(self, columns: Indices, values: Array) -> Array:
        """X beta (equations, rows)."""
        return np.stack([values @ X[columns] for X in self.X])


def _place(i: Place, j: Place) -> Place:
    """Where the product of two columns, i not before j, stands in a triangle."""
    return i * (i + 1) // 2 + j
