"""The error of the first filter taken off the equations: laws are evaluated along a motion that it has rounded."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.records.signals.kernels import GaussianSmoother


def less_rounded(made: Fit) -> Fit:
    """The fit to equations without the error of the first filter, if they leave less.

    Equations whose links are simulated keep it: no filter passes these motions.
    """
    at = made.space.equations
    if at.simulated or at.replayed.any():
        return made
    space = made.space.with_equations(at.less(rounding(made)))
    other = fit(made.hypothesis, space)
    return other if other.reached < made.reached else made


def rounding(made: Fit) -> Array:
    """Error of the rows (rows,) by what the first filter does to a motion before laws see it.

    A law g sees the filtered motion F y, where its torque should be F g(y). With the second filter S, the difference is
    to second order of the filter's width, as by Richardson,

        S (F g(y) - g(F y)) = S F g(F y) - S g(F F y),

    the difference of equations with filters (F, S F) and (F F, S). What is linear cancels, and so does noise that laws
    pass on. Rows near a reversal, as these filters see it, are left as they are: dry friction jumps there.

    Args:
        made: a fit, of whose equations they are.
    """
    at = made.equations
    dt, first, second = at.data[0].dt, at.filters.first.variance, at.filters.second.variance
    passes = 1 + bool(at.computed.any())  # a computed position passes the first filter twice
    narrow = at.with_filters(Filters(at.filters.first, _smoother(second + passes * first, dt), 1))
    wide = at.with_filters(Filters(_smoother(2.0 * first, dt), at.filters.second, 1))
    rows = _at_rows(at, narrow, narrow.residual) - _at_rows(at, wide, wide.residual)
    hidden = [_at_rows(at, each, sign_mask(each, made.space.noise).astype(float)) for each in (narrow, wide)]
    clear = np.isfinite(rows) & (hidden[0] == 0.0) & (hidden[1] == 0.0)
    return np.where(clear, -rows, 0.0)


def _smoother(variance: float, dt: float) -> GaussianSmoother:
    return GaussianSmoother.of_width(float(np.sqrt(variance)) * dt, dt)


def _at_rows(at: Equations, other: Equations, values: Array) -> Array:
    """Values of equations that have a row at every sample, at the times of the rows (rows,); NaN beyond their ends."""
    found, parts = [], other.by_recording(values.reshape(-1, len(at.kinds)))
    for mine, along, table in zip(at.motions, other.motions, parts, strict=True):
        begin = along.t[other.filters.second.half]
        places = np.rint((mine.t[at.filters.instants(len(mine.t))] - begin) / along.dt).astype(int)
        inside = (places >= 0) & (places < len(table))
        found.append(np.where(inside[:, None], table[np.where(inside, places, 0)], np.nan).ravel())
    return np.concatenate(found)
