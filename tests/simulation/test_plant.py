"""From effects to the compiled plant: neutral ones vanish, the others act in their order."""

from __future__ import annotations

import math

import numpy as np
import pytest

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
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
SOLVERS = [fd.solvers.DormandPrince(), fd.solvers.RungeKutta4(step=1e-3, smoothing=0.05)]
NEUTRAL: list[Effect] = [
    ViscousFriction("elbow", side="link", coefficient=0.0),
    ViscousFriction("elbow", side="motor", coefficient=0.0),
    CoulombFriction("shoulder", side="link", level=0.0),
    StribeckFriction("shoulder", side="motor", excess=0.0, velocity=0.1),
    TransmissionDamping("elbow", coefficient=0.0),
    TorqueOffset("elbow", offset=0.0),
    TorqueSpeedLimit("elbow", stall_torque=math.inf, no_load_speed=1.0),
    Payload(mass=0.0),
]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("effect", NEUTRAL, ids=lambda effect: effect.name)
def test_a_neutral_effect_changes_nothing(effect: Effect, solver: fd.solvers.Solver) -> None:
    """Bit for bit, statistics included, among other effects of its kind."""
    others: list[Effect] = [ViscousFriction("elbow", side="link", coefficient=0.1), Payload(mass=0.2)]
    runs = [fd.simulate(two_link(ARM, each), [0.3, 0.1], 0.5, solver, **BENT) for each in (others, [effect, *others])]
    np.testing.assert_array_equal(state(runs[0]), state(runs[1]))
    np.testing.assert_array_equal(runs[0].tau_s, runs[1].tau_s)
    assert dict(runs[0].stats) == dict(runs[1].stats)


def test_effects_of_the_actuator_act_in_their_order() -> None:
    """The offset comes before the limit, however the model lists them."""
    offset = TorqueOffset("elbow", offset=0.5)
    limit = TorqueSpeedLimit("elbow", stall_torque=0.6, no_load_speed=100.0)
    for effects in ([offset, limit], [limit, offset]):
        run = fd.simulate(two_link(ARM, effects), [0.0, 0.4], 0.1)
        np.testing.assert_allclose(run.tau_applied[:, 1], 0.6 * (1 - run.omega[:, 1] / 100.0), rtol=1e-12)
        assert (run.tau[:, 1] == 0.4).all()
