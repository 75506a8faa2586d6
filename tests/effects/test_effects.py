"""The catalogue: laws against their formulas written a second time, bounds, units, neutral values, users' own."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.batch.places import places
from flexdyn.cli.info import _effect as shown_effect
from flexdyn.diagnose.decision.suspects import numbers_of
from flexdyn.diagnose.report.calibrated import number_as_given
from flexdyn.effects import (
    CoulombFriction,
    JointEffect,
    Payload,
    StribeckFriction,
    TorqueOffset,
    TorqueSpeedLimit,
    TransmissionDamping,
    ViscousFriction,
    base,
    effect_from_dict,
    parameter,
    unit_for,
)
from flexdyn.model.resolved_parameters import units_of
from tests.arms import slider, unlisted
from tests.oracles import laws

SPEED = st.floats(-50, 50)
POSITIVE = st.floats(1e-3, 1e3)


@given(u=SPEED, coefficient=POSITIVE)
def test_viscous_laws(u: float, coefficient: float) -> None:
    """Coefficient times velocity, in friction and in the transmission."""
    expected = laws.viscous(u, coefficient)
    assert ViscousFriction("j", side="link", coefficient=coefficient).torque(0.0, u) == expected
    assert TransmissionDamping("j", coefficient=coefficient).torque(0.3, u) == expected


@given(u=SPEED, tau=st.floats(-20, 20), stall=POSITIVE, no_load=POSITIVE, offset=st.floats(-5, 5))
def test_actuator_laws(u: float, tau: float, stall: float, no_load: float, offset: float) -> None:
    """The offset adds; the torque-speed line clips and never pushes on its own."""
    limit = TorqueSpeedLimit("j", stall_torque=stall, no_load_speed=no_load)
    limited = float(limit.torque(0.0, u, tau=tau))
    assert limited == pytest.approx(laws.torque_speed_limit(tau, u, stall, no_load), rel=1e-12, abs=1e-12)
    assert limited * tau >= 0.0
    assert abs(limited) <= abs(tau)
    assert TorqueOffset("j", offset=offset).torque(0.0, u, tau=tau) == tau + offset


@given(u=SPEED, b_v=POSITIVE, b_d=POSITIVE, more=POSITIVE, epsilon=POSITIVE)
def test_the_papers_friction_is_the_sum_of_three(u: float, b_v: float, b_d: float, more: float, epsilon: float) -> None:
    """Eq. 1: viscous b^v, Coulomb b^d and Stribeck with excess b^s - b^d and velocity epsilon."""
    parts: list[JointEffect] = [
        ViscousFriction("j", side="link", coefficient=b_v),
        CoulombFriction("j", side="link", level=b_d),
        StribeckFriction("j", side="link", excess=more, velocity=epsilon),
    ]
    total = sum(float(part.torque(0.0, u)) for part in parts)
    assert total == pytest.approx(laws.paper_friction(u, b_v, b_d + more, b_d, epsilon), rel=1e-9)


def test_a_law_takes_whole_recordings() -> None:
    """Arguments broadcast; the result has their shape."""
    effect = TorqueSpeedLimit("j", stall_torque=1.0, no_load_speed=2.0)
    out = effect.torque(np.zeros((3, 1)), np.linspace(-4, 4, 5), tau=5.0)
    assert out.shape == (3, 5)
    np.testing.assert_array_equal(out[0], [1.0 * 3.0, 2.0, 1.0, 0.0, 0.0])


def test_effects_are_frozen() -> None:
    """An effect is a value: it hashes and does not change."""
    effect = TorqueOffset("j", offset=1)
    assert {effect, TorqueOffset("j", side="motor", offset=1.0)} == {effect}
    with pytest.raises(AttributeError):
        effect.offset = 2.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"effect": "coulomb_fricton", "joint": "j"}, "effect: no such effect, got 'coulomb_fricton'; did you mean"),
        ({"effect": ["payload"]}, "effect: no such effect"),
        ({"joint": "j"}, "effect: its name is missing; write effect: NAME"),
        ("payload", "an effect is a mapping, got 'payload'"),
        ({"effect": "payload", "mas": 1}, "mas: payload has no such parameter; did you mean 'mass'?"),
        ({"effect": "payload"}, "mass: payload needs it; give it in kg"),
        ({"effect": "payload", "mass": -1}, "payload.mass: it must be at least 0 [kg], got -1.0"),
        ({"effect": "payload", "mass": math.nan}, "payload.mass: a number is needed"),
        ({"effect": "payload", "mass": math.inf}, "payload.mass: it must be finite"),
        ({"effect": "payload", "mass": "1 kg"}, "payload.mass: a number is needed, got '1 kg'; give it in kg"),
        ({"effect": "payload", "mass": True}, "payload.mass: a number is needed"),
        ({"effect": "payload", "mass": 10**400}, "payload.mass: it must be finite"),
        ({"effect": "torque_offset", "offset": 1.0}, "joint: torque_offset needs it; name it"),
        ({"effect": "torque_offset", "joint": 3, "offset": 1.0}, "torque_offset.joint: a joint's name is needed"),
        ({"effect": "torque_offset", "joint": "", "offset": 1.0}, "torque_offset.joint: a joint's name is needed"),
        (
            {"effect": "coulomb_friction", "joint": "j", "level": 1},
            "coulomb_friction.side: the side must be said; it is link or motor",
        ),
        (
            {"effect": "coulomb_friction", "joint": "j", "side": "rotor", "level": 1},
            "coulomb_friction.side: no such side for this effect, got 'rotor'; it is link or motor",
        ),
        (
            {"effect": "torque_speed_limit", "joint": "j", "stall_torque": 1, "no_load_speed": 0},
            "torque_speed_limit.no_load_speed: it must be above 0 [rad/s]",
        ),
        (
            {"effect": "torque_speed_limit", "joint": "j", "stall_torque": -math.inf, "no_load_speed": 1},
            "torque_speed_limit.stall_torque: it must be finite",
        ),
    ],
)
def test_a_mistake_in_an_effect_is_one_line(entry: Any, words: str) -> None:
    """It names the parameter and the remedy."""
    with pytest.raises(fd.InputError) as caught:
        effect_from_dict(entry)
    assert str(caught.value).startswith(words)


def test_units_on_a_prismatic_joint() -> None:
    """N m reads N and rad reads m."""
    assert [unit_for(unit, prismatic=True) for unit in ("N m s/rad", "N m", "rad/s", "kg")] == [
        "N s/m",
        "N",
        "m/s",
        "kg",
    ]
    assert unit_for("N m", prismatic=False) == "N m"


def test_units_of_waves_on_a_prismatic_joint(tmp_path: Path) -> None:
    """A phase is an angle of a cycle on every joint; a harmonic is cycles in 2 pi m, in the unit of the gear ratio."""
    wave: dict[str, Any] = {"harmonic": 3.0, "phase": 0.5}
    effects = [
        fd.effects.KinematicError("lift", amplitude=1e-3, **wave),
        fd.effects.TorqueRipple("lift", amplitude=1.0, **wave),
        fd.effects.PositionDependentFriction("lift", side="link", amplitude=1.0, **wave),
        fd.effects.EncoderEccentricity("q.lift", amplitude=1e-3, **wave),
    ]
    model = fd.FlexibleJointModel(slider(tmp_path), {"lift": {"rotor_inertia": 1.0, "stiffness": 1e5}}, effects)
    found = [units_of(model.robot, effect) for effect in effects]
    assert [units.pop("amplitude") for units in found] == ["m", "N", "N", "m"]
    assert found == [{"harmonic": "rad/m", "phase": "rad"}] * 4
    assert [effect.units(prismatic=False)["harmonic"] for effect in effects] == ["1"] * 4
    reported = numbers_of(model, effects[0], None)
    assert {name: number.unit for name, number in reported.items()} == units_of(model.robot, effects[0])
    numbers = {"gear_ratio": "rad/m", "rotor_inertia": "kg m^2", "stiffness": "N/m", "damping": "N s/m"}
    assert {name: number_as_given(model, "lift", name)[1] for name in numbers} == numbers | {"damping": "1"}
    varied = places(model, None)
    assert {name: varied[f"joints.lift.{name}"].unit for name in numbers} == numbers
    assert varied["effects[1].phase"].unit == "rad"
    assert varied["effects[3].amplitude"].unit == "m"
    shown = shown_effect(model, effects[3], "")["parameters"]
    assert shown["amplitude"] == {"value": 1e-3, "unit": "m"}
    assert shown["phase"] == {"value": 0.5, "unit": "rad"}


@unlisted
class UserSquareDrag(JointEffect):
    """Drag with the square of the speed, as a user writes it."""

    sides = ("link", "motor")
    stage = "friction"
    neutral = {"coefficient": 0.0}  # noqa: RUF012

    coefficient: float = parameter("N m s^2/rad^2", lower=0.0)

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Coefficient u |u|."""
        return self.coefficient * np.asarray(u) * np.abs(u)


def test_a_users_effect_stands_in_the_catalogue(monkeypatch: pytest.MonkeyPatch) -> None:
    """It reads from a model file by its name in snake_case, checks its bounds and takes recordings."""
    monkeypatch.setitem(base._registry, "user_square_drag", UserSquareDrag)
    entry = {"effect": "user_square_drag", "joint": "elbow", "side": "link", "coefficient": 2}
    effect = effect_from_dict(entry)
    assert isinstance(effect, UserSquareDrag)
    assert effect.is_python
    assert effect.to_dict() == entry
    np.testing.assert_array_equal(effect.torque(0.0, [-1.0, 2.0]), [-2.0, 8.0])
    with pytest.raises(fd.InputError, match=r"user_square_drag\.coefficient: it must be at least 0"):
        UserSquareDrag("elbow", side="link", coefficient=-1.0)


def test_two_effects_of_one_name_are_refused() -> None:
    """A name of the catalogue cannot be taken by somebody else's class."""
    with pytest.raises(TypeError, match="an effect named payload exists already"):
        type("Payload", (Payload,), {"__doc__": "Another.", "__module__": __name__})
