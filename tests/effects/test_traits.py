"""Users' own effects are treated like flexdyn's wherever code asks what their class declares."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.analysis.regressor import _joints
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis, bounded
from flexdyn.diagnose.hypothesis.linear import tangent_scale
from flexdyn.diagnose.hypothesis.own_effects import _values
from flexdyn.diagnose.report.words import effect_name
from flexdyn.effects import InertiaEffect, JointEffect, base, parameter
from flexdyn.effects.extent import MotionExtent
from flexdyn.model.uncertain_parameters import file_numbers
from flexdyn.simulation.link_side import LinkSide
from tests.arms import unlisted

ARM = fd.load_model("scara_two_link").replace(effects=[])


@unlisted
class Camera(InertiaEffect):
    """A mass in grams, at the tip."""

    grams: float = parameter("g", lower=0.0)

    @property
    def point_mass(self) -> tuple[str | None, float]:
        """In kg."""
        return None, 1e-3 * self.grams


@unlisted
class Belt(JointEffect):
    """The elasticity of a belt."""

    sides = ("transmission",)
    stage = "spring"
    neutral: ClassVar[Mapping[str, float]] = {"rate": math.inf}
    makes_elastic = "rate"
    rate: float = parameter("N m/rad", lower=0.0, strict=True)


@unlisted
class Cogging(JointEffect):
    """Torque of a motor's teeth, whose angle the user calls a lag."""

    sides = ("motor",)
    stage = "actuator"
    neutral: ClassVar[Mapping[str, float]] = {"height": 0.0}
    cycles = "teeth"
    height: float = parameter("N m")
    teeth: float = parameter("1", chosen=True)
    lag: float = parameter("rad", around=True, step=0.02)
    wear: float = parameter("1", default=0.0, step_at_zero=0.003)


@unlisted
class WrongScale(JointEffect):
    """A drive that gives a share more."""

    sides = ("motor",)
    stage = "actuator"
    neutral: ClassVar[Mapping[str, float]] = {"more": 0.0}
    scales_torque = "more"
    more: float = parameter("1")

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """(1 + more) tau."""
        return (1.0 + self.more) * np.asarray(tau)


@unlisted
class Magnet(JointEffect):
    """A law that is called after its inventor."""

    words = "Bitter magnet"
    sides = ("transmission",)
    stage = "spring"
    exact = ("shape",)
    linear = ("pull",)
    pull: float = parameter("N m/rad", lower=0.0)
    shape: float = parameter("1", default=1.0)

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Pull x."""
        return self.pull * np.asarray(x)


@unlisted
class Foam(JointEffect):
    """Soft stops at 2 rad, on either side."""

    sides = ("link",)
    stage = "link"
    keeps_to = "range"
    neutral: ClassVar[Mapping[str, float]] = {"press": 0.0}
    press: float = parameter("N m/rad", lower=0.0)

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Minus press times the position beyond 2 rad."""
        return -self.press * np.sign(x) * np.maximum(np.abs(x) - 2.0, 0.0)


@unlisted
class Grease(JointEffect):
    """Viscous friction by another name."""

    sides = ("link", "motor")
    linear = ("drag",)
    regressed = "viscous"
    drag: float = parameter("N m s/rad", lower=0.0)


def test_a_mass_is_in_the_mass_matrix() -> None:
    """Like a payload of the same mass; no diagnosis estimates it."""
    camera, payload = ([Camera(grams=500.0)], [fd.effects.Payload(mass=0.5)])
    mine, its = (LinkSide(ARM.replace(effects=each)).mass_matrix([0.3, 0.5]) for each in (camera, payload))
    assert np.array_equal(mine, its)
    assert not [each for each in file_numbers(ARM.replace(effects=camera)) if each.of == "effects[0]"]


def test_a_joint_becomes_elastic() -> None:
    """By the parameter that the class names."""
    rigid = ARM.replace(joints={"*": {"stiffness": math.inf}}, initial={})
    soft = rigid.replace(effects=[Belt("elbow", rate=700.0)])
    assert soft.stiffness.tolist() == [math.inf, 700.0]
    assert soft.resolved().effects == ()
    with pytest.raises(fd.InputError, match="belt needs a rigid joint"):
        ARM.replace(effects=[Belt("elbow", rate=700.0)])


