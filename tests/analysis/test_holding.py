"""Torques that friction holds, against exact sticking: just inside nothing moves by one bit, just outside it does."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from tests.analysis.arms import SPRING, WEIGHT, two_mass
from tests.arms import EXACT, two_link
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
MOTOR = {"effect": "asymmetric_friction", "side": "motor", "level_positive": 3.0, "level_negative": 2.0}
LINK = {"effect": "coulomb_friction", "side": "link", "level": 1.5}
STATIC = {"effect": "stribeck_friction", "side": "motor", "excess": 0.4, "velocity": 0.02, "exponent": 0.5}
Q = 0.3


def drift(model: fd.FlexibleJointModel, tau: float, theta: float) -> float:
    """How far link and rotor get in 2 s from rest [m]."""
    run = fd.simulate(model, [tau], 2.0, EXACT, q0=[Q], theta0=[theta], rate=50)
    return float(max(np.ptp(run.q), np.ptp(run.theta)))


def test_levels_add_up_on_both_sides(tmp_path: Path) -> None:
    """W - L_link - L_motor to W + L_link + L_motor, each level in its direction."""
    lower, upper = fd.holding_torques(two_mass(tmp_path, [MOTOR, LINK, STATIC]), [Q])
    assert lower == pytest.approx([WEIGHT - 1.5 - 2.4], rel=1e-11)
    assert upper == pytest.approx([WEIGHT + 1.5 + 3.4], rel=1e-11)


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("effects", [[MOTOR], [MOTOR, STATIC], [MOTOR, LINK]])
def test_the_motor_breaks_away_at_the_bound(tmp_path: Path, effects: list[dict[str, Any]], side: str) -> None:
    """With its spring loaded by gravity: L (1 - 1e-6) holds to the last bit, L (1 + 1e-6) does not."""
    model = two_mass(tmp_path, effects)
    theta = Q + WEIGHT / SPRING
    bound = getattr(fd.holding_torques(model, [Q], [theta]), side)[0]
    level = bound - WEIGHT
    assert drift(model, WEIGHT + level * (1.0 - 1e-6), theta) == 0.0
    assert drift(model, WEIGHT + level * (1.0 + 1e-6), theta) > 0.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_link_and_motor_hold_together(tmp_path: Path, side: float) -> None:
    """With the rotor where link friction just holds the spring, the whole interval is needed and no more of it."""
    model = two_mass(tmp_path, [MOTOR, LINK])
    lower, upper = fd.holding_torques(model, [Q])
    motor = 3.0 if side > 0 else 2.0
    inside = 1.0 - 1e-6
    theta = Q + (WEIGHT + side * 1.5 * inside) / SPRING
    bound = (upper if side > 0 else lower)[0]
    assert bound == pytest.approx(WEIGHT + side * (1.5 + motor), rel=1e-11)
    assert drift(model, WEIGHT + side * (1.5 + motor) * inside, theta) == 0.0
    assert drift(model, WEIGHT + side * (1.5 + motor) * (1.0 + 1e-6), theta) > 0.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rigid_joint_adds_its_levels(tmp_path: Path, side: float) -> None:
    """Without a spring link and motor friction are one contact."""
    model = two_mass(tmp_path, [MOTOR, LINK], stiffness=math.inf, damping=0.0)
    lower, upper = fd.holding_torques(model, [Q])
    level = (upper if side > 0 else lower)[0] - WEIGHT
    assert level == pytest.approx(side * 1.5 + (3.0 if side > 0 else -2.0), rel=1e-11)
    assert drift(model, WEIGHT + level * (1.0 - 1e-6), Q) == 0.0
    assert drift(model, WEIGHT + level * (1.0 + 1e-6), Q) > 0.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_load_dependent_friction_takes_the_load(tmp_path: Path, side: float) -> None:
    """The level is coefficient abs(tau_s): a gear that carries its link holds by more than one that does not."""
    model = two_mass(tmp_path, [{"effect": "load_dependent_friction", "coefficient": 0.2}, LINK])
    lower, upper = fd.holding_torques(model, [Q])
    assert upper == pytest.approx([1.2 * (WEIGHT + 1.5)], rel=1e-9)
    assert lower == pytest.approx([0.8 * (WEIGHT - 1.5)], rel=1e-9)
    theta = Q + WEIGHT / SPRING
    loaded = fd.holding_torques(model, [Q], [theta])
    level = (loaded.upper if side > 0 else loaded.lower)[0] - WEIGHT
    assert level == pytest.approx(side * 0.2 * WEIGHT, rel=1e-9)
    assert drift(model, WEIGHT + level * (1.0 - 1e-6), theta) == 0.0
    assert drift(model, WEIGHT + level * (1.0 + 1e-6), theta) > 0.0


def test_friction_over_position_is_taken_where_each_side_stands(tmp_path: Path) -> None:
    """The link's level at q, the motor's at theta."""
    wave = {"effect": "position_dependent_friction", "amplitude": 1.0, "harmonic": 9.0, "phase": 0.0}
    theta = Q + WEIGHT / SPRING
    motor = fd.holding_torques(two_mass(tmp_path, [wave | {"side": "motor"}]), [Q])
    assert motor.upper == pytest.approx([WEIGHT + 1.0 + math.sin(9.0 * theta)], rel=1e-9)
    link = fd.holding_torques(two_mass(tmp_path, [wave | {"side": "link"}]), [Q])
    assert link.upper == pytest.approx([WEIGHT + 1.0 + math.sin(9.0 * Q)], rel=1e-9)


def test_actuator_effects_are_undone(tmp_path: Path) -> None:
    """The interval is of the torque asked for; past the motor's limit every torque holds."""
    error = [{"effect": "torque_constant_error", "gain": 0.25}, {"effect": "torque_offset", "offset": -1.0}]
    lower, upper = fd.holding_torques(two_mass(tmp_path, [MOTOR, *error]), [Q])
    assert 1.25 * lower[0] - 1.0 == pytest.approx(WEIGHT - 2.0)
    assert 1.25 * upper[0] - 1.0 == pytest.approx(WEIGHT + 3.0)
    weak = {"effect": "torque_speed_limit", "stall_torque": WEIGHT + 1.0, "no_load_speed": 3.0}
    lower, upper = fd.holding_torques(two_mass(tmp_path, [MOTOR, weak]), [Q])
    assert lower == pytest.approx([WEIGHT - 2.0])
    assert upper.tolist() == [math.inf]
    weaker = {"effect": "torque_speed_limit", "stall_torque": WEIGHT - 2.5, "no_load_speed": 3.0}
    with pytest.raises(fd.InputError, match=r"^q: the motor of lift is too weak to hold the pose"):
        fd.holding_torques(two_mass(tmp_path, [MOTOR, weaker]), [Q])


