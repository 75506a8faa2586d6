"""In motion every law acts where the contract puts it: the two-link arm against SciPy, equations and laws anew."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import (
    AsymmetricFriction,
    AsymmetricViscousFriction,
    Backlash,
    CommandDelay,
    CoulombFriction,
    DirectionalGearLoss,
    Effect,
    EndStop,
    HardeningSpring,
    JointCoupling,
    KinematicError,
    LoadDependentFriction,
    ParallelSpring,
    PositionDependentFriction,
    PositionTorque,
    PreslidingFriction,
    QuadraticDrag,
    SpringHysteresis,
    StribeckFriction,
    StribeckGearLoss,
    TorqueConstantError,
    TorqueOffset,
    TorqueRipple,
    TorqueSaturation,
    TorqueSpeedLimit,
    TransmissionDamping,
    ViscousFriction,
    WarmUpFriction,
)
from tests.effects.arms import ELASTIC, RIGID, model_of, states
from tests.effects.reference import Arm, trajectory

TORQUE = [0.9, -0.5]
START: dict[str, Any] = {"q0": [-0.4, 0.7], "v0": [0.6, -0.5]}
TIMES = np.linspace(0.0, 1.5, 31)
SMOOTHED = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13, smoothing=0.05)
LOCATED = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13)
WAVE: dict[str, Any] = {"harmonic": 3.0, "phase": 0.4}
STIFF: dict[str, Any] = {"level": 0.4, "stiffness": 40.0, "damping": 0.2}

SMOOTH: dict[str, list[Effect]] = {
    "viscous": [ViscousFriction("elbow", side="motor", coefficient=0.4)],
    "warm_up": [WarmUpFriction("elbow", side="motor", coefficient=0.8, time_constant=0.7)],
    "warm_up_link": [WarmUpFriction("shoulder", side="link", coefficient=0.8, time_constant=0.7)],
    "transmission_damping": [TransmissionDamping("shoulder", coefficient=0.7)],
    "hardening": [HardeningSpring("shoulder", cubic=4e5), HardeningSpring("elbow", cubic=2e6)],
    "kinematic": [KinematicError("shoulder", amplitude=0.01, harmonic=12.0, phase=0.3)],
    "kinematic_twice": [
        KinematicError("elbow", amplitude=0.01, harmonic=12.0, phase=0.3),
        KinematicError("elbow", amplitude=-0.004, harmonic=5.0, phase=1.0),
        HardeningSpring("elbow", cubic=2e6),
    ],
    "torque_offset": [TorqueOffset("elbow", offset=0.3)],
    "gains_add": [TorqueConstantError("elbow", gain=0.3), TorqueConstantError("elbow", gain=-0.5)],
    "ripple": [TorqueRipple("shoulder", amplitude=0.3, **WAVE), TorqueRipple("shoulder", amplitude=0.1, **WAVE)],
    "saturation": [TorqueSaturation("shoulder", scale=1.1), TorqueSaturation("elbow", scale=0.4)],
    "gain_then_offset": [TorqueOffset("elbow", offset=0.3), TorqueConstantError("elbow", gain=0.5)],
    "parallel_spring": [ParallelSpring("shoulder", stiffness=2.0, rest=0.5)],
    "position_torque": [PositionTorque("elbow", cos_1=0.3, sin_1=-0.2, cos_2=0.15, sin_2=0.4)],
    "coupling": [JointCoupling("elbow", coefficient=0.3, other="shoulder")],
    "coupling_negative": [JointCoupling("shoulder", coefficient=-0.2, other="elbow")],
}
ON_RIGID = [
    "viscous",
    "warm_up",
    "warm_up_link",
    "torque_offset",
    "gains_add",
    "ripple",
    "saturation",
    "gain_then_offset",
    "parallel_spring",
    "position_torque",
    "coupling",
]

CORNERED: dict[str, list[Effect]] = {
    "drag": [
        QuadraticDrag("elbow", side="motor", coefficient=0.3),
        QuadraticDrag("elbow", side="link", coefficient=0.2),
    ],
    "asymmetric_viscous": [
        AsymmetricViscousFriction("elbow", side="motor", coefficient_positive=0.3, coefficient_negative=0.9),
        AsymmetricViscousFriction("shoulder", side="link", coefficient_positive=0.8, coefficient_negative=0.1),
    ],
    "presliding": [PreslidingFriction("elbow", side="motor", **STIFF)],
    "presliding_link": [PreslidingFriction("shoulder", side="link", **STIFF)],
    "hysteresis": [SpringHysteresis("elbow", stiffness=60.0, width=0.003)],
    "hysteresis_after_the_gap": [
        SpringHysteresis("elbow", stiffness=60.0, width=0.003),
        Backlash("elbow", half_gap=0.002),
        KinematicError("elbow", amplitude=0.004, harmonic=9.0, phase=0.3),
    ],
    "gaps_add": [Backlash("elbow", half_gap=0.002), Backlash("elbow", half_gap=0.003)],
    "gap_on_both": [Backlash("elbow", half_gap=0.002), Backlash("shoulder", half_gap=0.001)],
    "limit": [TorqueSpeedLimit("shoulder", stall_torque=0.8, no_load_speed=1.2)],
    "end_stops": [EndStop("elbow", lower=0.4, upper=0.9, stiffness=80.0, damping=1.5)],
    "all_of_the_motor": [
        TorqueSpeedLimit("elbow", stall_torque=0.9, no_load_speed=8.0),
        TorqueSaturation("elbow", scale=3.0),
        TorqueRipple("elbow", amplitude=0.3, **WAVE),
        TorqueConstantError("elbow", gain=0.4),
        TorqueOffset("elbow", offset=-0.1),
    ],
}
NEED_A_SPRING = ("hysteresis", "hysteresis_after_the_gap", "gaps_add", "gap_on_both")
CORNERED_ON_RIGID = [name for name in CORNERED if name not in NEED_A_SPRING]

DRY: dict[str, list[Effect]] = {
    "coulomb": [CoulombFriction("elbow", side="motor", level=0.2), CoulombFriction("elbow", side="link", level=0.1)],
    "asymmetric": [AsymmetricFriction("elbow", side="motor", level_positive=0.3, level_negative=0.1)],
    "asymmetric_link": [AsymmetricFriction("shoulder", side="link", level_positive=0.1, level_negative=0.3)],
    "stribeck": [StribeckFriction("shoulder", side="link", excess=0.3, velocity=0.2, exponent=2.0)],
    "position_dependent": [PositionDependentFriction("elbow", side="link", amplitude=0.3, **WAVE)],
    "position_dependent_motor": [PositionDependentFriction("elbow", side="motor", amplitude=0.3, **WAVE)],
    "load_dependent": [LoadDependentFriction("shoulder", coefficient=0.3)],
    "load_stribeck": [StribeckGearLoss("shoulder", driving=0.2, driven=0.6, velocity=0.5)],
    "load_directional": [DirectionalGearLoss("shoulder", driving=0.2, driven=0.6)],
    "load_directional_with_all": [
        DirectionalGearLoss("elbow", driving=0.5, driven=0.1),
        TransmissionDamping("elbow", coefficient=0.4),
        KinematicError("elbow", amplitude=0.004, harmonic=9.0, phase=0.3),
    ],
    "load_dependent_with_all": [
        LoadDependentFriction("elbow", coefficient=0.3),
        TransmissionDamping("elbow", coefficient=0.4),
        KinematicError("elbow", amplitude=0.004, harmonic=9.0, phase=0.3),
    ],
}


def difference(arm: Arm, effects: list[Effect], solver: Any, max_step: float = math.inf) -> float:
    """Largest difference of any state between flexdyn and SciPy."""
    arm = dataclasses.replace(arm, effects=tuple(effects), gravity=2.0)
    run = fd.simulate(model_of(arm), TORQUE, TIMES[-1], solver, times=TIMES, **START)
    memory = sum(isinstance(effect, fd.effects.MemoryEffect) for effect in effects)
    q, v = START["q0"], START["v0"]
    x0 = [*q, *(q if arm.elastic else []), *v, *(v if arm.elastic else []), *[0.0] * memory]
    expected = trajectory(lambda t, x: arm.derivative(t, x, TORQUE), x0, TIMES, max_step)
    found = states(run)
    applied = [arm.applied(j, TORQUE[j], run.theta[-1, j], run.omega[-1, j]) for j in (0, 1)]
    np.testing.assert_allclose(run.tau_applied[-1], applied, atol=1e-12)
    return float(np.abs(found - expected[:, : found.shape[1]]).max())


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_laws_on_elastic_joints(name: str) -> None:
    """All states over 1.5 s of driven motion under gravity."""
    assert difference(ELASTIC, SMOOTH[name], LOCATED) < 1e-9


@pytest.mark.parametrize("name", ON_RIGID)
def test_smooth_laws_on_rigid_joints(name: str) -> None:
    """Motor-side laws act through the gear on the link."""
    assert difference(RIGID, SMOOTH[name], LOCATED) < 1e-9


@pytest.mark.parametrize("name", CORNERED)
def test_laws_with_corners_on_elastic_joints(name: str) -> None:
    """Corners are located by flexdyn and crossed in small steps by SciPy."""
    assert difference(ELASTIC, CORNERED[name], LOCATED, max_step=2e-3) < 1e-7


@pytest.mark.parametrize("name", CORNERED_ON_RIGID)
def test_laws_with_corners_on_rigid_joints(name: str) -> None:
    """The same where rotor and link are one."""
    assert difference(RIGID, CORNERED[name], LOCATED, max_step=2e-3) < 1e-7


@pytest.mark.parametrize("name", DRY)
def test_smoothed_dry_laws(name: str) -> None:
    """Dry laws with Sgn(u) smoothed to tanh(u/eps): levels, sides and what they depend on."""
    assert difference(ELASTIC, DRY[name], SMOOTHED, max_step=2e-3) < 1e-8


@pytest.mark.parametrize("name", [name for name in DRY if "load" not in name])
def test_smoothed_dry_laws_on_rigid_joints(name: str) -> None:
    """On a rigid joint link and motor intervals add."""
    assert difference(RIGID, DRY[name], SMOOTHED, max_step=2e-3) < 1e-8


def test_every_law_of_the_plant_is_here() -> None:
    """No effect that moves the arm is left out, but for those that tests beside this one move."""
    moved = {effect.name for cases in (SMOOTH, CORNERED, DRY) for effects in cases.values() for effect in effects}
    other = {"joint_elasticity", CommandDelay.name}
    plant = {
        kind.name
        for kind in fd.effects.catalogue().values()
        if kind.__module__.startswith("flexdyn.") and kind.stage not in ("inertia", "model", "sensor")
    }
    assert moved | other == plant
