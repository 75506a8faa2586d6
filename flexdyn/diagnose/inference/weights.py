"""Weights of the equations for a fit: noise of sensors, error of filters, and the model error that is left."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import FIRST_FILTER_WIDTH, Filters
from flexdyn.diagnose.equations.covariance import SampleNoise
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.expected import expected_data
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.linear import require_finite
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import Workspace, weighed
from flexdyn.diagnose.inference.model_error import ModelError, Seen
from flexdyn.diagnose.inference.whitening import Tempered
from flexdyn.diagnose.parallel import SILENT


def quieter(recorded: SampleNoise, at: Equations, mask: Flags) -> SampleNoise:
    """The torque's noise: what the record changes from sample to sample, or what the equations do, whichever is less.

    Each contains the whole noise and something else: the changes of the command, or missing effects.
    """
    left = torque_noise(at, at.residual, mask, recorded)
    return dataclasses.replace(recorded, tau=np.maximum(np.minimum(left, recorded.tau), 1e-12))


def along_expected(work: Workspace, here: Hypothesis, at: Equations) -> tuple[Workspace, Array]:
    """The same weights with slopes along the motion that is expected, given what a hypothesis leaves.

    Only where slopes contain much noise; those of rigid arms have hardly any behind the filters.

    Args:
        work: equations of the model as given, with weights of the hypothesis' rows.
        here: the hypothesis.
        at: its equations.

    Returns:
        The equations with their weights, and the share of the rows' noise that the slopes still contain (equations,)
        [1]: a residual that is s times as large as noise alone shows 1/s^2 of the noise.
    """
    if not at.noisy:
        return work, np.ones(len(at.kinds))
    scale = ModelError.of(work.white(at.residual), rows_of(work.bare)).scale
    along = work.equations.along(expected_data(at, work.noise, work.whiten, scale))
    near = work.bare.with_slopes_along(along, here.factors, along.of(here.model()))
    return dataclasses.replace(work, bare=near), 1.0 - 1.0 / scale**2


def expected(work: Workspace) -> float:
    """Mean square of the weighted rows of a model error as large as it was taken for [1]."""
    error = work.whiten.error if isinstance(work.whiten, Tempered) else None
    return 1.0 if error is None else float((error.count / error.times).sum() / error.count.sum())


def for_fit(bare: Unweighted, there: Hypothesis, error: ModelError | None = None) -> Workspace:
    """Weights for the fit of a hypothesis: the sensors' noise and the model error that it leaves.

    The error of the first filter at corners of laws is left out: it would hide errors of a law that is still wrong.

    Args:
        bare: equations of the model as given.
        there: the hypothesis.
        error: model error that it will leave; None: what it leaves at these numbers.

    Raises:
        SimulationError: its equations are not finite.
    """
    at = bare.equations.of(there.model())
    bare = bare.with_offsets_of(bare.sloping(at))
    with SILENT():
        plain = weighed(bare, at)
        left = plain.white(at.residual)
        require_finite(left)
        error = error or ModelError.of(left, rows_of(bare), about_mean=True)
    if bare.along is None:  # the hypothesis has springs that the linearisation lacks
        plain, _ = along_expected(plain, there, at)
    made = tempered(plain, error)
    if not at.noisy:
        return made
    return dataclasses.replace(made, anew=lambda at: tempered(weighed(plain.bare, at), error))


def error_of(plain: Workspace, residual: Array) -> ModelError:
    """The model error in a residual (rows,), the encoders' offsets that fit it best taken off."""
    return ModelError.of(plain.white(residual), rows_of(plain.bare), about_mean=True)


def tempered(plain: Workspace, error: ModelError) -> Workspace:
    """Weights by the sensors' noise and a model error together."""
    return dataclasses.replace(plain, whiten=Tempered.of(plain.whiten, error))


def rows_of(bare: Unweighted) -> Seen:
    """Which rows of the equations say something."""
    return Seen(~bare.mask.reshape(-1, len(bare.equations.kinds)), bare.equations.counts)


def filter_error(equations: Equations, here: Hypothesis) -> Array | None:
    """Variance of the rows by what the first filter does to the found effects' laws (rows,); None: there are none.

    The filter rounds the motion at the corners of laws. A filter with twice the variance rounds twice as much, so the
    difference is the error of the narrow one (Richardson). Waves over a position are taken before the filter.
    """
    rounded = [effect for effect in here.effects if not effect.cycles]
    if not rounded:
        return None
    dt = equations.data[0].dt
    first = Filters.of_rate(dt, first=math.sqrt(2.0) * max(FIRST_FILTER_WIDTH, 1.25 * dt)).first
    filters = dataclasses.replace(equations.filters, first=first)
    wide = dataclasses.replace(equations, filters=filters)
    total = np.zeros(len(equations.residual))
    for effect in rounded:
        without = dataclasses.replace(here, effects=tuple(each for each in here.effects if each is not effect))
        parts = []
        for at in (equations, wide):
            whole = at.of(here.model()).residual - at.of(without.model()).residual
            parts.append(_by_recording(at, whole))
        total += np.concatenate([_difference(a, b) for a, b in zip(*parts, strict=True)]) ** 2
    return total


def _by_recording(at: Equations, rows: Array) -> list[tuple[Array, Array]]:
    """Times and rows (times, equations) of every recording."""
    both = (at.at_rows("t"), rows.reshape(-1, len(at.kinds)))
    return list(zip(*map(at.by_recording, both), strict=True))


def _difference(narrow: tuple[Array, Array], wide: tuple[Array, Array]) -> Array:
    t, rows = narrow
    other = np.stack([np.interp(t, wide[0], column) for column in wide[1].T], axis=1)
    inside = (t >= wide[0][0]) & (t <= wide[0][-1])
    return np.asarray(np.where(inside[:, None], other - rows, 0.0)).ravel()
