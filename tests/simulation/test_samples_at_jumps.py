"""What a run writes at a jump of its command is of the torque from there on, in every solver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.simulation.test_dc_motor import EVERY, model, steps

pytestmark = pytest.mark.filterwarnings("ignore::flexdyn.LimitWarning")
JUMPS = np.array([3.0, -0.5, 3.0, -4.0])
LAWS: dict[str, Any] = {
    "torque_speed_limit": fd.effects.TorqueSpeedLimit("elbow", stall_torque=1.0, no_load_speed=5.0),
    "torque_saturation": fd.effects.TorqueSaturation("elbow", scale=2.0),
}


@EVERY
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_limited_torque(solver: Any, error: float, law: Any) -> None:
    """On one side of its limit before the jump, on the other after it: the law of tau and omega of that very row."""
    arm = fd.load_model("scara_two_link").replace(effects=[law])
    t = 0.1 * np.arange(5)
    command = fd.Samples(t, {"shoulder": np.zeros(5), "elbow": np.append(JUMPS, JUMPS[-1])})
    run = fd.simulate(arm, command, 0.4, solver=solver, rate=100)
    rows = np.array([10, 20, 30])
    np.testing.assert_array_equal(run.tau[rows, 1], JUMPS[1:])
    wanted = law.torque(run.theta[:, 1], run.omega[:, 1], tau=run.tau[:, 1])
    np.testing.assert_allclose(run.tau_applied[:, 1], wanted, atol=1e-9)


@EVERY
def test_a_motor_at_the_limit_of_its_current(tmp_path: Path, solver: Any, error: float) -> None:
    """From the limit to the other side of it: the current of that voltage and speed."""
    arm = model(tmp_path, motor={"supply": 12.0, "current_limit": 1.5})
    run = fd.simulate(arm, steps(12.0, 2.0, -12.0, each=0.2), solver=solver, rate=100)
    assert run.electrical.current[20, 0] * run.electrical.current[19, 0] < 0.0 or run.electrical.current[20, 0] < 1.0
    np.testing.assert_allclose(run.tau_applied[:, 0], 8.0 * 0.04 * run.electrical.current[:, 0], atol=1e-9)
