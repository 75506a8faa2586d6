"""Power and energy: friction takes, springs give back what they got, memory loses nothing less than it stores."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import (
    Backlash,
    Effect,
    HardeningSpring,
    KinematicError,
    PreslidingFriction,
    SpringHysteresis,
)
from flexdyn.simulation.plant import build_plant
from tests.effects.arms import catalogue_examples, model_of
from tests.effects.reference import Arm

Array = NDArray[np.float64]
FRICTION = [e for e in catalogue_examples() if e.stage in ("friction", "dry") and not e.no_torque]
MEMORYLESS = [e for e in FRICTION if e.name != "joint_coupling"]
NUMBER = st.floats(-1e3, 1e3)
PART = st.floats(1e-3, 1e3)
LOOSE = Arm((300.0,), (0.0,), (0.1,))
"""One elastic joint that loses nothing."""
INERTIA = float(LOOSE.mass_matrix([0.0])[0, 0])


@pytest.mark.parametrize("effect", MEMORYLESS, ids=lambda effect: effect.name)
@given(x=NUMBER, u=NUMBER, t=st.floats(0, 1e4), tau=NUMBER, data=st.data())
def test_memoryless_friction_never_supplies_power(
    effect: Any, x: float, u: float, t: float, tau: float, data: st.DataObject
) -> None:
    """F u >= 0 whatever position, time, load and parameters; f = 0 at u = 0 or a set that holds it."""
    numbers = {field.name: data.draw(PART) for field in effect.parameters()}
    f = float(dataclasses.replace(effect, **numbers).torque(x, u, t=t, tau=tau))
    assert f * u >= 0.0
    assert f == 0.0 or u != 0.0


def test_every_memoryless_friction_has_been_asked() -> None:
    """All of the contract's but the coupling, which acts on another joint's velocity and may supply power."""
    assert len(MEMORYLESS) == 11
    (coupling,) = [effect for effect in FRICTION if effect.name == "joint_coupling"]
    assert coupling.torque(0.0, 2.0) == 1.0


def rate(arm: Arm, effects: list[Effect], x: list[float]) -> Array:
    """X' of one joint without torque, from the core."""
    plant = build_plant(model_of(arm, effects))
    out = np.empty(len(x))
    plant.derivative(0.0, np.array(x), np.zeros(1), 1.0, out)
    return out


@given(u=st.floats(-20, 20), part=st.floats(-1, 1), level=PART, stiffness=PART, damping=st.floats(0, 1e3))
def test_presliding_friction_dissipates(u: float, part: float, level: float, stiffness: float, damping: float) -> None:
    """F u >= d/dt (1/2 stiffness z^2) at every state that it can reach, abs(z) <= level/stiffness."""
    effect = PreslidingFriction("shoulder", side="link", level=level, stiffness=stiffness, damping=damping)
    rigid = Arm((math.inf,), (0.0,), (0.1,))
    z = part * level / stiffness
    _, a, z_rate = rate(rigid, [effect], [0.3, u, z])
    supplied = -float(rigid.mass_matrix([0.0])[0, 0]) * a * u
    stored = stiffness * z * z_rate
    scale = max(abs(supplied), abs(stored), abs(damping * u * u))
    assert supplied - stored >= -1e-11 * scale
    assert z_rate * np.sign(z) <= 1e-12 * abs(u) or abs(part) < 1.0  # it cannot leave that range


@given(slip=st.floats(-20, 20), part=st.floats(-1, 1), stiffness=PART, width=PART)
def test_hysteresis_dissipates(slip: float, part: float, stiffness: float, width: float) -> None:
    """Tau delta' >= d/dt (1/2 stiffness h^2) at every state that it can reach, abs(h) <= width."""
    effect = SpringHysteresis("shoulder", stiffness=stiffness, width=width)
    soft = Arm((1e-9,), (0.0,), (0.1,))
    h = part * width
    *_, alpha, h_rate = rate(soft, [effect], [0.0, 0.0, 0.0, slip, h])
    supplied = -0.1 * alpha * slip  # the rotor alone moves: what it loses goes into the transmission
    stored = stiffness * h * h_rate
    assert supplied - stored >= -1e-11 * max(abs(supplied), abs(stored))


@pytest.mark.parametrize(
    "effects",
    [
        [KinematicError("shoulder", amplitude=0.01, harmonic=10.0, phase=0.3)],
        [
            KinematicError("shoulder", amplitude=0.01, harmonic=10.0, phase=0.3),
            KinematicError("shoulder", amplitude=-0.003, harmonic=23.0, phase=1.0),
            HardeningSpring("shoulder", cubic=5e4),
            Backlash("shoulder", half_gap=0.002),
        ],
    ],
    ids=["alone", "with_others"],
)
def test_a_kinematic_error_conserves_energy_at_resonance(effects: list[Any]) -> None:
    """Over 10 s at the speed at which the error shakes the joint in its own frequency; much energy goes to and fro."""
    frequency = math.sqrt(300.0 * (1 / 0.1 + 1 / INERTIA))
    speed = frequency / 10.0
    solver = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-14)
    run = fd.simulate(model_of(LOOSE, effects), None, 10.0, solver, v0=[speed])
    delta = run.theta[:, 0] - run.q[:, 0]
    cubic = sum(effect.cubic for effect in effects if isinstance(effect, HardeningSpring))
    for effect in effects:
        if isinstance(effect, KinematicError):
            delta = delta + effect.amplitude * np.sin(effect.harmonic * run.theta[:, 0] + effect.phase)
    gap = sum(effect.half_gap for effect in effects if isinstance(effect, Backlash))
    delta = np.sign(delta) * np.maximum(np.abs(delta) - gap, 0.0)
    spring = 150.0 * delta**2 + cubic / 4 * delta**4
    total = spring + 0.5 * INERTIA * run.v[:, 0] ** 2 + 0.05 * run.omega[:, 0] ** 2
    assert np.abs(total / total[0] - 1.0).max() < 1e-9
    assert spring.max() > 20 * spring[0] + 0.02
