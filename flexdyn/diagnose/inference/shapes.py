"""Fits with another of the few values of a number that no fit moves, such as the exponent of a Stribeck curve."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.proposal import Point
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.catalogue import columns_of
from flexdyn.diagnose.inference.posterior_of_fit import fit_if_likely, log_posterior
from flexdyn.diagnose.inference.space import Space, Structure
from flexdyn.diagnose.inference.structure_model import effect_of
from flexdyn.effects import Effect


def likeliest_shapes(space: Space, best: Structure, fitted: Fit) -> Fit:
    """The fit of a structure, with another value of each such number where that is more likely.

    The linear equations compare the values where the effect is still missing, often with other effects. Once it is in
    the linearisation, they see the changes of what a fit moves alone.

    Args:
        space: of the last linearisation.
        best: the structure.
        fitted: its fit.
    """
    for c, _ in sorted(best):
        for there in _other_shapes(space, space.candidates[c], fitted.hypothesis):
            least = log_posterior(space, best, fitted)
            value, made = fit_if_likely(space, best, there, fitted, least)
            if made is not None and value > least:
                fitted = made
    return fitted


def _other_shapes(space: Space, candidate: Candidate, here: Hypothesis) -> Iterator[Hypothesis]:
    """A hypothesis with each other value of what no fit moves in a candidate's effect, where its torque is nearest."""
    proposal, effect = candidate.proposal, effect_of(candidate, here)
    if proposal is None or effect is None or len(candidate.moved_axes) == len(proposal.axes):
        return
    at = space.library.equations
    own = _numbers(effect, candidate.law.linear) @ columns_of(at, proposal, tuple(_numbers(effect, proposal.axes)))
    now, nearest = _kept(candidate, tuple(_numbers(effect, proposal.axes))), dict[Point, tuple[float, Effect]]()
    for point in proposal.grid:
        if (values := _kept(candidate, point)) == now:
            continue
        rows = columns_of(at, proposal, point)
        x, *_ = np.linalg.lstsq(rows.T, own)
        far, other = float(np.sum((own - x @ rows) ** 2)), proposal.make(point, x)
        if other is not None and far < nearest.get(values, (np.inf, other))[0]:
            nearest[values] = far, other
    for _, other in nearest.values():
        yield here.with_instead(effect, other)


def _kept(candidate: Candidate, point: Point) -> Point:
    """What no fit moves of a grid point."""
    return tuple(value for k, value in enumerate(point) if k not in candidate.moved_axes)


def _numbers(effect: Effect, names: Sequence[str]) -> Array:
    """Parameters of an effect."""
    return np.array([getattr(effect, name) for name in names])
