"""Play in the gear of a link that nobody measures: rows without its load's changes of sign, and short windows."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.equations.mask import reversal_mask
from flexdyn.diagnose.hypothesis.prepared import prepared, without_reversals
from flexdyn.diagnose.hypothesis.workspace import weighed
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE
from tests.oracles.integrate import held

Array = NDArray[np.float64]
HALF_GAP = 4e-3
DAMPED_LITTLE = dataclasses.replace(ARM, damping=(0.8, 0.03))
"""The damper acts within the gap, too."""


def _with_play(x: Sequence[float], tau: Sequence[float]) -> list[float]:
    """X' of the arm where the elbow's spring sees the deflection beyond a gap."""
    seen = list(x)
    delta = x[3] - x[1]
    seen[3] = x[1] + np.sign(delta) * max(abs(delta) - HALF_GAP, 0.0)
    return DAMPED_LITTLE.derivative(seen, (tau[0], tau[1]))


@cache
def _states(seconds: float = 12.0) -> tuple[Array, Array]:
    t = np.arange(round(seconds * RATE)) / RATE
    tau = np.stack(
        [2.0 * np.sin(5.1 * t + 0.5) + np.sin(8.0 * t), 1.5 * np.sin(4.7 * t) + 0.8 * np.sin(11.0 * t)], axis=1
    )
    rows = iter(tau.tolist())
    states, _ = held(_with_play, [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0], t, lambda _t, _x: next(rows))
    return states, tau


def _recorded() -> tuple[fd.FlexibleJointModel, fd.Recording]:
    states, tau = _states()
    draw, channels = np.random.default_rng(3), {}
    for j, joint in enumerate(JOINTS):
        channels[f"theta.{joint}"] = states[:, 2 + j] + 1e-6 * draw.standard_normal(len(tau))
        channels[f"tau.{joint}"] = tau[:, j] + 0.01 * draw.standard_normal(len(tau))
    return two_link(DAMPED_LITTLE, tolerance=0.03), fd.Recording(np.arange(len(tau)) / RATE, channels)


def _mean_squares(model: fd.FlexibleJointModel, data: Measured, *, whole: bool) -> Array:
    """Of the whitened rows of each equation that are used."""
    bare, _ = prepared(model, (data,))
    part = bare if whole else without_reversals(bare)
    assert part is not None
    work = weighed(part)
    used = ~part.mask.reshape(-1, 2)
    assert used.sum() > 40
    white = np.where(used, work.white(work.equations.residual).reshape(-1, 2), 0.0)
    return np.asarray((white**2).sum(axis=0) / used.sum(axis=0))


def test_without_changes_of_sign_of_the_load_play_is_an_offset() -> None:
    """The model without play leaves little there, and hundreds of times as much where loads change their signs."""
    model, recording = _recorded()
    data = measured(model, recording)
    part, whole = (_mean_squares(model, data, whole=each) for each in (False, True))
    assert part.max() < 5.0
    assert whole.min() > 100.0 * part.max()


def test_rows_are_left_out_where_the_load_may_be_zero() -> None:
    """Every instant at which the true spring torque passes zero is in a row that is left out."""
    model, recording = _recorded()
    bare, _ = prepared(model, (measured(model, recording),))
    states, _ = _states()
    delta = states[:, 3] - states[:, 1]
    free = np.flatnonzero(np.abs(delta) < HALF_GAP) / RATE
    times = bare.equations.at_rows("t")
    left_out = reversal_mask(bare.equations, bare.noise).reshape(-1, 2)[:, 1]
    nearest = np.abs(times[:, None] - free).min(axis=1) < 0.5 / RATE
    assert nearest.sum() > 50
    assert left_out[nearest].mean() > 0.95
    assert not left_out.all()


@pytest.mark.slow
def test_play_behind_motors_is_named() -> None:
    """Its width is found though no slope leads there; the truth was integrated by SciPy."""
    answer = fd.diagnose(*_recorded(), progress=False)
    assert [(each.suspect.effect, each.suspect.joint) for each in answer.findings] == [("backlash", "elbow")]
    (gap,) = (each for each in answer.model.effects if isinstance(each, fd.effects.Backlash))
    assert gap.half_gap == pytest.approx(HALF_GAP, rel=0.03)
