"""The catalogue is the contract's table: names, sides, parameters, units, defaults, bounds; and it reads and writes."""

from __future__ import annotations

import dataclasses
import math
import pickle
from pathlib import Path
from typing import Any

import pytest

import flexdyn as fd
from flexdyn import _core
from flexdyn.effects import Effect, JointEffect, SensorEffect, catalogue, effect_from_dict
from flexdyn.effects.coupling import CouplingDrag, CouplingFriction
from flexdyn.effects.motor import MotorTorque, MotorWinding, SupplyLimit
from tests.effects.arms import ELASTIC, RIGID, catalogue_examples, model_of, own

BOTH, MOTOR, LINK, GEAR, SENSOR = ("link", "motor"), ("motor",), ("link",), ("transmission",), ("sensor",)
LEVEL, VISCOUS, ANGLE, ONE = "N m", "N m s/rad", "rad", "1"
TABLE: list[tuple[str, tuple[str, ...], dict[str, str]]] = [
    ("viscous_friction", BOTH, {"coefficient": VISCOUS}),
    ("coulomb_friction", BOTH, {"level": LEVEL}),
    ("asymmetric_friction", BOTH, {"level_positive": LEVEL, "level_negative": LEVEL}),
    ("stribeck_friction", BOTH, {"excess": LEVEL, "velocity": "rad/s", "exponent": ONE}),
    ("asymmetric_viscous_friction", BOTH, {"coefficient_positive": VISCOUS, "coefficient_negative": VISCOUS}),
    ("quadratic_drag", BOTH, {"coefficient": "N m s^2/rad^2"}),
    ("load_dependent_friction", MOTOR, {"coefficient": ONE}),
    ("directional_gear_loss", MOTOR, {"driving": ONE, "driven": ONE}),
    ("stribeck_gear_loss", MOTOR, {"driving": ONE, "driven": ONE, "velocity": "rad/s"}),
    ("position_dependent_friction", BOTH, {"amplitude": LEVEL, "harmonic": ONE, "phase": ANGLE}),
    ("presliding_friction", BOTH, {"level": LEVEL, "stiffness": "N m/rad", "damping": VISCOUS}),
    ("warm_up_friction", BOTH, {"coefficient": VISCOUS, "time_constant": "s"}),
    ("joint_elasticity", GEAR, {"stiffness": "N m/rad"}),
    ("transmission_damping", GEAR, {"coefficient": VISCOUS}),
    ("hardening_spring", GEAR, {"cubic": "N m/rad^3"}),
    ("backlash", GEAR, {"half_gap": ANGLE}),
    ("spring_hysteresis", GEAR, {"stiffness": "N m/rad", "width": ANGLE}),
    ("kinematic_error", GEAR, {"amplitude": ANGLE, "harmonic": ONE, "phase": ANGLE}),
    ("torque_offset", MOTOR, {"offset": LEVEL}),
    ("torque_constant_error", MOTOR, {"gain": ONE}),
    ("torque_ripple", MOTOR, {"amplitude": LEVEL, "harmonic": ONE, "phase": ANGLE}),
    ("torque_speed_limit", MOTOR, {"stall_torque": LEVEL, "no_load_speed": "rad/s"}),
    ("torque_saturation", MOTOR, {"scale": LEVEL}),
    ("command_delay", MOTOR, {"delay": "s"}),
    ("payload", (), {"mass": "kg"}),
    ("parallel_spring", LINK, {"stiffness": "N m/rad", "rest": ANGLE}),
    ("position_torque", LINK, {"cos_1": LEVEL, "sin_1": LEVEL, "cos_2": LEVEL, "sin_2": LEVEL}),
    ("end_stop", LINK, {"lower": ANGLE, "upper": ANGLE, "stiffness": "N m/rad", "damping": VISCOUS}),
    ("joint_coupling", MOTOR, {"coefficient": VISCOUS, "level": LEVEL, "ratio": ONE}),
    ("parameter_error", (), {"factor": ONE}),
    ("channel_lag", SENSOR, {"delay": "s"}),
    ("encoder_eccentricity", SENSOR, {"amplitude": ANGLE, "harmonic": ONE, "phase": ANGLE}),
    ("sensor_offset", SENSOR, {"offset": "unit of the channel"}),
    ("sensor_gain", SENSOR, {"gain": ONE}),
]
DEFAULTS = {
    ("stribeck_friction", "exponent"): 1.0,
    ("presliding_friction", "damping"): 0.0,
    ("joint_coupling", "coefficient"): 0.0,
    ("joint_coupling", "level"): 0.0,
    ("joint_coupling", "ratio"): 1.0,
    ("encoder_eccentricity", "harmonic"): 1.0,
}
AT_LEAST_ZERO = [
    "viscous_friction.coefficient",
    "coulomb_friction.level",
    "asymmetric_friction.level_positive",
    "asymmetric_friction.level_negative",
    "stribeck_friction.excess",
    "quadratic_drag.coefficient",
    "load_dependent_friction.coefficient",
    "directional_gear_loss.driving",
    "directional_gear_loss.driven",
    "stribeck_gear_loss.driving",
    "stribeck_gear_loss.driven",
    "position_dependent_friction.amplitude",
    "presliding_friction.level",
    "presliding_friction.damping",
    "warm_up_friction.coefficient",
    "transmission_damping.coefficient",
    "hardening_spring.cubic",
    "backlash.half_gap",
    "spring_hysteresis.stiffness",
    "torque_speed_limit.stall_torque",
    "command_delay.delay",
    "payload.mass",
    "parallel_spring.stiffness",
    "end_stop.stiffness",
    "end_stop.damping",
    "channel_lag.delay",
]
ABOVE_ZERO = [
    "stribeck_friction.velocity",
    "stribeck_friction.exponent",
    "presliding_friction.stiffness",
    "warm_up_friction.time_constant",
    "joint_elasticity.stiffness",
    "spring_hysteresis.width",
    "torque_speed_limit.no_load_speed",
    "torque_saturation.scale",
    "parameter_error.factor",
]
EXAMPLES = catalogue_examples()


