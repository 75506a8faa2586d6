"""Torque lost at high current is named with its scale; a motor that is weaker throughout is not taken for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.effects import TorqueSaturation, ViscousFriction
from tests.diagnose.slides import model, named, recording

GIVEN = ViscousFriction("lift", side="motor", coefficient=9.0)


def _friction(v: float) -> float:
    return 9.0 * v


@pytest.mark.parametrize("scale", [60.0, 200.0, 1000.0])
def test_it_is_named_with_its_scale(tmp_path: Path, scale: float) -> None:
    """As large as the largest torque, three times it and sixteen times: 50, 25 and 6 % of that are lost."""
    record = recording(_friction, lambda asked: asked * scale / (scale + abs(asked)))
    diagnosis = fd.diagnose(model(tmp_path, [GIVEN]), fit=[record])
    ((effect, values, probability),) = named(diagnosis)
    assert effect == "torque_saturation"
    assert values == pytest.approx({"scale": scale}, rel=5e-3)
    assert probability > 0.95
    assert diagnosis.verdict == "explained"


def test_beside_friction_that_the_model_lacks(tmp_path: Path) -> None:
    """Both are named."""
    record = recording(_friction, lambda asked: asked * 200.0 / (200.0 + abs(asked)))
    found = {effect: values for effect, values, _ in named(fd.diagnose(model(tmp_path), fit=[record]))}
    assert found.keys() == {"torque_saturation", "viscous_friction"}
    assert found["torque_saturation"]["scale"] == pytest.approx(200.0, rel=5e-3)


def test_a_weaker_motor_is_a_gain(tmp_path: Path) -> None:
    """A fifth less at every torque."""
    record = recording(_friction, lambda asked: 0.8 * asked)
    ((effect, values, _),) = named(fd.diagnose(model(tmp_path, [GIVEN]), fit=[record]))
    assert effect == "torque_constant_error"
    assert values == pytest.approx({"gain": -0.2}, rel=0.05)


def test_a_motor_cut_off_is_a_limit(tmp_path: Path) -> None:
    """All of the torque up to 45 N, and no more."""
    record = recording(_friction, lambda asked: max(-45.0, min(45.0, asked)))
    ((effect, values, _),) = named(fd.diagnose(model(tmp_path, [GIVEN]), fit=[record]))
    assert effect == "torque_speed_limit"
    assert values["stall_torque"] == pytest.approx(45.0, rel=5e-3)


def test_its_price_is_the_slope_of_the_law(tmp_path: Path) -> None:
    """Rows are measured in recorded torque: ``sum log d applied/d recorded = -2 sum log(1 + |tau|/scale)``."""
    record = recording(_friction, seconds=6.0)
    bare, start = prepared(model(tmp_path, [GIVEN]), (measured(model(tmp_path, [GIVEN]), record),))
    library = posterior(bare, start).space.library
    tau = np.concatenate(
        [along.tau[library.equations.filters.instants(len(along.t)), 0] for along in library.equations.motions]
    )
    wanted = -2.0 * np.log1p(np.abs(tau) / 80.0).sum()
    assert library.sizes.log_jacobian(TorqueSaturation("lift", scale=80.0)) == pytest.approx(wanted, rel=1e-4)
