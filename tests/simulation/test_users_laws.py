"""Laws that users write in Python: the same motion as the compiled ones, and exceptions that come through."""

from __future__ import annotations

import functools
import math
from typing import Any, ClassVar

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import (
    Effect,
    JointEffect,
    TorqueSpeedLimit,
    TransmissionDamping,
    ViscousFriction,
    parameter,
)
from flexdyn.effects.base import Stage
from tests.arms import BENT, state, two_link, unlisted
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
SOLVERS = [fd.solvers.DormandPrince(smoothing=1e-3), fd.solvers.RungeKutta4(step=1e-3, smoothing=0.05)]
"""Neither locates events, so that a law with a corner takes the same steps in Python and in the core."""
LOCATING = [fd.solvers.DormandPrince(), fd.solvers.Rosenbrock(rtol=1e-8, atol=1e-10)]


@unlisted
class MyFriction(JointEffect):
    """Viscous friction, in Python."""

    sides = ("link", "motor")
    stage = "friction"
    coefficient: float = parameter("N m s/rad")

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Coefficient u."""
        return self.coefficient * u


@unlisted
class MyDamper(JointEffect):
    """Transmission damping, in Python."""

    sides = ("transmission",)
    stage = "spring"
    coefficient: float = parameter("N m s/rad")

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Coefficient (omega - v)."""
        return self.coefficient * u


@unlisted
class MyLimit(JointEffect):
    """The torque-speed line, in Python."""

    sides = ("motor",)
    stage = "actuator"
    stall: float = parameter("N m")
    speed: float = parameter("rad/s")

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Clipped to the line."""
        upper, lower = max(0.0, self.stall * (1.0 - u / self.speed)), min(0.0, -self.stall * (1.0 + u / self.speed))
        return min(max(tau, lower), upper)


PAIRS: list[tuple[JointEffect, JointEffect]] = [
    (ViscousFriction("elbow", side="link", coefficient=0.3), MyFriction("elbow", side="link", coefficient=0.3)),
    (ViscousFriction("elbow", side="motor", coefficient=0.3), MyFriction("elbow", side="motor", coefficient=0.3)),
    (TransmissionDamping("shoulder", coefficient=0.3), MyDamper("shoulder", coefficient=0.3)),
    (TorqueSpeedLimit("elbow", stall_torque=0.3, no_load_speed=2.0), MyLimit("elbow", stall=0.3, speed=2.0)),
]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("own", "users"), PAIRS, ids=lambda effect: effect.name)
def test_a_law_in_python_moves_as_the_built_in_one(
    own: JointEffect, users: JointEffect, solver: fd.solvers.Solver
) -> None:
    """A user's class in every stage and on every side gives the trajectory of the compiled law."""
    runs = [fd.simulate(two_link(ARM, [effect]), [0.4, 0.3], 0.5, solver, **BENT) for effect in (own, users)]
    np.testing.assert_allclose(state(runs[0]), state(runs[1]), atol=1e-13)
    np.testing.assert_allclose(runs[0].tau_applied, runs[1].tau_applied, atol=1e-13)


@pytest.mark.parametrize("solver", LOCATING, ids=lambda solver: type(solver).__name__)
@pytest.mark.parametrize(("own", "users"), PAIRS, ids=lambda effect: effect.name)
def test_a_corner_in_python_is_stepped_over(own: JointEffect, users: JointEffect, solver: fd.solvers.Solver) -> None:
    """A solver that locates the core's corners crosses those of a class in Python within its tolerance."""
    runs = [fd.simulate(two_link(ARM, [effect]), [0.4, 0.3], 0.5, solver, **BENT) for effect in (own, users)]
    located = isinstance(own, TorqueSpeedLimit)
    assert [run.stats["events"] for run in runs] == [int(located), 0]
    np.testing.assert_allclose(state(runs[0]), state(runs[1]), atol=1e-7 if located else 1e-13)


