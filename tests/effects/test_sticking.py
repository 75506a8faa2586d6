"""Exact sticking: every dry law on one joint against an event-driven integration written for it."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import (
    AsymmetricFriction,
    CoulombFriction,
    DirectionalGearLoss,
    Effect,
    LoadDependentFriction,
    PositionDependentFriction,
    StribeckFriction,
    TorqueRipple,
    TransmissionDamping,
    ViscousFriction,
    effect_from_dict,
)
from tests.effects.arms import model_of, states
from tests.effects.dry_reference import Contact, integrate
from tests.effects.reference import Arm, level

Array = NDArray[np.float64]
TIMES = np.linspace(0.0, 9.0, 181)
START = -1.1
"""First position, near the lowest point [rad]."""
SOLVER = fd.solvers.DormandPrince(rtol=1e-11, atol=1e-13)
ELASTIC = Arm((40.0,), (0.2,), (0.5,), gravity=9.81)
RIGID = Arm((math.inf,), (0.0,), (0.5,), gravity=9.81)
ON_LINK: list[tuple[str, list[Effect]]] = [
    ("coulomb", [CoulombFriction("shoulder", side="link", level=0.5)]),
    ("asymmetric", [AsymmetricFriction("shoulder", side="link", level_positive=0.7, level_negative=0.3)]),
    (
        "stribeck",
        [
            CoulombFriction("shoulder", side="link", level=0.4),
            StribeckFriction("shoulder", side="link", excess=0.3, velocity=0.1),
        ],
    ),
    (
        "stribeck_squared",
        [
            StribeckFriction("shoulder", side="link", excess=0.8, velocity=0.3, exponent=2.0),
            ViscousFriction("shoulder", side="link", coefficient=0.2),
            CoulombFriction("shoulder", side="link", level=0.3),
        ],
    ),
    (
        "position_dependent",
        [PositionDependentFriction("shoulder", side="link", amplitude=0.6, harmonic=4.0, phase=0.3)],
    ),
]
MOTOR_ONLY: list[tuple[str, list[Effect]]] = [
    ("directional_gear", [DirectionalGearLoss("shoulder", driving=0.05, driven=0.2)]),
    ("directional_gear_other_way", [DirectionalGearLoss("shoulder", driving=0.3, driven=0.1)]),
    (
        "directional_gear_and_coulomb",
        [
            DirectionalGearLoss("shoulder", driving=0.05, driven=0.2),
            TransmissionDamping("shoulder", coefficient=0.3),
            CoulombFriction("shoulder", side="motor", level=0.1),
        ],
    ),
    ("load_dependent", [LoadDependentFriction("shoulder", coefficient=0.1)]),
    (
        "load_dependent_and_coulomb",
        [
            LoadDependentFriction("shoulder", coefficient=0.1),
            TransmissionDamping("shoulder", coefficient=0.3),
            CoulombFriction("shoulder", side="motor", level=0.2),
        ],
    ),
]


def to_motor(effects: list[Effect]) -> list[Effect]:
    """The same friction on the rotor."""
    return [effect_from_dict(effect.to_dict() | {"side": "motor"}) for effect in effects]


def contact_of(arm: Arm, side: str, tau: float) -> Contact:
    """The arm's one contact; its dry laws are taken off the smoothed equations and put back as a set."""
    dry = [e for e in arm.effects if e.stage == "dry"]
    bare = dataclasses.replace(arm, effects=tuple(e for e in arm.effects if e not in dry))
    elastic = bool(arm.elastic)
    place = 3 if elastic and side == "motor" else 2 if elastic else 1
    inertia = arm.rotor[0] if place == 3 else float(arm.mass_matrix([0.0])[0, 0])

    def free(t: float, x: Any, friction: float) -> Array:
        dx = np.array(bare.derivative(t, x, [tau]))
        dx[place] -= friction / inertia
        return dx

    def interval(t: float, x: Any, direction: float) -> float:
        half = len(x) // 2
        tau_s = bare.spring(0, (x[0], x[1], x[2], x[3]), []).link if elastic else 0.0
        position = x[1] if place == 3 else x[0]
        return sum(level(e, position, x[place], tau_s, direction) for e in dry) if half else 0.0

    def load(t: float, x: Any) -> float:
        return bare.spring(0, (x[0], x[1], x[2], x[3]), []).link

    return Contact(free, place, inertia, interval, load if any(e.takes_load for e in dry) else None)


