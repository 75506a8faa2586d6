"""The curve through samples, in the form that the core reads."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.errors import InputError


def curve(times: Array, columns: Array, interpolation: str) -> tuple[Array, Array, Array]:
    """Polynomials between samples.

    Args:
        times: of the samples (samples,) [s].
        columns: their values (samples, width).
        interpolation: ``hold``, ``linear``, ``cubic`` or ``monotone``.

    Returns:
        Breaks (from 0), coefficients (segments, degree + 1, width) and the last value (width,).

    Raises:
        InputError: times or values so large, or so close to each other, that the curve is not finite.
    """
    with np.errstate(all="ignore"):  # what is not finite is refused below
        t = np.ascontiguousarray(times - times[0])
        apart = bool(np.isfinite(t).all() and (np.diff(t) > 0).all())
        coefficients = _coefficients(t, columns, interpolation) if apart else np.full(1, np.nan)
    if not np.isfinite(coefficients).all():
        value = f"t {times[0]:g} to {times[-1]:g} s, values {columns.min():g} to {columns.max():g}"
        remedy = "give times and values in SI units, and leave out samples that are too close to each other"
        raise InputError("no finite curve goes through them", key="samples", value=value, remedy=remedy)
    return t, np.ascontiguousarray(coefficients), np.ascontiguousarray(columns[-1])


def _coefficients(t: Array, columns: Array, interpolation: str) -> Array:
    """Of the polynomials, the constant one first; NaN where there are none."""
    if interpolation == "hold":
        return columns[:-1, None, :]
    if interpolation == "linear":
        slope = np.diff(columns, axis=0) / np.diff(t)[:, None]
        return np.stack([columns[:-1], slope], axis=1)
    from scipy.interpolate import CubicSpline, PchipInterpolator

    spline = CubicSpline if interpolation == "cubic" else PchipInterpolator
    try:
        return np.asarray(spline(t, columns).c[::-1].transpose(1, 0, 2))
    except ValueError:  # SciPy's own words for slopes that are not finite
        return np.full(1, np.nan)