def changed(effect: Any, **numbers: float) -> Any:
    """The effect with other numbers."""
    return dataclasses.replace(effect, **numbers)


def neutral_form(effect: Effect) -> Any:
    """The effect with its neutral values."""
    return changed(effect, **effect.neutral)


def test_the_order_is_that_of_the_table() -> None:
    """Flexdyn's own effects, from the motor's friction to the sensors."""
    assert [name for name, kind in catalogue().items() if own(kind)] == [name for name, *_ in TABLE]


@pytest.mark.parametrize(("name", "sides", "units"), TABLE, ids=[row[0] for row in TABLE])
def test_sides_parameters_and_units(name: str, sides: tuple[str, ...], units: dict[str, str]) -> None:
    """As the table has them, in its order, each with its default."""
    kind = catalogue()[name]
    assert kind.sides == sides
    found = {field.name: field for field in kind.parameters()}
    assert {key: field.metadata["unit"] for key, field in found.items()} == units
    assert list(found) == list(units)
    for key, field in found.items():
        assert field.default == DEFAULTS.get((name, key), dataclasses.MISSING)
    assert kind.summary().endswith(".")
    assert kind.law


def test_the_core_has_the_laws_with_these_parameters() -> None:
    """Every law of the core has one class, with its stage, traits and number of parameters; not vice versa."""
    table = {row.name: row for row in _core.law_table()}
    other_laws: tuple[type[Effect], ...] = (CouplingDrag, CouplingFriction, SupplyLimit, MotorTorque, MotorWinding)
    kinds = {kind.name: kind for kind in (*catalogue().values(), *other_laws)}
    assert set(table) <= set(kinds)
    for name, row in table.items():
        kind = kinds[name]
        of_table = (row.stage, row.has_state, row.of_load, row.conservative, row.parameters)
        found = (kind.stage, kind.has_state, kind.takes_load, kind.conservative, len(kind.parameters()))
        assert found == of_table, name
    lawless = {kind.name: kind.stage for kind in catalogue().values() if kind.name not in table}
    assert lawless.pop("joint_elasticity") == "spring"
    assert set(lawless.values()) == {"inertia", "model", "sensor"}


