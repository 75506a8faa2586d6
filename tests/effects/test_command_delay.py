"""A command delay shifts what reaches the motor and nothing else."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CommandDelay, TorqueOffset, TorqueSpeedLimit
from tests.effects.arms import ELASTIC, model_of, states
from tests.effects.reference import trajectory

EXACT = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13)
DELAY = 0.0337
RNG = np.random.default_rng(11)
COMMAND = fd.Samples(np.arange(11) * 0.05, RNG.normal(0.0, 0.6, (11, 2)))


def late(t: float, delay: float, joint: int) -> float:
    """The held command of SciPy's arm, 0 before its first sample arrives and after its end."""
    row = int(np.floor((t - delay) / 0.05 + 1e-9))
    return float(COMMAND.values[row, joint]) if 0 <= row < 10 else 0.0


@pytest.mark.parametrize("delays", [[DELAY], [0.02, 0.0137], [0.05], [0.2]])
def test_a_delayed_command(delays: list[float]) -> None:
    """The elbow's torque comes late by the sum of its delays, the shoulder's at once; 0 before the first arrives."""
    arm = dataclasses.replace(ELASTIC, gravity=2.0, effects=tuple(CommandDelay("elbow", delay=d) for d in delays))
    total = sum(delays)
    switches = np.unique(np.round([*np.arange(15) * 0.05, *(np.arange(14) * 0.05 + total)], 12))
    times = switches[switches <= 0.7]
    run = fd.simulate(model_of(arm), COMMAND, 0.7, EXACT, times=times, q0=[-0.4, 0.7])
    expected = [np.array([-0.4, 0.7, -0.4, 0.7, 0.0, 0.0, 0.0, 0.0])]
    for begin, end in pairwise(times):
        middle = 0.5 * (begin + end)
        tau = [late(middle, 0.0, 0), late(middle, total, 1)]

        def f(t: float, x: Sequence[float], tau: list[float] = tau) -> list[float]:
            return arm.derivative(t, x, tau)

        expected.append(trajectory(f, expected[-1], [begin, end])[-1])
        row = int(np.searchsorted(times, begin))
        np.testing.assert_allclose(run.tau_applied[row], tau, atol=1e-12)
        np.testing.assert_allclose(run.tau[row], [late(middle, 0.0, 0), late(middle, 0.0, 1)], atol=1e-12)
    np.testing.assert_allclose(states(run), expected, atol=1e-9)


def test_the_delay_comes_first() -> None:
    """Offset and limit act on the torque that arrives: an offset is there from the start."""
    effects = [
        TorqueSpeedLimit("elbow", stall_torque=0.5, no_load_speed=1e9),
        TorqueOffset("elbow", offset=0.2),
        CommandDelay("elbow", delay=0.1),
    ]
    run = fd.simulate(model_of(ELASTIC, effects), [0.0, 1.0], 0.2, EXACT, rate=100)
    np.testing.assert_allclose(run.tau_applied[:, 1], np.where(run.t < 0.0999, 0.2, 0.5), atol=1e-9)


def test_a_delayed_controller() -> None:
    """What a controller asked for at a tick acts a delay later, unless a tick has come in between."""
    asked = []

    def law(t: float, x: fd.State) -> list[float]:
        asked.append((t, 1.0 - t))
        return [0.0, asked[-1][1]]

    model = model_of(ELASTIC, [CommandDelay("elbow", delay=0.025)])
    run = fd.simulate(model, fd.Controller(law, rate=100), 0.2, EXACT, times=np.arange(40) * 0.005 + 0.001)
    tick = np.floor((run.t - 0.025) / 0.01 + 1e-9) * 0.01
    np.testing.assert_allclose(run.tau_applied[:, 1], np.where(tick >= 0.0, 1.0 - tick, 0.0), atol=1e-12)
    np.testing.assert_allclose(run.tau[:, 1], 1.0 - np.floor(run.t / 0.01 + 1e-9) * 0.01, atol=1e-12)
