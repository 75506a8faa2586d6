"""A gear whose losses differ by the direction of power is named with both shares, and the plainer law where they agree.

The recordings are of an elastic joint with two encoders, integrated here, and of a hoist that the model takes for
rigid, in closed form from sample to sample.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.effects import DirectionalGearLoss
from tests.diagnose.slides import named
from tests.diagnose.test_load_dependent import GRAVITY, MASS, RATE, UNITS, lifted
from tests.diagnose.test_load_dependent import model as hoist
from tests.diagnose.workspaces import workspace
from tests.effects.arms import model_of
from tests.effects.reference import Arm

Array = NDArray[np.float64]
PENDULUM = Arm((900.0,), (2.0,), (0.5,), gravity=9.81)
INERTIA, WEIGHT = float(PENDULUM.mass_matrix([0.0])[0, 0]), float(PENDULUM.bias([0.0], [0.0])[0])
SMALL = 2e-5
"""Step of the integration [s]."""


def _swung(torque: Array, driving: float, driven: float) -> tuple[Array, Array]:
    """Positions of link and rotor (samples,) under held torques, with the friction of every step within its set."""
    K, D, J = PENDULUM.stiffness[0], PENDULUM.damping[0], PENDULUM.rotor[0]
    q = theta = v = omega = 0.0
    found, many = [], round(1.0 / RATE / SMALL)
    for asked in torque.tolist():
        found.append((q, theta))
        for _ in range(many):
            carried = K * (theta - q) + D * (omega - v)
            v += SMALL / INERTIA * (carried - WEIGHT * math.cos(q))
            free = omega + SMALL / J * (asked - carried)
            up, down = (driving, driven) if carried > 0.0 else (driven, driving)
            holding = free * J / SMALL
            omega = free - SMALL / J * min(max(holding, -down * abs(carried)), up * abs(carried))
            q, theta = q + SMALL * v, theta + SMALL * omega
    link, rotor = np.array(found).T
    return link, rotor


def _pendulum(driving: float, driven: float) -> fd.Recording:
    t = np.arange(round(10.0 * RATE)) / RATE
    torque = 13.0 * np.sin(2.3 * t) + 8.0 * np.sin(5.1 * t + 0.4) + 5.0 * np.sin(12.7 * t)
    draw = np.random.default_rng(5)
    q, theta = (each + 1e-6 * draw.standard_normal(len(t)) for each in _swung(torque, driving, driven))
    noisy = torque + 0.01 * draw.standard_normal(len(t))
    return fd.Recording(t, {"q.shoulder": q, "theta.shoulder": theta, "tau.shoulder": noisy})


@pytest.mark.parametrize(
    ("driving", "driven"), [(0.1, 0.45), (0.3, 0.05), pytest.param(0.1, 1.2, marks=pytest.mark.slow)]
)
def test_both_shares_of_an_elastic_joint(driving: float, driven: float) -> None:
    """The load changes its sign, and power flows both ways under either load."""
    diagnosis = fd.diagnose(model_of(PENDULUM), fit=[_pendulum(driving, driven)])
    ((effect, values, probability),) = named(diagnosis)
    assert effect == "directional_gear_loss"
    assert values == pytest.approx({"driving": driving, "driven": driven}, abs=0.02)
    assert probability > 0.95


def test_one_share_is_load_dependent_friction() -> None:
    """A second number that the data do not need is not named."""
    ((effect, values, _),) = named(fd.diagnose(model_of(PENDULUM), fit=[_pendulum(0.2, 0.2)]))
    assert effect == "load_dependent_friction"
    assert values == pytest.approx({"coefficient": 0.2}, abs=0.005)


def _seen_by_its_motor(driving: float, driven: float) -> fd.Recording:
    record = _pendulum(driving, driven)
    return fd.Recording(record.t, {name: record[name] for name in ("theta.shoulder", "tau.shoulder")})


@pytest.mark.parametrize(("driving", "driven"), [(0.2, 0.2), (0.1, 0.45), (0.3, 0.05)])
def test_a_motor_encoder_alone(driving: float, driven: float) -> None:
    """The computed deflection contains the loss, and the load is the spring's torque: the right model leaves little."""
    given = model_of(PENDULUM)
    data = (measured(given, _seen_by_its_motor(driving, driven)),)
    loss = DirectionalGearLoss("shoulder", driving=driving, driven=driven)
    space, start, _ = workspace(given, data, dataclasses.replace(prepared(given, data)[1], effects=(loss,)))
    left, without = (
        space.equations.of(each.model()).residual for each in (start, dataclasses.replace(start, effects=()))
    )
    used = ~space.whiten.mask
    assert np.sqrt(np.mean(left[used] ** 2)) < 0.01 * WEIGHT
    assert np.sqrt(np.mean(without[used] ** 2)) > 0.1 * WEIGHT


@pytest.mark.slow
@pytest.mark.parametrize(("driving", "driven"), [(0.2, 0.2), (0.1, 0.45)])
def test_it_is_named_with_a_motor_encoder_alone(driving: float, driven: float) -> None:
    """Both numbers are right, and one share is told by the plainer law."""
    diagnosis = fd.diagnose(model_of(PENDULUM), fit=[_seen_by_its_motor(driving, driven)])
    ((effect, values, probability),) = named(diagnosis)
    plain = driving == driven
    assert effect == ("load_dependent_friction" if plain else "directional_gear_loss")
    wanted = {"coefficient": driving} if plain else {"driving": driving, "driven": driven}
    assert values == pytest.approx(wanted, abs=0.005)
    assert probability > 0.95


def test_a_hoist_that_the_model_takes_for_rigid(tmp_path: Path) -> None:
    """From motor data alone: the plain law is named, as direction is not asked about where no load is measured."""
    t = np.arange(round(8.0 * RATE)) / RATE
    force = MASS * GRAVITY * 0.85 + 9.0 * np.sin(2.9 * t + 0.3) + 7.0 * np.sin(6.1 * t) + 4.0 * np.sin(13.0 * t)
    draw = np.random.default_rng(3)
    theta = lifted(force, 0.1, 0.4) + 2e-6 * draw.standard_normal(len(t))
    noisy = force + 0.02 * draw.standard_normal(len(t))
    record = fd.Recording(t, {"theta.lift": theta, "tau.lift": noisy}, meta={"units": UNITS})
    diagnosis = fd.diagnose(hoist(tmp_path), fit=[record])
    ((effect, values, _),) = named(diagnosis)
    assert effect == "load_dependent_friction"
    (factor,) = [each["factor"] for each in diagnosis.to_dict()["calibration"] if each["parameter"] == "link_mass"]
    assert factor * (1.0 + values["coefficient"]) == pytest.approx(1.1, rel=0.03)
    assert factor * (1.0 - values["coefficient"]) == pytest.approx(0.6, rel=0.1)
