"""Commands as frozen data: joint tracking at a control rate, a law in Python, external wrenches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.checks import Array, as_numbers, check_known
from flexdyn.control.samples import Samples
from flexdyn.control.setting_checks import Interpolation, check_feedback, check_interpolation, checked_rate
from flexdyn.errors import InputError


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
            check_interpolation("pd.interpolation", self.interpolation)
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
