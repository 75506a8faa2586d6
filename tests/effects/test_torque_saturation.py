"""Torque lost at high current: its place among the actuator effects, in every solver, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexdyn as fd
from flexdyn.effects import (
    Effect,
    TorqueConstantError,
    TorqueOffset,
    TorqueRipple,
    TorqueSaturation,
    TorqueSpeedLimit,
    ViscousFriction,
)
from tests.effects.arms import model_of
from tests.effects.reference import Arm

RIGID = Arm((math.inf,), (0.0,), (0.5,))
INERTIA = float(RIGID.mass_matrix([0.0])[0, 0])
SCALE, TORQUE = 1.5, 2.0
GIVEN = TORQUE * SCALE / (SCALE + TORQUE)
SOLVERS = [
    fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12),
    fd.solvers.Rosenbrock(rtol=1e-10, atol=1e-12),
    fd.solvers.RungeKutta4(step=1e-3),
]
SATURATION = TorqueSaturation("shoulder", scale=SCALE)


def run_of(effects: list[Effect], torque: float, solver: Any = SOLVERS[0], **settings: Any) -> fd.Run:
    """One joint under a constant torque."""
    return fd.simulate(model_of(RIGID, effects), [torque], 2.0, solver, rate=200, **settings)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: type(solver).__name__)
def test_a_constant_torque_accelerates_by_what_is_left_of_it(solver: Any, sign: float) -> None:
    """Half and less of it is left; the same in either direction."""
    run = run_of([SATURATION], sign * TORQUE, solver)
    np.testing.assert_allclose(run.q[:, 0], sign * 0.5 * GIVEN / INERTIA * run.t**2, atol=1e-9)
    np.testing.assert_allclose(run.tau_applied[:, 0], sign * GIVEN, rtol=1e-15)
    assert (run.tau[:, 0] == sign * TORQUE).all()


def test_time_stepping_gives_the_same_end_speed() -> None:
    """Its velocities are those of the sum of the torques."""
    run = run_of([SATURATION], TORQUE, fd.solvers.TimeStepping(step=1e-3))
    assert run.v[-1, 0] == pytest.approx(GIVEN / INERTIA * 2.0, rel=1e-12)


def test_no_torque_reaches_the_scale() -> None:
    """However much is asked for."""
    asked = np.array([1.0, 1e2, 1e6])
    given = SATURATION.torque(0.0, 0.0, tau=asked)
    assert (np.diff(given) > 0.0).all()
    assert SCALE * (1.0 - 2e-6) < given[-1] < SCALE


def test_it_comes_after_gain_offset_and_ripple_and_before_the_limit() -> None:
    """In whatever order the effects are listed; against SciPy along the motion."""
    ripple = TorqueRipple("shoulder", amplitude=0.4, harmonic=5.0, phase=0.3)
    effects: list[Effect] = [
        TorqueSpeedLimit("shoulder", stall_torque=1.2, no_load_speed=4.0),
        SATURATION,
        ripple,
        TorqueOffset("shoulder", offset=0.2),
        TorqueConstantError("shoulder", gain=0.5),
        ViscousFriction("shoulder", side="motor", coefficient=0.3),
    ]

    def applied(theta: float, omega: float) -> float:
        asked = 1.5 * TORQUE + 0.2 + 0.4 * math.sin(5.0 * theta + 0.3)
        return min(asked * SCALE / (SCALE + asked), max(0.0, 1.2 * (1.0 - omega / 4.0)))

    run = run_of(effects, TORQUE)
    expected = solve_ivp(
        lambda t, x: [x[1], (applied(x[0], x[1]) - 0.3 * x[1]) / INERTIA],
        (0.0, 2.0),
        [0.0, 0.0],
        t_eval=run.t,
        rtol=1e-11,
        atol=1e-12,
        max_step=2e-3,
    )
    np.testing.assert_allclose(run.q[:, 0], expected.y[0], atol=1e-8)
    wanted = [applied(q, v) for q, v in zip(run.q[:, 0], run.v[:, 0], strict=True)]
    np.testing.assert_allclose(run.tau_applied[:, 0], wanted, atol=1e-12)
    assert run.stats["events"] >= 1  # the limit is reached


def test_the_ledger_counts_the_torque_that_is_left() -> None:
    """What the motor supplies is the kinetic energy, to rounding: what is lost is no work."""
    energy = run_of([SATURATION], TORQUE).energy
    assert energy.supplied[-1, 0] == pytest.approx(energy.kinetic[-1] - energy.kinetic[0], rel=1e-9)
    assert np.abs(energy.residual).max() < 1e-9 * float(energy.supplied[-1, 0])


def test_what_holds_an_arm_is_asked_for_with_the_loss(tmp_path: Any) -> None:
    """The statics invert the law; beyond the scale no torque holds."""
    weight = Arm((math.inf,), (0.0,), (0.5,), gravity=1.0)
    needed = float(weight.bias([0.0], [0.0])[0])
    strong = model_of(weight, [TorqueSaturation("shoulder", scale=2.0 * needed)])
    held = fd.holding_torques(strong, [0.0])
    assert held.upper == pytest.approx([2.0 * needed], rel=1e-8)
    weak = model_of(weight, [TorqueSaturation("shoulder", scale=0.9 * needed)])
    with pytest.raises(fd.InputError, match="too weak to hold"):
        fd.holding_torques(weak, [0.0])
