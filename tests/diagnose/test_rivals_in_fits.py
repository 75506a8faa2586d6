"""A rival that the equations can hardly tell from a candidate is fitted in its place; offsets have their priors."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.constants import LEAST_IN_COMMON
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.masses import Masses
from flexdyn.diagnose.decision.naming import names
from flexdyn.diagnose.decision.one_law import with_best
from flexdyn.diagnose.decision.rivals_in_fits import rivals_in_fits
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.diagnose.inference.scan import Scan
from flexdyn.diagnose.inference.structure_model import hypothesis_of
from flexdyn.diagnose.inference.substitutes import in_common
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE, Levels, two_link_recording
from tests.oracles.integrate import held

AMPLITUDE, HARMONIC, PHASE = 2e-3, 3.0, 0.7
OFFSET = 2e-3
MOTORS_OFFSET = {"effect": "sensor_offset", "channel": "theta.shoulder"}
HEAVY = dataclasses.replace(ARM, gravity=9.81)


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
    odds = _odds(made)
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
    ((_, whole, odds),) = [each for each in made.by_fits if {c for c, _ in each[0]} == {c for c, _ in made.best}]
    assert (whole, odds > 1e6) == (frozenset({gear}), True)


def test_what_has_in_common_with_a_candidate_may_be_its_rival(found: Posterior) -> None:
    """A gear's wave makes nearly all that the encoder's wave makes; friction of the other joint makes none of it."""
    ((wave, point),) = found.best
    gear, friction = _place(found, "kinematic_error"), _place(found, "viscous_friction", "elbow")
    assert in_common(found.space, found.best, wave, (wave, point)) == pytest.approx(1.0)
    assert max(in_common(found.space, found.best, wave, (gear, p)) for p in _points(found, gear)) > 0.9
    assert in_common(found.space, found.best, wave, (friction, 0)) < LEAST_IN_COMMON


def _points(found: Posterior, c: int) -> range:
    return range(len(found.space.candidates[c].points))


@pytest.fixture(scope="module")
def balanced() -> fd.Recording:
    """The arm, held out against gravity: no spring's torque changes its sign. The shoulder's motor encoder is off."""
    at = np.array([0.1, 0.4])

    def balance(t: float, x: Sequence[float]) -> list[float]:
        wanted = at + 0.25 * np.array(
            [np.sin(3.1 * t) + 0.5 * np.sin(7.3 * t), np.sin(4.3 * t) + 0.5 * np.sin(9.1 * t)]
        )
        weight = np.array(HEAVY.weight(*x[:2]))
        return [float(each) for each in weight + 40.0 * (wanted - np.array(x[2:4])) - 8.0 * np.array(x[6:8])]

    t = np.arange(round(4.0 * RATE)) / RATE
    sag = np.array(HEAVY.weight(*at)) / np.array(HEAVY.stiffness)
    states, tau = held(HEAVY.derivative, [*at, *(at + sag), 0, 0, 0, 0], t, balance)
    draw, step = np.random.default_rng(0), np.sqrt(12.0) * 2e-5
    seen = {f"q.{joint}": states[:, j] for j, joint in enumerate(JOINTS)}
    seen |= {f"theta.{joint}": states[:, 2 + j] for j, joint in enumerate(JOINTS)}
    seen["theta.shoulder"] = seen["theta.shoulder"] + OFFSET
    channels = {name: step * np.round(x / step) for name, x in seen.items()}
    channels |= {f"tau.{joint}": tau[:, j] + 0.01 * draw.standard_normal(len(t)) for j, joint in enumerate(JOINTS)}
    return fd.Recording(t, channels)


def test_a_backlash_on_one_side_is_as_good_as_an_offset(balanced: fd.Recording) -> None:
    """Springs that gravity winds one way: nothing tells the offset of an encoder from a gap of that half width."""
    model = two_link(HEAVY)
    here = posterior(*prepared(model, (measured(model, balanced),)))
    made, backlash = rivals_in_fits(here), _place(here, "backlash")
    odds = _odds(made)
    (offset,) = (c for c, one in enumerate(here.space.candidates) if one.place == MOTORS_OFFSET)
    assert 1.0 / 3.0 < odds[frozenset({backlash})] / odds.get(frozenset({offset}), 1.0) < 3.0
    masses = Masses.of(made.known).by_fits(made.by_fits)
    (name,) = names(masses, frozenset(c for c, _ in made.best))
    kinds = {here.space.candidates[c].kind for c in (name.candidate, *name.rivals)}
    assert (name.established, kinds) == (True, {"sensor_offset", "backlash"})
    effects = hypothesis_of(here.space, next(s for s, _, _ in made.by_fits if backlash in dict(s)), whole=True).effects
    assert [effect.name for effect in effects] == ["backlash"]


def test_a_backlash_that_changes_sides_is_no_offset() -> None:
    """The same offset of an encoder, of an arm whose springs wind both ways: a gap does not explain it."""
    true = two_link_recording(Levels(), 0)
    channels = dict(true.channels) | {"theta.shoulder": true["theta.shoulder"] + OFFSET}
    model = two_link(ARM)
    here = posterior(*prepared(model, (measured(model, fd.Recording(true.t, channels)),)))
    made = rivals_in_fits(here)
    assert made.best == here.best
    assert _odds(made)[frozenset({_place(here, "backlash")})] < 1e-6


def test_two_of_three_signals_of_a_joint_may_be_late(found: Posterior) -> None:
    """A late command beside a late encoder, as there are two encoders; beside a late record of its torque it is one."""
    never = Scan(found.space).clash[_place(found, "command_delay")]
    lags = {each.place["channel"]: c for c, each in enumerate(found.space.candidates) if each.kind == "channel_lag"}
    assert len(lags) == 6
    assert {channel for channel, c in lags.items() if c in never} == {"tau.shoulder"}


def _odds(made: Posterior) -> dict[frozenset[int], float]:
    return {frozenset(c for c, _ in structure): odds for structure, _, odds in made.by_fits}


def test_offsets_are_integrated_out(found: Posterior) -> None:
    """Squares left and of offsets are those of rows whose covariance has them: ``w^T (1 + N S N^T)^-1 w``."""
    work = found.fitted.space
    residual = found.fitted.equations.residual
    N, w = work.nuisance * work.nuisance_sigma, work.whiten(residual)
    expected = w @ np.linalg.solve(np.eye(len(w)) + N @ N.T, w)
    white, of_offsets = work.without_offsets(residual)
    assert float(white @ white) + of_offsets == pytest.approx(expected, rel=1e-6)
