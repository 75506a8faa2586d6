"""Least squares from which unknown numbers get their first values: columns beside the numbers of the file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.regression import Regression
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.inference.model_error import ModelError
from flexdyn.diagnose.inference.weights import rows_of
from flexdyn.model.flexible_joint_model import FlexibleJointModel


@dataclass(frozen=True, eq=False)
class FirstRegression:
    """Least squares of columns beside the numbers of the file and the nuisances of its equations.

    Attributes:
        space: of the model.
        y: white residual (rows,).
        X: white columns, first those of the file's numbers (rows, columns).
        sigma: prior standard deviations of these columns; inf: none.
        size: what each equation leaves, in standard deviations of its noise (equations,).
    """

    space: Workspace
    y: Array
    X: Array
    sigma: Array
    size: Array

    @classmethod
    def of(
        cls,
        model: FlexibleJointModel,
        data: tuple[Measured, ...],
        columns: Callable[[Equations], Sequence[Array]],
    ) -> FirstRegression:
        """The one of a model along recordings; all equations leave as much as their noise.

        Args:
            model: without unknown numbers.
            data: of the fit.
            columns: those beside the file's numbers (rows,) each, of the model's equations.

        Raises:
            InputError: all rows are masked.
        """
        bare, start = prepared(model, data)
        space, more = weighed(bare), columns(bare.equations)
        sigma = [max(number.tolerance, 1e-9) for number in start.factors] + [math.inf] * len(more)
        X = np.column_stack([space.numbers, space.whiten(np.column_stack(more))])
        y = space.whiten(bare.equations.residual)
        return cls(space, y, X, np.array(sigma), np.ones(len(bare.equations.kinds)))

    def solved(self, more: Sequence[Array] = (), held: Sequence[Array] = ()) -> Regression:
        """The regression.

        Args:
            more: further white columns, without priors (rows, k) each.
            held: white rows of what is taken for known (rows,) each.
        """
        nuisance = self.space.nuisance
        X = np.column_stack([self.X, *more, nuisance])
        free = np.full(X.shape[1] - len(self.sigma) - nuisance.shape[1], math.inf)
        sigma = np.concatenate([self.sigma, free, self.space.nuisance_sigma])
        y = self.y + sum(held, np.zeros_like(self.y))
        row = np.tile(self.size, len(y) // len(self.size))
        return Regression(y / row, X / row[:, None], np.zeros(len(sigma)), sigma, self.space.rows, nuisance.shape[1])

    def weighted(self, solved: Regression) -> FirstRegression:
        """The same with the weights of what a regression under the present ones leaves."""
        left = solved.left[: len(self.y)].reshape(-1, len(self.size)) * self.size
        return dataclasses.replace(self, size=ModelError.of(left, rows_of(self.space.bare)).scale)
