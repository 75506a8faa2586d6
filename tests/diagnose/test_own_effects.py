"""Effects of users' own as hypotheses: hidden in motions that were computed without flexdyn, and laws that fail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.hypothesis.own_effects import own_effects
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.effects import Effect, JointEffect, base, parameter
from tests.arms import two_link, unlisted
from tests.diagnose.truths import ARM, JOINTS, RATE, Levels
from tests.oracles.integrate import held

CUBE = 0.2


@unlisted
class CubicFriction(JointEffect):
    """Friction with the cube of the velocity; for single numbers only."""

    sides = ("link", "motor")
    coefficient: float = parameter("N m s^3/rad^3", lower=0.0)

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Coefficient u^3, in a way that arrays do not take."""
        return self.coefficient * u**3 if u > 0.0 else -self.coefficient * abs(u) ** 3


@unlisted
class Detent(JointEffect):
    """A magnet at one place."""

    sides = ("motor",)
    pull: float = parameter("N m")
    place: float = parameter("rad")
    width: float = parameter("rad", lower=0.0, strict=True, default=0.1)

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Pull z exp(-z^2)."""
        z = (x - self.place) / self.width
        return self.pull * z * np.exp(-z * z)


@unlisted
class Product(JointEffect):
    """Two numbers that stand for one."""

    sides = ("transmission",)
    stage = "spring"
    one: float = parameter("N m/rad")
    other: float = parameter("1")

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """One other delta."""
        return self.one * self.other * x


@unlisted
class Broken(CubicFriction):
    """A law with a mistake in it."""

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Fails."""
        raise ZeroDivisionError("my own mistake")


@unlisted
class NotANumber(CubicFriction):
    """A law that has no value."""

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Not a number."""
        return np.nan * u


@unlisted
class NoJoint(Effect):
    """An effect on nothing."""


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Enters classes in the catalogue for the time of a test."""

    def enter(*kinds: type[Effect]) -> None:
        for kind in kinds:
            monkeypatch.setitem(base._registry, kind.name, kind)

    return enter


def rubbing(x: Sequence[float], tau: Sequence[float]) -> list[float]:
    """ARM with a cubic friction at the shoulder's motor; states are [q, theta, v, omega]."""
    rate = ARM.derivative(x, tau)
    rate[6] -= CUBE * x[6] ** 3 / ARM.rotor[0]
    return rate


@cache
def recording() -> fd.Recording:
    """6 s of it, both encoders."""
    levels, t = Levels(), np.arange(round(6.0 * RATE)) / RATE
    tau = np.stack([3.0 * np.sin(5.1 * t + 0.5) + np.sin(13.0 * t), np.sin(6.7 * t) + 0.5 * np.sin(17.0 * t)], axis=1)
    rows = iter(tau.tolist())
    states, _ = held(rubbing, [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0], t, lambda _t, _x: next(rows))
    draw, step = np.random.default_rng(3), np.sqrt(12.0) * levels.position
    channels = {
        f"tau.{joint}": tau[:, j] + levels.torque * draw.standard_normal(len(t)) for j, joint in enumerate(JOINTS)
    }
    for j, joint in enumerate(JOINTS):
        channels[f"q.{joint}"] = step * np.round(states[:, j] / step)
        channels[f"theta.{joint}"] = step * np.round(states[:, 2 + j] / step)
    return fd.Recording(t, channels)


def equations() -> Equations:
    """Of the arm along the motion."""
    model = two_link(ARM)
    data = measured(model, recording())
    return Equations(model, (data,), Filters.of_rate(data.dt))


def test_a_users_effect_is_named_like_the_catalogues(known: Callable[..., None]) -> None:
    """Where it is registered: at its joint and side, with its number; one whose law fails is said to be left out."""
    known(CubicFriction, Broken)
    answer = fd.diagnose(two_link(ARM), [recording()])
    (finding,) = answer.findings
    suspect = finding.suspect
    assert (suspect.effect, suspect.joint, suspect.side) == ("cubic_friction", "shoulder", "motor")
    assert suspect.parameters["coefficient"].value == pytest.approx(CUBE, rel=0.05)
    assert not finding.rivals
    assert [note.split(",")[0] for note in answer.notes if "effect of your own" in note] == ["broken"]


def test_what_is_not_registered_is_not_proposed() -> None:
    """Classes that are not in the catalogue play no part."""
    assert own_effects(equations()) == ([], [])


def test_numbers_are_linear_where_the_torque_is(known: Callable[..., None]) -> None:
    """Found from the law itself: an amplitude is, a place and a width are not, and of a product only one factor."""
    known(CubicFriction, Detent, Product)
    found, notes = own_effects(equations())
    assert not notes
    kinds = {(each.place["effect"], each.place["side"]): each for each in found if each.place["joint"] == "elbow"}
    assert set(kinds) == {
        ("cubic_friction", "link"), ("cubic_friction", "motor"), ("detent", "motor"), ("product", "transmission"),
    }  # fmt: skip
    assert kinds["cubic_friction", "link"].grid == ((),)
    assert kinds["cubic_friction", "link"].positive == (True,)
    magnet = kinds["detent", "motor"]
    assert len(magnet.grid[0]) == 2
    assert magnet.make(magnet.grid[0], np.array([0.7])) == Detent("elbow", pull=0.7, place=magnet.grid[0][0], width=0.1)
    assert len(kinds["product", "transmission"].grid[0]) == 1


def test_laws_that_fail_are_left_out_with_a_line_on_each(known: Callable[..., None]) -> None:
    """Exceptions, no number, no joint: said, and nothing else is the worse for it."""
    known(Broken, NotANumber, NoJoint, Detent)
    found, notes = own_effects(equations())
    assert {each.place["effect"] for each in found} == {"detent"}
    said = dict(note.split(", an effect of your own, is not proposed: ") for note in sorted(notes))
    assert said["broken"] == "its law fails along the measured motion: ZeroDivisionError: my own mistake"
    assert said["not_a_number"] == "its law gives no finite torque along the measured motion"
    assert said["no_joint"] == "it is no torque of stage friction, spring or actuator on a joint"


def test_a_law_that_fails_in_a_window_is_a_window_that_fails() -> None:
    """Far from the data a law may do what it wants: the gap is large, and no exception comes out."""
    model, run = two_link(ARM, [Broken("elbow", side="link", coefficient=1.0)]), recording()
    windows = Windows.of(model, [run], Levels().noise(), most=2)
    assert shoot(model, windows).gap > 100.0
