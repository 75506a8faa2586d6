"""What simulated windows would gain by each candidate, by their linear response to a small amount of it.

Equations mask the rows near reversals, and without encoders on the links they hardly see some laws. Windows may see
them. Which candidates are worth a fit to the windows is therefore asked of the windows themselves.
"""

from __future__ import annotations

import contextlib
import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from flexdyn.arrays import Array
from flexdyn.diagnose.inference.evidence import lower_factor
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import waits
from flexdyn.diagnose.progress import check
from flexdyn.diagnose.simulated.window_fit import SCALED_STEP, STEP_SHARES, WindowFit
from flexdyn.effects import Effect
from flexdyn.errors import FlexdynError

Responses = dict[tuple[int, int], tuple[Array, ...]]
"""Derivatives of the residual by the linear numbers of candidates, by their grid points. They are computed at one
structure and serve for its neighbours too: they only say which candidates are simulated."""


@dataclass(frozen=True, eq=False)
class Addition:
    """A candidate that a structure may get.

    Attributes:
        gain: log posterior that the linear response promises.
        point: the candidate and its grid point.
        tried: shares of what the linear response promises: changes of all numbers that are there, in the scales of
            the fit, and the effect that is added; none for a number of the file.
    """

    gain: float
    point: tuple[int, int]
    tried: tuple[tuple[Array, Effect | None], ...]


def promising(here: WindowFit, space: Space, structure: Structure, responses: Responses) -> list[Addition]:
    """All candidates that a structure may get, those first that promise most.

    With weighted innovations y of the windows, their derivatives X by the numbers that are there and Z by a candidate's
    numbers, ``min |y + X b + Z c|^2`` and priors give c, and what it takes off. Prior and volume are those of the
    equations, as for structures that are simulated. A law with nonlinear parameters is at the grid point that the
    equations like best. Effects that the equations started from, and elasticity of a rigid joint, are left to the
    equations.

    Args:
        here: the structure, fitted to the windows.
        space: candidates, and their priors.
        structure: what there is.
        responses: known ones, which are used; those that are computed are added.
    """
    regression = here.made.regression
    seen = (regression.X**2).sum(axis=0) + regression.sigma**-2.0 > 0.0  # a stop that no window reaches is not
    X, precision = regression.X[:, seen], regression.sigma[seen] ** -2.0
    root = lower_factor(X.T @ X + np.diag(precision))
    right = precision * regression.centre[seen] - X.T @ regression.y
    prior, found, before = space.matrix.prior, [], space.log_volume(structure)
    for _, (c, p) in Scan(space).additions(structure):
        check()
        with contextlib.suppress(FlexdynError):
            Z = _columns(here, space, (c, p), responses)
            if Z is None or not np.isfinite(Z).all():
                continue
            C = X.T @ Z
            columns = space.candidates[c].columns[p]
            lam, mu = prior.precision[columns], prior.mean[columns]
            S = Z.T @ Z - C.T @ cho_solve((root, True), C) + np.diag(lam)
            left = lam * mu - Z.T @ regression.y - C.T @ cho_solve((root, True), right)
            x = np.linalg.solve(S, left)
            x = np.where(prior.positive[columns], np.maximum(x, 0.0), x)
            rise = float(x @ left - 0.5 * (x @ S @ x + mu @ (lam * mu)))
            number, step = space.candidates[c].number, np.zeros(len(seen))
            step[seen] = cho_solve((root, True), right - C @ x)
            if number is not None:
                step[list(here.made.hypothesis.factors).index(number)] += x[0]
            shares = ((share * step, space.candidates[c].effect(p, share * x)) for share in STEP_SHARES)
            tried = tuple(
                (moves, each) for moves, each in shares if number is not None or not (each is None or each.is_neutral)
            )
            if tried:
                gain = rise + space.log_volume(structure | {(c, p)}) - before
                found.append(Addition(gain, (c, p), tried))
    return sorted(found, key=lambda each: (-each.gain, each.point))


def is_asked(space: Space, c: int) -> bool:
    """Whether windows can tell of a candidate before it is simulated."""
    return space.candidates[c].number is not None or not (waits(space, c) or space.candidates[c].stands is not None)


def _columns(here: WindowFit, space: Space, point: tuple[int, int], responses: Responses) -> Array | None:
    """Weighted derivatives by a candidate's linear numbers (rows, width); None where it cannot be tried."""
    number = space.candidates[point[0]].number
    if number is not None:
        return here.made.regression.X[:, [list(here.made.hypothesis.factors).index(number)]]
    if not is_asked(space, point[0]):
        return None
    if point not in responses:
        responses[point] = _responses(here, space, *point)
    found = [here.weight * here.shot.whitened_change(each).ravel() for each in responses[point]]
    return np.stack(found, axis=1) if found else None


def _responses(here: WindowFit, space: Space, c: int, p: int) -> tuple[Array, ...]:
    """Derivatives of the residual by a candidate's linear numbers (windows, rows, channels) each; none: no effect."""
    candidate, hypothesis = space.candidates[c], here.made.hypothesis
    fixed = candidate.proposal is not None and candidate.proposal.fixed
    step = np.ones(1) if fixed else SCALED_STEP / np.sqrt(space.matrix.prior.precision[candidate.columns[p]])
    found = []
    for row in np.diag(step):
        effect = candidate.effect(p, row)
        if effect is None:
            return ()
        changed = dataclasses.replace(hypothesis, effects=(*hypothesis.effects, effect))
        found.append((here.shot.residual_of(changed.seen()) - here.shot.residual) / row.max())
    return tuple(found)
