"""A recording at other times: splines for sampled signals, steps for held ones."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from flexdyn.checks import Array, check_known, number
from flexdyn.errors import InputError
from flexdyn.records.signals.cut import made
from flexdyn.records.signals.gaps import gap_limit, rows_held
from flexdyn.records.signals.smooth import Smoother, sample_rate
from flexdyn.records.units import is_held, split_name

if TYPE_CHECKING:
    from flexdyn.records.recording import Recording

RESAMPLE_METHODS = ("spline", "hermite", "linear")

_SMOOTH = ("q", "v", "theta", "omega", "tau_s")
_RATES = {"q": "v", "theta": "omega"}
_PASSED = 0.4


def resampled(
    rec: Recording,
    *,
    rate: float | None = None,
    times: npt.ArrayLike | None = None,
    method: str = "spline",
    filtered: bool = False,
    longest_gap: float | None = None,
) -> Recording:
    """The recording at other times; where a new time is an old one, the samples are the same, bit for bit.

    Positions, velocities and tau_s are interpolated by `method`. tau and tau_applied keep the value of the last sample
    at or before the new time (a new time that is early by up to a thousandth of a period counts as that of the sample,
    because stamps are rounded). Temperature and channels that are no signals are interpolated linearly, so that they
    stay within the measured range.

    As with SciPy's and xarray's interpolation, nothing is filtered by default: at a lower rate, vibrations above half
    of it are aliased. With `filtered`, sampled signals are first smoothed with a cut-off of 0.4 times the new rate, and
    held signals are averaged from each new time to the next, which keeps their impulse; times that the filter does not
    cover are dropped.

    Args:
        rec: the recording.
        rate: new rate [Hz]: times t[0] + k/rate within the recording.
        times: or the new times themselves [s], increasing, within the recording.
        method: ``"spline"`` (cubic, continuous second derivative), ``"hermite"`` (cubic through positions and measured
            velocities; a spline if the velocity is not measured), or ``"linear"``.
        filtered: whether to smooth before sampling at a lower rate.
        longest_gap: longest time between samples to interpolate over [s]; default: 10 median periods.

    Raises:
        InputError: a longer gap (row and remedy), times outside the recording, or contradictory arguments.
    """
    check_known(method, RESAMPLE_METHODS, "no such method", key="method", value=method)
    if (rate is None) == (times is None):
        raise InputError("one time base is needed", key="rate", remedy="give either rate=Hz or times=[seconds]")
    _check_gaps(rec, longest_gap)
    wanted = _grid(rec, rate) if times is None else _given_times(rec, times)
    if filtered:
        return _smoothed_and_sampled(rec, wanted, method)
    return made(rec, {"t": wanted, **{name: _resampled(rec, name, wanted, method) for name in rec.channels}})


def _resampled(rec: Recording, name: str, times: Array, method: str) -> Array:
    """One channel at new times; old times keep their samples bit for bit."""
    if is_held(name):
        return rec[name][rows_held(rec.t, times)]
    signal, joint = split_name(name) or ("", "")
    row = np.clip(np.searchsorted(rec.t, times, "right") - 1, 0, None)
    rates = f"{_RATES.get(signal)}.{joint}"
    if signal not in _SMOOTH or method == "linear":
        out = np.interp(times, rec.t, rec[name])
    elif method == "hermite" and rates in rec:
        from scipy.interpolate import CubicHermiteSpline

        out = CubicHermiteSpline(rec.t, rec[name], rec[rates])(times)
    else:
        from scipy.interpolate import CubicSpline

        out = CubicSpline(rec.t, rec[name])(times)
    return np.where(rec.t[row] == times, rec[name][row], out)


def _smoothed_and_sampled(rec: Recording, wanted: Array, method: str) -> Recording:
    """Smooth on a uniform grid of the old rate, then sample at the new times; torques are averaged."""
    old, new = 1 / float(np.median(np.diff(rec.t))), 1 / float(np.median(np.diff(wanted)))
    narrow = Smoother(5, old).cutoff
    if _PASSED * new >= narrow:
        problem, remedy = "the new rate is not low enough to need a filter", f"give at most {narrow / _PASSED:.4g} Hz"
        raise InputError(problem, key="filtered", value=new, remedy=remedy)
    smoother = Smoother.at_cutoff(_PASSED * new, old)
    even = resampled(rec, rate=old, method=method, longest_gap=math.inf)
    if len(even) < 2 * smoother.reach + 4:
        problem = f"{len(rec)} samples are too few for a filter over {2 * smoother.reach + 1}"
        raise InputError(problem, key="filtered", remedy="resample without filtered=True")
    inner = even.t[smoother.valid]
    kept = wanted[(wanted >= inner[0]) & (wanted <= inner[-1])]
    if len(kept) < 2:
        raise InputError("no two new times are left inside the filter's reach", key="filtered", remedy="filtered=False")
    columns = {"t": kept}
    smoothed = {n: smoother.value(values) for n, values in even.channels.items() if not is_held(n)}
    for name in rec.channels:
        if is_held(name):
            columns[name] = _means_of_held(rec, name, kept)
        else:
            inside = made(rec, {"t": inner, name: smoothed[name]}, meta=False)
            columns[name] = _resampled(inside, name, kept, "linear" if method == "linear" else "spline")
    return made(rec, columns)


def _means_of_held(rec: Recording, name: str, times: Array) -> Array:
    """Mean of a held channel from each time to the next; the last interval is as long as the one before."""
    ends = np.append(times, 2 * times[-1] - times[-2])
    row = np.clip(np.searchsorted(rec.t, ends, "right") - 1, 0, None)
    before = np.concatenate([[0.0], np.cumsum(np.diff(rec.t) * rec[name][:-1])])
    impulse = before[row] + (ends - rec.t[row]) * rec[name][row]
    return np.asarray(np.diff(impulse) / np.diff(ends))


def _grid(rec: Recording, rate: float | None) -> Array:
    """Times at an even rate from the first sample on."""
    value = sample_rate(rate)
    count = math.floor(rec.duration * value + 1e-6) + 1
    if not 2 <= count <= 1e9:
        problem = f"{count} samples would come out of {rec.duration:g} s"
        raise InputError(problem, key="rate", value=rate, remedy="give another rate")
    return np.asarray(np.minimum(rec.t[0] + np.arange(count) / value, rec.t[-1]))


def _given_times(rec: Recording, times: npt.ArrayLike) -> Array:
    """The new times as given: increasing, and inside the recording."""
    values = np.array(times, float)
    if values.ndim != 1 or len(values) < 2:
        raise InputError("no column of two times or more", key="times", value=values.shape, remedy="give (samples,)")
    bad = ~np.isfinite(values) | (values < rec.t[0]) | (values > rec.t[-1])
    if bad.any():
        row = int(np.argmax(bad))
        remedy = f"the recording runs from {float(rec.t[0])!r} to {float(rec.t[-1])!r} s"
        problem = f"row {row}: outside the recording"
        raise InputError(problem, key="times", value=float(values[row]), remedy=remedy, row=row)
    if not (np.diff(values) > 0).all():
        row = int(np.argmin(np.diff(values) > 0)) + 1
        problem = f"row {row}: times must increase"
        raise InputError(problem, key="times", value=float(values[row]), remedy="sort them", row=row)
    return values


def _check_gaps(rec: Recording, longest_gap: float | None) -> None:
    """Refuse a gap over which the values would be made up."""
    steps = np.diff(rec.t)
    longest_gap = gap_limit(rec.t) if longest_gap is None else longest_gap
    limit = number("longest_gap", longest_gap, "not a length of time", above=0.0, infinite=True, remedy="give seconds")
    if (steps > limit).any():
        row = int(np.argmax(steps > limit))
        problem = f"row {row}: a gap of {steps[row]:.4g} s follows, longer than {limit:.4g} s"
        remedy = f"split the recording there, .split(gaps={limit:.4g}), or give longest_gap="
        raise InputError(problem, value=float(rec.t[row]), remedy=remedy, row=row, channel="t")