@unlisted
class SeenByALaw(JointEffect):
    """Remembers what it was called with."""

    sides = ("link", "motor", "transmission")
    stage = "friction"

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """No torque."""
        SEEN.append((t, x, u, tau))
        return 0.0


SEEN: list[tuple[float, float, float, float]] = []


def test_a_law_sees_its_own_side() -> None:
    """Position and velocity of link or rotor, and the time since the start of the run."""
    for side, x, u in (("link", 0.1, 0.3), ("motor", 0.2, 0.4)):
        SEEN.clear()
        model = two_link(ARM, [SeenByALaw("elbow", side=side)])  # type: ignore[arg-type]
        solver = "DormandPrince"  # auto would look at the law before the run
        fd.simulate(model, None, 0.01, solver, q0=[0, 0.1], theta0=[0, 0.2], v0=[0, 0.3], omega0=[0, 0.4])
        assert SEEN[0] == (0.0, x, u, 0.0)
        assert max(t for t, *_ in SEEN) == pytest.approx(0.01)


@unlisted
class Broken(JointEffect):
    """A law with a mistake in it."""

    sides = ("link",)
    stage = "friction"

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Fails after a while."""
        if t > 0.05:
            raise ZeroDivisionError("my own mistake")
        return 0.0


@unlisted
class Nonsense(JointEffect):
    """A law that returns no number."""

    sides = ("link",)
    stage: ClassVar[Stage] = "friction"

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Text."""
        return "a lot"


def test_exceptions_in_a_law_come_through() -> None:
    """As what they are, with the user's own frame in the traceback; the next run is none the worse."""
    with pytest.raises(ZeroDivisionError, match="my own mistake") as caught:
        fd.simulate(two_link(ARM, [Broken("elbow")]), None, 1.0)
    assert caught.traceback[-1].name == "torque"
    with pytest.raises(ValueError, match="could not convert"):
        fd.simulate(two_link(ARM, [Nonsense("elbow")]), None, 1.0)
    assert fd.simulate(two_link(ARM), None, 0.1).t[-1] == pytest.approx(0.1)


def test_exceptions_in_a_controller_come_through() -> None:
    """Also what it returns is checked: n finite torques."""

    def broken(t: float, x: fd.State) -> Any:
        if t >= 0.1:
            raise KeyError("gain")
        return [0.0, 0.0]

    with pytest.raises(KeyError, match="gain"):
        fd.simulate(two_link(ARM), fd.Controller(broken), 1.0)
    wrong: Any
    for wrong in ([0.0], [0.0, math.nan], 1.0, [[0.0, 0.0]]):
        returning = fd.Controller(functools.partial(lambda torque, t, x: torque, wrong))
        with pytest.raises(fd.InputError, match=r"t = 0 s: the controller returned no valid torque.*2 finite torques"):
            fd.simulate(two_link(ARM), returning, 1.0)


@unlisted
class NoLaw(JointEffect):
    """A class that forgot its law."""

    sides = ("link",)


@unlisted
class DryInPython(Nonsense):
    """Set-valued laws are the core's alone."""

    stage = "dry"


@unlisted
class SpringOnALink(Nonsense):
    """A spring that stands beside the transmission."""

    stage = "spring"


@unlisted
class NoJoint(Effect):
    """An effect on nothing."""

    stage = "friction"


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (NoLaw("elbow"), r"^no_law: the core has no law of this name; write its law in Python: override torque"),
        (DryInPython("elbow"), r"^dry_in_python\.stage: no stage for a law in Python, got 'dry'"),
        (SpringOnALink("elbow"), r"^spring_on_a_link\.side: a law of stage spring does not act on this side"),
        (NoJoint(), r"^no_joint: an effect in the plant acts on a joint; derive it from JointEffect"),
    ],
)
def test_a_users_class_that_cannot_run(effect: Effect, words: str) -> None:
    """A clear line on what its class lacks."""
    with pytest.raises(fd.InputError, match=words):
        fd.simulate(two_link(ARM, [effect]), None, 0.1)
