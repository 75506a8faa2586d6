"""What the rows do not know of links that nobody measures: their first states, and their load while motors rest."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.layout import TOTAL


def error_of_rests(equations: Equations) -> Array:
    """Variance of the rows (rows,) by what they neglect while a motor rests whose link is not measured.

    The link is taken to follow its load without delay. The acceleration that this neglects winds the spring by
    ``M_ii (alpha - a) / K``; the rows contain this to first order, and the next order is at most about as large where
    the link does not vibrate at its own frequency. Where it does, this is large too.
    """
    parts = []
    for along in equations.motions:
        at = equations.filters.instants(len(along.t))
        rows = np.zeros((len(at), len(equations.kinds)))
        for i in np.flatnonzero(equations.computed & along.resting.any(axis=0)).tolist():
            wound = along.M[:, i, i] * (along.alpha - along.a)[:, i] / equations.true.stiffness[i]
            swung = [equations.filters.rows(np.where(along.resting[:, i], wound, 0.0), order) for order in range(3)]
            loads = along.dragged(i, swung, at) / equations.gains
            for place, (j, kind) in enumerate(equations.kinds):
                rows[:, place] += np.abs(loads[:, j]) if kind == TOTAL else 0.0
        parts.append(rows.ravel())
    with np.errstate(over="ignore"):  # of numbers far from the right ones: such a fit is refused
        return np.asarray(np.concatenate(parts) ** 2)


def of_first_states(equations: Equations) -> tuple[Array, Array]:
    """Slopes of the rows by the first states of simulated links (rows, states), and standard deviations of these.

    For each recording and joint a deflection and its rate at the first recorded sample, where the simulation begins;
    the standard deviations are their root mean squares.
    """
    columns: list[Array] = []
    sigma: list[float] = []
    ends = np.cumsum(equations.counts)
    for along, end in zip(equations.motions if equations.simulated else (), ends.tolist(), strict=False):
        response, hidden = equations.response(along), np.flatnonzero(equations.unmeasured)
        for i, one in zip(hidden.tolist(), np.eye(len(hidden)), strict=True):
            for size, y, v in ((along.delta[:, i], one, 0.0 * one), (along.ddelta[:, i], 0.0 * one, one)):
                moved = equations.behind(along, response.free(y, v, along.lost * along.dt))
                whole = np.zeros((int(ends[-1]), len(equations.kinds)))
                whole[end - len(moved) : end] = moved
                columns.append(whole.ravel())
                sigma.append(float(np.sqrt(np.mean(size**2))) + 1e-12)
    rows = int(ends[-1]) * len(equations.kinds)
    return np.array(columns).reshape(-1, rows).T, np.array(sigma)