def test_a_stop_of_ones_own_keeps_to_the_range() -> None:
    """`enforce_limits` adds no second one at its joint; an effect that says nothing of it changes nothing."""
    model = fd.load_model("ur5").replace(effects=[])
    joint = model.joint_names[0]
    plain, own, other = (
        [each.name for each in fd.enforce_limits(model.replace(effects=effects)).effects]
        for effects in ([], [Foam(joint, press=5.0)], [Grease(joint, side="link", drag=1.0)])
    )
    assert own.count("end_stop") == plain.count("end_stop") - 1
    assert own.count("torque_speed_limit") == plain.count("torque_speed_limit") == model.n
    assert other[1:] == plain


def test_messages_name_effects_of_ones_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """A belt makes a joint elastic too."""
    monkeypatch.setitem(base._registry, Belt.name, Belt)
    rigid = ARM.replace(joints={"*": {"stiffness": math.inf}}, initial={})
    with pytest.raises(fd.InputError, match="or the effect joint_elasticity or belt"):
        rigid.replace(effects=[fd.effects.TransmissionDamping("elbow", coefficient=1.0)])


def test_gains_of_one_joint_add() -> None:
    """Also where one of them is of another class."""
    one, other, both = (WrongScale("elbow", more=more) for more in (0.2, 0.3, 0.5))
    mixed = [one, fd.effects.TorqueConstantError("elbow", gain=0.3)]
    runs = [fd.simulate(ARM.replace(effects=each), [0.0, 0.1], duration=0.1) for each in ([both], [one, other], mixed)]
    assert all(run.q[-1] == pytest.approx(runs[0].q[-1], abs=1e-9) for run in runs[1:])


def test_exact_numbers_are_not_estimated() -> None:
    """Only those that may be wrong are numbers of the file."""
    model = ARM.replace(effects=[Magnet("elbow", pull=1.0)])
    assert [each.parameter for each in file_numbers(model) if each.of == "effects[0]"] == ["pull"]


def test_a_number_of_the_regressor() -> None:
    """The first linear parameter adds to it."""
    numbers = np.reshape(_joints(ARM.replace(effects=[Grease("elbow", side="link", drag=0.7)])), (2, 4))
    assert numbers[:, 1].tolist() == [0.0, 0.7]


def test_its_own_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """In reports; without them the name with spaces."""
    assert effect_name("magnet") == "magnet"
    monkeypatch.setitem(base._registry, "magnet", Magnet)
    assert effect_name("magnet") == "Bitter magnet"


def test_a_fit_asks_what_parameters_declare() -> None:
    """Steps of slopes, bounds of cycles, values around a cycle: whatever the parameters are called."""
    effect = Cogging("elbow", height=0.2, teeth=12.0, lag=0.1)
    scales = {field.name: tangent_scale(effect, field.name) for field in effect.parameters()}
    assert scales == pytest.approx({"height": 0.002, "teeth": 0.12, "lag": 0.02, "wear": 0.003})
    assert [bounded(effect, "teeth", step) for step in (-20.0, 0.5, 20.0)] == pytest.approx([10.8, 12.5, 13.2])
    assert bounded(effect, "lag", -20.0) == pytest.approx(-19.9)
    estimated = Hypothesis(ARM, {}, effects=(effect,)).unknowns()
    with_cycles = Hypothesis(ARM, {}, effects=(effect,), fits_cycles=True).unknowns()
    assert [name for _, name in estimated] == ["height", "lag", "wear"]
    assert [name for _, name in with_cycles] == ["height", "teeth", "lag", "wear"]
    extent = MotionExtent(1.0, 1.0, 0.01, 5.0, 5.0, 4.0, low=-0.5, high=0.5, ratio=1.0)
    tried = {field.name: _values(field, extent) for field in effect.parameters()}
    assert tried["lag"] == pytest.approx(np.arange(8) * np.pi / 4.0)
    assert max(tried["teeth"]) == 8.0
