"""Laws that the data cannot tell apart are not told apart by rounding."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.verify import SURE, Trial, confirmed, surely_less
from tests.arms import two_link
from tests.oracles.two_link import TwoLink


def test_rounding_speaks_for_no_law() -> None:
    """The same law by two names leaves the same rows but for the last digits, all on one side."""
    rows = np.random.default_rng(0).chisquare(40, size=60)
    assert abs(surely_less(rows * (1.0 + 1e-9), rows)) < 0.01


@pytest.mark.parametrize("less", [0.9, 0.97])
def test_what_is_less_in_every_block_is_surely_less(less: float) -> None:
    """Both ways round."""
    rows = np.random.default_rng(0).chisquare(40, size=60)
    assert surely_less(rows, less * rows) > SURE
    assert surely_less(less * rows, rows) < -SURE


def fitted(effect: fd.effects.Effect | None, chi2: float) -> Any:
    """A fit of an arm whose encoders' noise is 1e-6 rad, with or without an effect."""
    noise = SimpleNamespace(q=np.full(2, 1e-6), theta=np.full(2, 1e-7))
    return SimpleNamespace(
        chi2=chi2,
        regression=SimpleNamespace(prior_chi2=10.0),
        hypothesis=SimpleNamespace(effects=() if effect is None else (effect,)),
        equations=SimpleNamespace(true=two_link(TwoLink())),
        space=SimpleNamespace(noise=noise),
    )


def at_noise(seed: int) -> Trial:
    """A check that leaves noise alone."""
    draw = np.random.default_rng(seed)
    shot: Any = SimpleNamespace(by_window=np.ones(24), misfit=np.full(24, 50.0), gap=1.0)
    return Trial(shot, draw.chisquare(100, size=24), np.full(24, 100.0))


@pytest.mark.parametrize(
    ("effect", "named"),
    [
        (fd.effects.KinematicError("elbow", amplitude=2e-6, harmonic=1.0, phase=0.0), False),
        (fd.effects.KinematicError("elbow", amplitude=2e-5, harmonic=1.0, phase=0.0), True),
        (fd.effects.EncoderEccentricity("q.elbow", amplitude=-3e-6, harmonic=2.0, phase=0.0), False),
        (fd.effects.SensorOffset("theta.elbow", offset=5e-6), True),
        (fd.effects.SensorOffset("tau.elbow", offset=1e-6), True),
        (fd.effects.TorqueOffset("elbow", offset=1e-9), True),
    ],
    ids=str,
)
def test_an_error_of_less_than_a_count_is_not_named_where_the_check_is_silent(
    effect: fd.effects.Effect, named: bool
) -> None:
    """Whatever the fit gains by it; a torque is not counted."""
    trial = at_noise(0)
    assert confirmed(trial, fitted(None, 5000.0), trial, fitted(effect, 4000.0)) is named
