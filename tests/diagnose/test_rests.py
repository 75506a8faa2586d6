"""A motor that rests: its friction is unknown, and the equations of the other joints stay in use."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations.covariance import whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.mask import passage_mask, sign_mask
from flexdyn.diagnose.equations.rest import borders, long_runs, near
from flexdyn.diagnose.hypothesis.prepared import recorded_noise
from tests.arms import two_link
from tests.diagnose.truths import ARM, RATE, Levels, one_after_the_other

Array = NDArray[np.float64]
STIFF = dataclasses.replace(ARM, stiffness=(20000.0, 15000.0), damping=(20.0, 15.0))
HELD = 1.7
"""Amplitude of a stuck motor's torque, which its friction holds: the model knows of no friction [N m]."""


@cache
def _one_after_the_other(seconds: float = 8.0) -> tuple[Array, Array]:
    """States of STIFF, its elbow's motor stuck in the first half and its shoulder's in the second, and the torques."""
    t = np.arange(round(seconds * RATE)) / RATE
    first, idle = t < 0.5 * seconds, HELD * np.sin(9.0 * t)
    tau = np.stack(
        [
            np.where(first, 2.0 * np.sin(5.1 * t) + np.sin(3.0 * t), idle),
            np.where(first, idle, np.sin(6.7 * t) + 0.5 * np.sin(4.0 * t)),
        ],
        axis=1,
    )
    return one_after_the_other(STIFF, tau), tau


def _recording(seed: int = 0) -> fd.Recording:
    states, tau = _one_after_the_other()
    levels, draw = Levels(), np.random.default_rng(seed)
    step = np.sqrt(12.0) * levels.position
    channels = {}
    for j, joint in enumerate(("shoulder", "elbow")):
        channels[f"theta.{joint}"] = step * np.round(states[:, 2 + j] / step)
        channels[f"tau.{joint}"] = tau[:, j] + levels.torque * draw.standard_normal(len(tau))
    return fd.Recording(np.arange(len(tau)) / RATE, channels)


def _whitened() -> tuple[Array, NDArray[np.bool_]]:
    """White rows of the true model (times, joints), and which are used."""
    model = two_link(STIFF)
    data = measured(model, _recording())
    at = Equations(model, (data,), Filters.of_rate(data.dt), quasi_static=True)
    noise = recorded_noise((data,))
    mask = sign_mask(at, noise)
    assert sign_mask(dataclasses.replace(at, quasi_static=False), noise).all()
    return whitener(at, noise, mask)(at.residual).reshape(-1, 2), ~mask.reshape(-1, 2)


def test_rows_of_a_joint_stay_in_use_while_another_rests() -> None:
    """Each joint's own half is used but for its ends and reversals; where it rests, nothing is."""
    white, used = _whitened()
    half = len(white) // 2
    assert used[:half, 0].mean() > 0.5
    assert used[half:, 1].mean() > 0.5
    assert not used[:half, 1].any()
    assert not used[half + 20 :, 0].any()


def test_they_hold_noise_though_the_friction_of_the_resting_joint_is_unknown() -> None:
    """What the stuck motor gives is not what its spring carries."""
    white, used = _whitened()
    for j in range(2):
        assert np.sqrt(np.mean(white[used[:, j], j] ** 2)) < 2.0


def test_passages_of_a_computed_position_are_hidden_and_long_rests_are_not() -> None:
    """Where the motors change their parts, and at reversals; all rows there, as all contain that position."""
    model = two_link(STIFF)
    data = measured(model, _recording())
    at = Equations(model, (data,), Filters.of_rate(data.dt))
    hidden, own = (mask(at, recorded_noise((data,))).reshape(-1, 2) for mask in (passage_mask, sign_mask))
    assert np.array_equal(hidden[:, 0], hidden[:, 1])
    half = len(hidden) // 2
    assert hidden[half - 1 : half + 2].all()
    assert own.all()  # for the rests
    assert hidden[:half].mean() < 0.5
    turns = near(np.diff(np.sign(at.motions[0].omega[:, 0]), prepend=0.0) != 0.0, 2)[
        at.filters.instants(len(at.motions[0].t))
    ]
    moving = np.arange(len(hidden)) < half - 5
    assert hidden[turns & moving].all()


def test_links_that_are_measured_hide_nothing() -> None:
    """A position that is not computed knows of no friction."""
    states, tau = _one_after_the_other()
    channels = dict(_recording().channels) | {
        f"q.{joint}": states[:, j] for j, joint in enumerate(("shoulder", "elbow"))
    }
    model = two_link(STIFF)
    data = measured(model, fd.Recording(np.arange(len(tau)) / RATE, channels))
    assert not passage_mask(Equations(model, (data,), Filters.of_rate(data.dt)), recorded_noise((data,))).any()


def test_runs_borders_and_neighbours() -> None:
    """On ten samples, by hand."""
    rests = np.array([1, 1, 0, 1, 1, 1, 1, 0, 0, 1], dtype=bool)
    assert long_runs(rests, 2).tolist() == [False] * 3 + [True] * 4 + [False] * 3
    assert np.flatnonzero(borders(long_runs(rests, 2))).tolist() == [2, 3, 6, 7]
    assert np.flatnonzero(near(np.eye(10, dtype=bool)[4], 2)).tolist() == [2, 3, 4, 5, 6]