def compare(arm: Arm, side: str, effects: list[Effect], tau: float) -> tuple[fd.Run, list[float]]:
    """Run both from rest with the link near its lowest point, and hold every state together."""
    arm = dataclasses.replace(arm, effects=tuple(effects))
    run = fd.simulate(model_of(arm), [tau], TIMES[-1], SOLVER, times=TIMES, q0=[START])
    x0 = [START, START, 0.0, 0.0] if arm.elastic else [START, 0.0]
    expected, events = integrate(contact_of(arm, side, tau), x0, TIMES)
    np.testing.assert_allclose(states(run), expected, atol=2e-8)
    return run, events


@pytest.mark.parametrize(("name", "effects"), ON_LINK, ids=[name for name, _ in ON_LINK])
def test_link_friction_on_a_rigid_joint(name: str, effects: list[Effect]) -> None:
    """A heavy pendulum swings out and stops for good, to the last bit."""
    run, events = compare(RIGID, "link", effects, 0.2)
    assert run.stats["events"] == len(events) >= 3
    held = run.t > events[-1]
    assert (run.v[held] == 0.0).all()
    assert (run.q[held] == run.q[-1]).all()


@pytest.mark.parametrize(("name", "effects"), ON_LINK, ids=[name for name, _ in ON_LINK])
def test_motor_friction_on_a_rigid_joint(name: str, effects: list[Effect]) -> None:
    """Through a rigid gear friction on the rotor is friction on the link."""
    one, two = (
        fd.simulate(model_of(RIGID, each), [0.2], TIMES[-1], SOLVER, times=TIMES, q0=[START])
        for each in (effects, to_motor(effects))
    )
    np.testing.assert_allclose(states(one), states(two), atol=1e-12)


@pytest.mark.parametrize(("name", "effects"), ON_LINK, ids=[name for name, _ in ON_LINK])
def test_link_friction_on_an_elastic_joint(name: str, effects: list[Effect]) -> None:
    """The link sticks and breaks away while the rotor swings on its spring."""
    run, events = compare(ELASTIC, "link", effects, 0.2)
    assert run.stats["events"] == len(events) >= 5


@pytest.mark.parametrize(
    ("name", "effects"),
    [*((name, to_motor(effects)) for name, effects in ON_LINK), *MOTOR_ONLY],
    ids=[name for name, _ in ON_LINK + MOTOR_ONLY],
)
def test_motor_friction_on_an_elastic_joint(name: str, effects: list[Effect]) -> None:
    """The rotor sticks and breaks away while the link swings on its spring; the load's changes of sign are located."""
    run, events = compare(ELASTIC, "motor", effects, 0.2)
    assert run.stats["events"] == len(events) >= 5


def test_ripple_holds_and_lets_go() -> None:
    """Torque that swings with the rotor's angle and dry friction on it: two laws of one side at once."""
    effects: list[Any] = [
        CoulombFriction("shoulder", side="motor", level=0.6),
        TorqueRipple("shoulder", amplitude=1.5, harmonic=9.0, phase=0.2),
    ]
    compare(ELASTIC, "motor", effects, 0.4)


@pytest.mark.parametrize("side", ["link", "motor"])
def test_an_asymmetric_joint_holds_more_one_way(side: Any) -> None:
    """Torques within [-level_negative, level_positive] hold to the last bit; a little more on either side moves."""
    friction = AsymmetricFriction("shoulder", side=side, level_positive=0.7, level_negative=0.3)
    weightless = dataclasses.replace(ELASTIC, gravity=0.0)
    model = model_of(weightless, [friction])
    for tau, moves in ((0.7 * (1 - 1e-6), 0), (0.7 * (1 + 1e-6), 1), (-0.3 * (1 - 1e-6), 0), (-0.3 * (1 + 1e-6), -1)):
        start: dict[str, Any] = {"theta0": [tau / 40.0]} if side == "link" else {}
        run = fd.simulate(model, [tau], 5.0, SOLVER, rate=20, **start)
        u, x = (run.v, run.q) if side == "link" else (run.omega, run.theta)
        if moves == 0:
            assert (u == 0.0).all()
            assert (x == x[0]).all()
        else:
            assert (np.sign(x[-1] - x[0]) == moves).all()
