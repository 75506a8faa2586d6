"""Solver settings: frozen data; the integrators themselves are in the compiled core."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from typing import Any

from flexdyn.checks import as_number
from flexdyn.errors import InputError, did_you_mean

__all__ = [
    "SOLVERS",
    "DormandPrince",
    "DormandPrinceThenRosenbrock",
    "Rosenbrock",
    "RungeKutta4",
    "Solver",
    "TimeStepping",
    "make_solver",
]


@dataclass(frozen=True, kw_only=True)
class Solver:
    """Base of the solvers' settings.

    Example:
        >>> fd.solvers.TimeStepping(step=2e-3).to_dict()
        {'name': 'TimeStepping', 'step': 0.002}
    """

    def __post_init__(self) -> None:
        """Check every setting: numbers above 0."""
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None and field.default is None:
                continue
            number = as_number(value)
            if isinstance(value, bool) or not isinstance(value, int | float) or not number > 0:
                raise InputError("a number above 0 is needed", key=f"solver.{field.name}", value=value)
            if math.isinf(number) and field.default != math.inf:
                raise InputError("it must be finite", key=f"solver.{field.name}", value=value)

    def to_dict(self) -> dict[str, Any]:
        """As a study file writes it: ``{name: ..., settings}``, without those that are infinite or None."""
        settings = {key: value for key, value in asdict(self).items() if value is not None and math.isfinite(value)}
        return {"name": type(self).__name__} | settings


@dataclass(frozen=True, kw_only=True)
class RungeKutta4(Solver):
    """The classical method of order 4 at a fixed step, for smooth laws.

    Between two switches of the command it takes equal steps, none longer than `step`.

    Args:
        step: [s].
        smoothing: width eps of tanh(u/eps), which replaces Sgn(u) [rad/s]; without it dry friction is refused.

    Example:
        >>> solver = fd.solvers.RungeKutta4(step=1e-4, smoothing=1e-3)
        >>> fd.simulate(fd.load_model("scara_two_link"), duration=0.1, v0=[0.5, 0.0], solver=solver).q.shape
        (101, 2)
    """

    step: float
    smoothing: float | None = None


@dataclass(frozen=True, kw_only=True)
class _Adaptive(Solver):
    """Settings of the solvers that adapt their steps to an error."""

    rtol: float
    atol: float
    max_step: float = math.inf
    smoothing: float | None = None
    max_steps: float | None = None


@dataclass(frozen=True, kw_only=True)
class DormandPrince(_Adaptive):
    """Dormand-Prince 5(4): adaptive steps, dense output of order 4; the reference.

    The local error of every state is kept below ``atol + rtol |x|`` (root mean square over the state).

    Args:
        rtol: relative tolerance [1].
        atol: absolute tolerance [rad, rad/s].
        max_step: [s].
        smoothing: without it dry friction sticks exactly and every switch is located as an event; with it Sgn(u) is
            smoothed to tanh(u/smoothing) [rad/s], and a loaded joint creeps.
        max_steps: a run that tries more steps fails, and the error says why they are so short; switches of the command
            do not count. Default: 200,000 and 50,000 more for every simulated second.

    Example:
        >>> solver = fd.solvers.DormandPrince(rtol=1e-6, atol=1e-8)
        >>> fd.simulate(fd.load_model("scara_two_link"), duration=0.1, v0=[0.5, 0.0], solver=solver).q.shape
        (101, 2)
    """

    rtol: float = 1e-8
    atol: float = 1e-10


@dataclass(frozen=True, kw_only=True)
class Rosenbrock(_Adaptive):
    """RODAS, order 4(3), L-stable: for stiff springs and friction whose bristles are stiff.

    The local error is kept as in `DormandPrince`; the Jacobian is Pinocchio's, analytic.

    Args:
        rtol: relative tolerance [1].
        atol: absolute tolerance [rad, rad/s].
        max_step: [s].
        smoothing: as in `DormandPrince`.
        max_steps: likewise. Default: 50,000 and 40,000 more for every simulated second.

    Example:
        >>> dry = [fd.effects.PreslidingFriction("elbow", side="link", level=0.1, stiffness=1e5)]
        >>> arm = fd.load_model("scara_two_link").replace(effects=dry)
        >>> fd.simulate(arm, duration=0.1, v0=[0.5, 0.0], solver=fd.solvers.Rosenbrock(rtol=1e-5)).q.shape
        (101, 2)
    """

    rtol: float = 1e-6
    atol: float = 1e-8


@dataclass(frozen=True, kw_only=True)
class DormandPrinceThenRosenbrock(Solver):
    """`DormandPrince` first, `Rosenbrock` from a time on: the choice of ``auto`` in a run that became stiff.

    Both have their default settings. With this solver such a run can be repeated bit for bit.

    Args:
        until: Rosenbrock takes over at the first step that ends at this time or later [s].

    Example:
        >>> solver = fd.solvers.DormandPrinceThenRosenbrock(until=0.05)
        >>> fd.simulate(fd.load_model("scara_two_link"), duration=0.1, v0=[0.5, 0.0], solver=solver).q.shape
        (101, 2)
    """

    until: float


@dataclass(frozen=True, kw_only=True)
class TimeStepping(Solver):
    """Fixed steps without events: springs and dampers implicit, sticking exact, order 1.

    Each step solves a boxed complementarity problem in the velocities. The method is stable for any stiffness and
    damping if the steps resolve the motion of the rigid arm; it damps vibrations that the steps do not resolve.

    Args:
        step: [s].

    Example:
        >>> dry = [fd.effects.CoulombFriction("elbow", side="link", level=0.1)]
        >>> arm = fd.load_model("scara_two_link").replace(effects=dry)
        >>> run = fd.simulate(arm, duration=0.1, solver=fd.solvers.TimeStepping(step=1e-3))
        >>> bool((run.v[:, 1] == 0.0).all())  # friction holds the elbow: no creep
        True
    """

    step: float = 1e-3


SOLVERS: dict[str, type[Solver]] = {
    solver.__name__: solver for solver in (RungeKutta4, DormandPrince, Rosenbrock, TimeStepping)
}


def make_solver(name: str, **settings: float | None) -> Solver:
    """Make a solver by name, with the given settings.

    Args:
        name: ``RungeKutta4`` or ``DormandPrince``; ``auto`` is resolved by `simulate`, which knows the model.
        settings: None means the default.

    Raises:
        InputError: no such solver, a setting that it does not have, or a missing one.

    Example:
        >>> fd.solvers.make_solver("DormandPrince", rtol=1e-6).rtol
        1e-06
    """
    if name not in SOLVERS:
        raise InputError("no such solver", key="solver", value=name, remedy=did_you_mean(name, [*SOLVERS, "auto"]))
    kind = SOLVERS[name]
    known = {field.name for field in fields(kind)}
    given = {key: value for key, value in settings.items() if value is not None}
    for key in given:
        if key not in known:
            remedy = f"{name} takes {', '.join(sorted(known))}"
            raise InputError(f"{name} has no such setting", key=f"solver.{key}", value=given[key], remedy=remedy)
    if kind is RungeKutta4 and "step" not in given:
        raise InputError("RungeKutta4 needs a step", key="solver.step", remedy="give it in s, for example 0.0001")
    return kind(**given)


def __dir__() -> list[str]:
    """What tab completion offers: the names that users need."""
    return list(__all__)
