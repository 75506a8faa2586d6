"""Samples: values over time, held or interpolated; as a command, torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array, as_numbers, check_known
from flexdyn.control.curves import curve
from flexdyn.control.setting_checks import Interpolation, check_interpolation
from flexdyn.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class Samples:
    """Values over time, held or interpolated; as a command, torques [N m or N] and zero after the end.

    Args:
        t: times (samples,) [s], strictly increasing; the run starts at the first.
        values: (samples, n), one column for each joint in the order of q, or a mapping from joint to (samples,).
        interpolation: ``hold`` (from this sample to the next), ``linear``, ``monotone`` (cubic pieces with a continuous
            velocity that never leave the range between two samples: Fritsch and Carlson, SIAM J. Numer. Anal. 17,
            1980) or ``cubic`` (a C2 spline, which may overshoot).

    Raises:
        InputError: shapes that do not fit, values that are not finite, time that does not increase.

    Example:
        >>> torque = fd.Samples([0.0, 1.0], {"shoulder": [0.3, -0.3], "elbow": [0.0, 0.1]})  # held for 1 s each
        >>> fd.simulate(fd.load_model("scara_two_link"), torque, duration=2.0).tau[500]
        array([0.3, 0. ])
    """

    t: Array
    values: Array
    interpolation: Interpolation = "hold"
    joints: tuple[str, ...] | None = None

    def __init__(
        self, t: ArrayLike, values: ArrayLike | Mapping[str, ArrayLike], interpolation: Interpolation = "hold"
    ) -> None:
        joints = None
        if isinstance(values, Mapping):
            joints = tuple(str(joint) for joint in values)
            values = _side_by_side(values)
        times, table = as_numbers("t", t), as_numbers("values", values)
        table = table[:, None] if table.ndim == 1 else table
        if times.ndim != 1 or len(times) < 2 or table.ndim != 2 or len(table) != len(times):
            shapes = f"t {times.shape}, values {table.shape}"
            raise InputError("t is (samples,) and values (samples, n), 2 samples or more", key="samples", value=shapes)
        for name, array in (("t", times), ("values", table)):
            if not np.isfinite(array).all():
                row = int(np.argwhere(~np.isfinite(array))[0][0])
                raise InputError("a finite number is needed", key=f"samples.{name}[{row}]", value=array[row], row=row)
        if not (np.diff(times) > 0).all():
            row = int(np.argmin(np.diff(times) > 0)) + 1
            raise InputError("time must increase", key=f"samples.t[{row}]", value=float(times[row]), row=row)
        check_interpolation("interpolation", interpolation)
        for array in (times, table):
            array.setflags(write=False)
        for key, entry in (("t", times), ("values", table), ("interpolation", interpolation), ("joints", joints)):
            object.__setattr__(self, key, entry)

    def __reduce__(self) -> tuple[Any, ...]:
        """Unpickle through the constructor, so that arrays are read-only again."""
        named = self.values if self.joints is None else dict(zip(self.joints, self.values.T, strict=True))
        return (type(self), (self.t, named, self.interpolation))

    def __repr__(self) -> str:
        """Number of samples and joints, and the time span, in one line."""
        names = f" of {', '.join(self.joints)}" if self.joints else ""
        size = f"{len(self.t)} by {self.values.shape[1]}"
        return f"<{type(self).__name__} {size}{names}, {self.t[0]:g} to {self.t[-1]:g} s, {self.interpolation}>"

    @property
    def duration(self) -> float:
        """From the first to the last sample [s]."""
        return float(self.t[-1] - self.t[0])

    def columns(self, joint_names: Sequence[str]) -> Array:
        """The values in the order of `joint_names`; a joint that was not named gets zeros.

        Raises:
            InputError: too many or too few columns, or an unknown joint.
        """
        place = {"key": "samples.values", "remedy": f"the joints are {', '.join(joint_names)}"}
        if self.joints is None:
            if self.values.shape[1] != len(joint_names):
                raise InputError(f"{len(joint_names)} columns are needed", value=self.values.shape[1], **place)
            return self.values
        out = np.zeros((len(self.t), len(joint_names)))
        for k, joint in enumerate(self.joints):
            check_known(joint, joint_names, "the robot has no such joint", value=joint, **place)
            out[:, list(joint_names).index(joint)] = self.values[:, k]
        return out

    def pieces(self, columns: Array) -> tuple[Array, Array, Array]:
        """Breaks (from 0), polynomial coefficients (segments, degree + 1, width) and the last value, for the core.

        Raises:
            InputError: times or values so large, or so close to each other, that the curve is not finite.
        """
        return curve(self.t, columns, self.interpolation)

    def at(self, t: Array, columns: Array) -> Array:
        """Columns at times from the first sample on (times, width); after the end their last value.

        Args:
            t: times from the first sample on (times,) [s].
            columns: values at the samples (samples, width).
        """
        from scipy.interpolate import PPoly

        breaks, coefficients, last = self.pieces(columns)
        values = PPoly(coefficients[:, ::-1].swapaxes(0, 1), breaks)(t)
        return np.where((t >= breaks[-1])[:, None], last, values)


def _side_by_side(columns: Mapping[str, ArrayLike]) -> Array:
    arrays = [as_numbers(f"values.{joint}", column) for joint, column in columns.items()]
    if len({array.shape for array in arrays}) != 1 or arrays[0].ndim != 1:
        shapes = {joint: array.shape for joint, array in zip(columns, arrays, strict=True)}
        raise InputError("one column (samples,) for each joint is needed, all equally long", key="values", value=shapes)
    return np.column_stack(arrays)