def test_joints_of_an_arm_are_apart() -> None:
    """Two links under gravity: the box of intervals holds at its corners, every joint at its bound at once."""
    arm = TwoLink(stiffness=(300.0, 200.0), rotor=(0.2, 0.1), gravity=9.81)
    levels = {"shoulder": 0.8, "elbow": 0.5}
    friction = [
        {"effect": "coulomb_friction", "joint": joint, "side": "motor", "level": level}
        for joint, level in levels.items()
    ]
    model = two_link(arm, friction)
    q = np.array([0.3, 0.8])
    lower, upper = fd.holding_torques(model, q)
    weight = np.array(arm.weight(*q))
    dry = np.array([0.8, 0.5])
    np.testing.assert_allclose(upper, weight + dry, rtol=1e-11)
    np.testing.assert_allclose(lower, weight - dry, rtol=1e-11)
    for corner in (lower, upper, [lower[0], upper[1]]):
        tau: Array = weight + (np.array(corner) - weight) * (1.0 - 1e-6)
        run = fd.simulate(model, tau, 1.0, EXACT, q0=q, theta0=q + weight / arm.stiffness, rate=20)
        assert np.ptp(run.theta, axis=0).tolist() == [0.0, 0.0]


def test_springs_that_link_friction_does_not_hold(tmp_path: Path) -> None:
    """Rotor positions at which the link itself would move are refused."""
    model = two_mass(tmp_path, [MOTOR, LINK])
    with pytest.raises(fd.InputError, match=r"^theta: the link of lift does not rest: the springs leave 4 N on it"):
        fd.holding_torques(model, [Q], [Q + (WEIGHT + 4.0) / SPRING])