@pytest.mark.parametrize("path", AT_LEAST_ZERO + ABOVE_ZERO)
def test_lower_bounds(path: str) -> None:
    """Levels and coefficients of friction are not negative, widths and speeds are above 0."""
    name, key = path.split(".")
    (effect,) = [example for example in EXAMPLES if example.name == name]
    with pytest.raises(fd.InputError, match=rf"{name}\.{key}: it must be (at least|above) 0"):
        changed(effect, **{key: -1e-9})
    if path in AT_LEAST_ZERO:
        assert getattr(changed(effect, **{key: 0.0}), key) == 0.0
    else:
        with pytest.raises(fd.InputError, match=rf"{name}\.{key}: it must be above 0"):
            changed(effect, **{key: 0.0})


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.name)
def test_numbers_without_sense(effect: Effect) -> None:
    """NaN nowhere; infinity only where it means "none"."""
    may_be = {
        "joint_elasticity": {"stiffness"},
        "torque_speed_limit": {"stall_torque"},
        "torque_saturation": {"scale"},
        "end_stop": {"lower", "upper"},
    }
    for field in effect.parameters():
        with pytest.raises(fd.InputError, match=rf"{effect.name}\.{field.name}: a number is needed"):
            changed(effect, **{field.name: math.nan})
        value = -math.inf if field.name == "lower" else math.inf
        if field.name in may_be.get(effect.name, set()):
            assert getattr(changed(effect, **{field.name: value}), field.name) == value
        else:
            with pytest.raises(fd.InputError, match=rf"{effect.name}\.{field.name}: it must be finite"):
                changed(effect, **{field.name: value})


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.name)
def test_an_effect_is_a_value(effect: Effect) -> None:
    """It reads back from its entry, pickles, hashes; its example does something, its neutral form nothing."""
    assert effect_from_dict(effect.to_dict()) == effect
    assert pickle.loads(pickle.dumps(effect)) == effect  # noqa: S301 - our own bytes
    assert not effect.is_neutral
    neutral = neutral_form(effect)
    assert neutral.is_neutral
    assert effect_from_dict(neutral.to_dict()) == neutral


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.name)
def test_a_model_file_keeps_it(effect: Effect, tmp_path: Path) -> None:
    """Written and read back without loss, alone and beside its neutral form."""
    arm = RIGID if effect.name == "joint_elasticity" else ELASTIC
    model = model_of(arm, [effect, neutral_form(effect)])
    fd.save_model(model, tmp_path / "model.yaml")
    assert fd.load_model(tmp_path / "model.yaml").effects == model.effects


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.name)
def test_a_side_is_checked(effect: Effect) -> None:
    """It may be left out where there is one only; another one is refused; a payload has neither joint nor side."""
    entry = effect.to_dict()
    if not isinstance(effect, JointEffect | SensorEffect):
        assert "side" not in entry
        return
    with pytest.raises(fd.InputError, match=rf"{effect.name}\.side: no such side for this effect, got 'rotor'"):
        effect_from_dict(entry | {"side": "rotor"})
    del entry["side"]
    if len(effect.sides) == 1:
        assert effect_from_dict(entry) == effect
    else:
        with pytest.raises(fd.InputError, match=rf"{effect.name}\.side: the side must be said; it is link or motor"):
            effect_from_dict(entry)


def test_stops_leave_room() -> None:
    """Lower is at most upper; one side may be without a stop."""
    stop: dict[str, Any] = {"joint": "shoulder", "stiffness": 10.0, "damping": 0.0}
    with pytest.raises(fd.InputError, match=r"end_stop\.lower: the stops leave no room, got 1.0; it must be at most"):
        fd.effects.EndStop(lower=1.0, upper=0.5, **stop)
    assert fd.effects.EndStop(lower=0.5, upper=0.5, **stop).lower == 0.5
    one_sided = fd.effects.EndStop(lower=-math.inf, upper=0.5, **stop)
    assert effect_from_dict(one_sided.to_dict()) == one_sided
    assert one_sided.torque(-1e6, -3.0) == 0.0
