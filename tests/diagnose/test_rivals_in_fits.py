"""A rival that the equations can hardly tell from a candidate is fitted in its place; offsets have their priors."""

from __future__ import annotations

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.corrected import LEAST_IN_COMMON
from flexdyn.diagnose.decision.one_law import with_best
from flexdyn.diagnose.decision.rivals_in_fits import rivals_in_fits
from flexdyn.diagnose.hypothesis.workspace import prepared
from flexdyn.diagnose.inference.passes import Posterior, posterior
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, two_link_recording

AMPLITUDE, HARMONIC, PHASE = 2e-3, 3.0, 0.7


@pytest.fixture(scope="module")
def found() -> Posterior:
    """Of the two-link arm, whose shoulder's motor has an encoder with a wave."""
    channels = dict(two_link_recording(Levels(), 0).channels)
    true = channels["theta.shoulder"]
    channels["theta.shoulder"] = true + AMPLITUDE * np.sin(HARMONIC * true + PHASE)
    t = two_link_recording(Levels(), 0).t
    model = two_link(ARM)
    return posterior(*prepared(model, (measured(model, fd.Recording(t, channels)),)))


def _place(found: Posterior, kind: str, joint: str = "shoulder") -> int:
    each = enumerate(found.space.candidates)
    return next(c for c, one in each if one.kind == kind and joint in (one.place.get("joint") or ""))


def test_a_rival_that_fits_worse_is_known_to(found: Posterior) -> None:
    """A kinematic error of the gear makes nearly the same rows. Its fit is less likely, and the wave stays."""
    ((wave, _),) = found.best
    made = rivals_in_fits(found)
    assert (made.best, made.fitted) == (found.best, found.fitted)
    assert made.space.candidates[wave].place == {"effect": "encoder_eccentricity", "channel": "theta.shoulder"}
    odds = {rest: each for rest, _, each in made.by_fits}
    assert odds[frozenset({_place(found, "kinematic_error")})] < 1e-6


def test_a_rival_that_fits_better_takes_the_place(found: Posterior) -> None:
    """The best structure is made to hold the kinematic error: the fit with the encoder's wave is more likely."""
    gear = _place(found, "kinematic_error")
    made = rivals_in_fits(with_best(found, frozenset({(gear, 0)})))
    assert {c for c, _ in made.best} == {c for c, _ in found.best}
    (wave,) = made.fitted.hypothesis.effects
    assert isinstance(wave, fd.effects.EncoderEccentricity)
    assert wave.channel == "theta.shoulder"
    assert wave.amplitude == pytest.approx(AMPLITUDE, rel=0.02)
    ((_, whole, odds),) = [each for each in made.by_fits if each[0] == frozenset(c for c, _ in made.best)]
    assert (whole, odds > 1e6) == (frozenset({gear}), True)


def test_what_has_in_common_with_a_candidate_may_be_its_rival(found: Posterior) -> None:
    """A gear's wave makes nearly all that the encoder's wave makes; friction of the other joint makes none of it."""
    ((wave, point),) = found.best
    gear, friction = _place(found, "kinematic_error"), _place(found, "viscous_friction", "elbow")
    assert found.space.in_common(found.best, wave, (wave, point)) == pytest.approx(1.0)
    assert max(found.space.in_common(found.best, wave, (gear, p)) for p in _points(found, gear)) > 0.9
    assert found.space.in_common(found.best, wave, (friction, 0)) < LEAST_IN_COMMON


def _points(found: Posterior, c: int) -> range:
    return range(len(found.space.candidates[c].points))


def test_offsets_are_integrated_out(found: Posterior) -> None:
    """Squares left and of offsets are those of rows whose covariance has them: ``w^T (1 + N S N^T)^-1 w``."""
    work = found.fitted.space
    residual = found.fitted.equations.residual
    N, w = work.nuisance * work.nuisance_sigma, work.whiten(residual)
    expected = w @ np.linalg.solve(np.eye(len(w)) + N @ N.T, w)
    white, of_offsets = work.without_offsets(residual)
    assert float(white @ white) + of_offsets == pytest.approx(expected, rel=1e-6)
