"""Commands as frozen data: torques over time, joint tracking at a control rate, a law in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array, as_numbers, check_known, number
from flexdyn.control.curves import curve
from flexdyn.errors import InputError

Interpolation = Literal["hold", "linear", "monotone", "cubic"]
INTERPOLATIONS = ("hold", "linear", "monotone", "cubic")


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
        _check_interpolation("interpolation", interpolation)
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
        """Columns at times from the first sample on (times, width); after the end their last value."""
        from scipy.interpolate import PPoly

        breaks, coefficients, last = self.pieces(columns)
        values = PPoly(coefficients[:, ::-1].swapaxes(0, 1), breaks)(t)
        return np.where((t >= breaks[-1])[:, None], last, values)


@dataclass(frozen=True, eq=False)
class PD:
    """Joint tracking at a control rate; the torque is held between the ticks.

    ``tau = feedforward(t) + kp (reference - y) + kd (reference' - y')``, y = theta or q. After its end, the reference
    keeps its last value, and there is no feedforward.

    Args:
        reference: positions [rad or m]: `Samples` with cubic or linear interpolation, so that the velocity is useful; a
            recording with ``q`` or ``theta`` columns, or its path.
        kp: [N m/rad], one for all, one per joint, or a mapping by joint.
        kd: [N m s/rad], likewise.
        rate: of the controller [Hz].
        feedback: ``theta`` (motor side) or ``q`` (link side).
        feedforward: torques to add (`Samples`, a recording with ``tau`` columns, or its path).
        interpolation: of a reference that is a recording: ``monotone`` (default: through its samples, never outside the
            range of two neighbours), ``hold`` (steps), ``linear`` or ``cubic``; `Samples` have their own.

    Example:
        >>> reference = fd.Samples([0, 1], {"shoulder": [0.0, 0.5], "elbow": [0.0, 1.0]}, "cubic")
        >>> command = fd.PD(reference, kp=20.0, kd=2.0)
        >>> fd.simulate(fd.load_model("scara_two_link"), command, duration=1.0).q.shape
        (1001, 2)
    """

    reference: Any
    kp: float | ArrayLike | Mapping[str, float]
    kd: float | ArrayLike | Mapping[str, float]
    rate: float = 1000.0
    feedback: Literal["theta", "q"] = "theta"
    feedforward: Any = None
    interpolation: Interpolation | None = None

    def __post_init__(self) -> None:
        """Check what needs no robot."""
        if self.interpolation is not None:
            _check_interpolation("pd.interpolation", self.interpolation)
            if isinstance(self.reference, Samples):
                remedy = "give it to the Samples"
                raise InputError("Samples have their own interpolation", key="pd.interpolation", remedy=remedy)
        check_feedback("pd.feedback", self.feedback)
        object.__setattr__(self, "rate", checked_rate("pd.rate", self.rate))


@dataclass(frozen=True)
class State:
    """The input of a controller: all joints at one instant; for a rigid joint theta = q and omega = v.

    Attributes:
        q: link positions (n,) [rad or m].
        v: link velocities (n,).
        theta: rotor positions, reflected (n,).
        omega: rotor velocities, reflected (n,).

    Example:
        >>> seen = []
        >>> def law(t, state):
        ...     seen.append(state.q.copy())
        ...     return [0.0, 0.0]
        >>> run = fd.simulate(fd.load_model("scara_two_link"), fd.Controller(law, rate=100), duration=0.1)
        >>> bool((seen[0] == run.q[0]).all())
        True
    """

    q: Array
    v: Array
    theta: Array
    omega: Array


@dataclass(frozen=True)
class Controller:
    """A control law in Python, called at a control rate; the torque is held between the calls.

    Args:
        law: ``law(t, state) -> tau`` with t [s], a `State` and torques (n,) [N m or N].
        rate: [Hz].

    Example:
        >>> brake = fd.Controller(lambda t, state: -0.1 * state.omega, rate=500)
        >>> run = fd.simulate(fd.load_model("scara_two_link"), brake, duration=0.5, v0=[1.0, 0.0])
        >>> bool(abs(run.v[-1, 0]) < 1.0)
        True
    """

    law: Callable[[float, State], ArrayLike]
    rate: float = 1000.0

    def __post_init__(self) -> None:
        """Check law and rate."""
        if not callable(self.law):
            raise InputError("a callable law(t, state) is needed", key="controller.law", value=self.law)
        object.__setattr__(self, "rate", checked_rate("controller.rate", self.rate))


@dataclass(frozen=True, eq=False)
class FrameWrench:
    """An external force and moment at a frame: the paper's end-of-arm force and moment vector.

    ``tau_ext = J(q)^T (force, moment)``, J the Jacobian of the frame; zero after the samples' end.

    Args:
        frame: its name, for example the tool.
        samples: six columns fx, fy, fz [N], mx, my, mz [N m] (`Samples`), or six constant numbers.
        axes: ``world`` (of the base) or ``frame``, in which the six are given.

    Example:
        >>> push = fd.FrameWrench("tool", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])  # 1 N along y
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, external=push)
        >>> bool(run.q[-1, 0] > 0.0)
        True
    """

    frame: str
    samples: Samples | ArrayLike
    axes: Literal["world", "frame"] = "world"
    constant: Array | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Check that there are six columns."""
        remedy = "they are world or frame"
        check_known(self.axes, ("world", "frame"), "no such axes", key="external.axes", value=self.axes, remedy=remedy)
        if isinstance(self.samples, Samples):
            width = self.samples.values.shape[1]
        else:
            constant = as_numbers("external.samples", self.samples)
            if not np.isfinite(constant).all():
                raise InputError("finite numbers are needed", key="external.samples", value=constant)
            constant.setflags(write=False)
            object.__setattr__(self, "constant", constant)
            width = constant.size
        if width != 6:
            remedy = "give fx, fy, fz, mx, my, mz"
            raise InputError("a wrench has six columns", key="external.samples", value=width, remedy=remedy)


