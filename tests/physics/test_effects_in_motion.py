"""Effects act in a trajectory as their formulas say: laws written a second time, integrated by SciPy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import (
    CoulombFriction,
    Effect,
    Payload,
    StribeckFriction,
    TorqueOffset,
    TorqueSpeedLimit,
    TransmissionDamping,
    ViscousFriction,
)
from tests.arms import BENT, state, two_link
from tests.oracles import laws
from tests.oracles.integrate import trajectory
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
NAMES = ("shoulder", "elbow")
START = [0.0, math.pi / 2, 0.0, math.pi / 2, 0.4, -0.3, 0.4, -0.3]
STOPS = np.linspace(0.0, 5.0, 21)
EPS = 0.05
SOLVER = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13, smoothing=EPS)
PLAIN: dict[str, Any] = {"stiffness": (30.0, 20.0), "damping": (0.1, 0.05)}


def both(kind: type[Effect], **numbers: Any) -> list[Effect]:
    """The effect on both joints."""
    return [kind(joint=joint, **numbers) for joint in NAMES]  # type: ignore[call-arg]


CASES: dict[str, tuple[list[Effect], dict[str, Any]]] = {
    "link_viscous": (
        both(ViscousFriction, side="link", coefficient=0.3),
        {"link_friction": lambda _, u: laws.viscous(u, 0.3)},
    ),
    "motor_viscous": (
        both(ViscousFriction, side="motor", coefficient=0.3),
        {"motor_friction": lambda _, u: laws.viscous(u, 0.3)},
    ),
    "transmission_damping": (
        [TransmissionDamping("shoulder", coefficient=0.7), TransmissionDamping("shoulder", coefficient=0.2)],
        {"damping": (1.0, 0.05)},
    ),
    "coulomb": (
        both(CoulombFriction, side="link", level=0.2),
        {"link_friction": lambda _, u: laws.coulomb(u, 0.2, EPS)},
    ),
    "stribeck": (
        [
            *both(StribeckFriction, side="motor", excess=0.2, velocity=0.1),
            *both(CoulombFriction, side="motor", level=0.1),
        ],
        {"motor_friction": lambda _, u: laws.stribeck(u, 0.2, 0.1, 1.0, EPS) + laws.coulomb(u, 0.1, EPS)},
    ),
    "stribeck_squared": (
        both(StribeckFriction, side="link", excess=0.2, velocity=0.3, exponent=2.0),
        {"link_friction": lambda _, u: laws.stribeck(u, 0.2, 0.3, 2.0, EPS)},
    ),
    "torque_offset": (
        [TorqueOffset("elbow", offset=0.15), TorqueOffset("elbow", offset=-0.05)],
        {"actuator": lambda j, tau, _: tau + 0.1 * j},
    ),
    "torque_speed_limit": (
        both(TorqueSpeedLimit, stall_torque=0.5, no_load_speed=1.0),
        {"actuator": lambda _, tau, omega: laws.torque_speed_limit(tau, omega, 0.5, 1.0)},
    ),
    "offset_before_limit": (
        [TorqueSpeedLimit("shoulder", stall_torque=0.5, no_load_speed=1.0), TorqueOffset("shoulder", offset=0.3)],
        {"actuator": lambda j, tau, omega: tau if j else laws.torque_speed_limit(tau + 0.3, omega, 0.5, 1.0)},
    ),
    "payload": ([Payload(mass=0.4)], {"tip_mass": 0.5}),
}


@pytest.mark.parametrize("case", CASES)
def test_law_in_a_trajectory(case: str) -> None:
    """1e-8 rad over 5 s, under a torque that swings the arm through both directions of motion."""
    effects, changes = CASES[case]
    arm = TwoLink(**(PLAIN | changes))
    model = two_link(TwoLink(**PLAIN), effects)
    t = np.linspace(0.0, 5.0, 401)
    swing = np.column_stack([0.8 * np.sin(2.5 * t), 0.5 * np.cos(4.0 * t)])
    run = fd.simulate(model, fd.Samples(t, swing, "cubic"), 5.0, SOLVER, times=STOPS, **BENT)
    spline = _spline(t, swing)

    def f(time: float, x: Sequence[float]) -> list[float]:
        return arm.derivative(x, spline(time))

    assert np.abs(state(run) - trajectory(f, START, STOPS)).max() < 1e-8


@pytest.mark.parametrize("side", ["link", "motor"])
def test_friction_on_a_rigid_joint(side: Any) -> None:
    """A rigid joint has friction of both sides, at one velocity."""
    arm = TwoLink(stiffness=(math.inf, math.inf), link_friction=lambda _, u: 0.3 * u + laws.coulomb(u, 0.2, EPS))
    effects = [*both(ViscousFriction, side=side, coefficient=0.3), *both(CoulombFriction, side=side, level=0.2)]
    run = fd.simulate(two_link(arm, effects), [0.7, 0.4], 5.0, SOLVER, times=STOPS, **BENT)
    expected = trajectory(lambda _, x: arm.derivative(x, [0.7, 0.4]), [*START[0:2], *START[4:6]], STOPS)
    assert np.abs(state(run) - expected).max() < 1e-8


def test_frictions_of_one_kind_add_up() -> None:
    """Two viscous and two Coulomb frictions act as one of their sum, on either side of the gear."""
    for side in ("link", "motor"):
        kinds: list[tuple[Any, str]] = [(ViscousFriction, "coefficient"), (CoulombFriction, "level")]
        one = [kind("elbow", side=side, **{key: 0.3}) for kind, key in kinds]
        two = [kind("elbow", side=side, **{key: part}) for kind, key in kinds for part in (0.1, 0.2)]
        runs = [fd.simulate(two_link(TwoLink(**PLAIN), each), [0.5, 0.5], 1.0, SOLVER, **BENT) for each in (one, two)]
        assert np.abs(state(runs[0]) - state(runs[1])).max() < 1e-11


def test_friction_never_feeds_the_arm() -> None:
    """With friction and dampers alone the mechanical energy falls and falls."""
    effects = [
        *both(ViscousFriction, side="link", coefficient=0.02),
        *both(StribeckFriction, side="motor", excess=0.02, velocity=0.1),
        *both(CoulombFriction, side="link", level=0.02),
    ]
    run = fd.simulate(two_link(TwoLink(**PLAIN, gravity=9.81), effects), None, 5.0, SOLVER, **BENT)
    energy = run.energy.mechanical
    assert (np.diff(energy) < 1e-10).all()
    assert energy[-1] < energy[0] - 0.5


def _spline(t: Array, values: Array) -> Any:
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, values)
    return lambda time: spline(time).tolist()
