"""A joint that moved one way only: friction and a constant offset are the same, whatever is expected of drives."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.report.result import Diagnosis
from tests.diagnose.truths import Levels, slider_model, slider_recording

RATE, MASS, LEVEL = 250.0, 2.5, 0.8


@pytest.fixture(scope="module", name="folder")
def _folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of the slider's URDF."""
    return tmp_path_factory.mktemp("slider")


@functools.cache
def _answer(folder: Path, *, back: bool, friction: bool) -> Diagnosis:
    """Two sweeps of 4 s at 0.4 m/s with ramps of 0.5 s, both one way, or there and back."""
    t = np.arange(round(8.0 * RATE)) / RATE
    within = t % 4.0
    way = np.where(back & (t >= 4.0), -1.0, 1.0)
    v = way * (0.4 * np.clip(np.minimum(within, 4.0 - within) / 0.5, 0.0, 1.0) + 0.01)
    # The force that moves the mass over a sample by the parabola that joins its velocities.
    needed = MASS * np.diff(v, append=v[-1]) * RATE
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) / RATE)])
    force = needed + LEVEL * (way if friction else 1.0)
    recording = slider_recording(x, force, RATE, Levels(2e-6, 0.02), seed=3)
    return diagnose(slider_model(folder), [recording], progress=False)


@pytest.mark.parametrize("friction", [True, False])
def test_one_way_leaves_friction_or_offset(folder: Path, *, friction: bool) -> None:
    """Either truth is among the names, though the prior of the one is 400 times that of the other; a note says so."""
    answer = _answer(folder, back=False, friction=friction)
    (finding,) = answer.findings
    assert {"coulomb_friction", "torque_offset"} <= {each.effect for each in finding.names}
    assert abs(next(iter(finding.suspect.parameters.values())).value) == pytest.approx(LEVEL, rel=0.02)
    (note,) = [note for note in answer.notes if "prior" in note]
    assert "torque offset on the motor side of lift" in note
    assert "as well as Coulomb friction" in note


def test_the_motion_that_is_proposed_goes_back(folder: Path) -> None:
    """It was simulated, and it turns."""
    (finding,) = _answer(folder, back=False, friction=True).findings
    assert finding.plan is not None
    assert "both ways" in finding.experiment or "reverse" in finding.experiment


@pytest.mark.parametrize("friction", [True, False])
def test_there_and_back_tells(folder: Path, *, friction: bool) -> None:
    """Friction turns with the motion, an offset does not: neither is taken for the other."""
    answer = _answer(folder, back=True, friction=friction)
    named = [{each.effect for each in finding.names} for finding in answer.findings]
    assert (named == [{"coulomb_friction"}]) == friction
    assert not any("prior" in note for note in answer.notes)