def _check_interpolation(key: str, given: Any) -> None:
    remedy = f"it is {', '.join(INTERPOLATIONS)}"
    check_known(given, INTERPOLATIONS, "no such interpolation", key=key, value=given, remedy=remedy)


def check_feedback(key: str, given: Any) -> None:
    """Check from which side of the joints a controller gets its positions.

    Raises:
        InputError: it is neither.
    """
    check_known(given, ("theta", "q"), "no such feedback", key=key, value=given, remedy="it is theta or q")


def checked_rate(key: str, rate: Any) -> float:
    """Check a rate in Hz: finite and above 0.

    Raises:
        InputError: it is not.
    """
    return number(key, rate, "a rate above 0 Hz is needed", above=0.0)


def per_joint(key: str, value: Any, joint_names: Sequence[str]) -> Array:
    """One number for all joints, one per joint, or a mapping by joint, as (n,).

    Raises:
        InputError: wrong length, an unknown or missing joint, a number that is not finite.
    """
    n = len(joint_names)
    if isinstance(value, Mapping):
        for joint in value:
            remedy = f"the joints are {', '.join(joint_names)}"
            check_known(joint, joint_names, "the robot has no such joint", key=f"{key}.{joint}", remedy=remedy)
        for joint in joint_names:
            if joint not in value:
                raise InputError("a joint is missing", key=f"{key}.{joint}", remedy="give it a number, 0 for none")
        value = [value[joint] for joint in joint_names]
    array = as_numbers(key, value)
    if array.ndim > 1 or (array.ndim == 1 and len(array) != n):
        raise InputError(f"one number, or one for each of the {n} joints, is needed", key=key, value=array.shape)
    if not np.isfinite(array).all():
        raise InputError("finite numbers are needed", key=key, value=value)
    return np.array(np.broadcast_to(array, (n,)))


def _side_by_side(columns: Mapping[str, ArrayLike]) -> Array:
    arrays = [as_numbers(f"values.{joint}", column) for joint, column in columns.items()]
    if len({array.shape for array in arrays}) != 1 or arrays[0].ndim != 1:
        shapes = {joint: array.shape for joint, array in zip(columns, arrays, strict=True)}
        raise InputError("one column (samples,) a joint is needed, all of one length", key="values", value=shapes)
    return np.column_stack(arrays)
