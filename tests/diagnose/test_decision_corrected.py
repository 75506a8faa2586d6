"""What stands in the corrected model: effects that can stand without others, and none that is less than a count."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import flexdyn as fd
from flexdyn.diagnose.constants import SMALLEST_TORQUE_SHARE
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.corrected import corrected
from flexdyn.diagnose.decision.findings import reported_names
from flexdyn.diagnose.decision.gaps import nearer
from flexdyn.diagnose.decision.last_fit import leaves_noise
from flexdyn.diagnose.decision.model_effects import possible, with_elasticity
from flexdyn.diagnose.decision.run import diagnose
from flexdyn.diagnose.decision.significance import is_significant, least_deviation
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.proposal import Proposal
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.inference.candidate import Candidate
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.effects import (
    AsymmetricFriction,
    CoulombFriction,
    Effect,
    EncoderEccentricity,
    JointElasticity,
    LoadDependentFriction,
    ViscousFriction,
)
from tests.arms import two_link
from tests.diagnose.truths import ARM, Levels, slider_model, slider_recording, sliding, two_link_recording
from tests.diagnose.workspaces import workspace

SOFT = {name: JointElasticity(name, stiffness=900.0) for name in ("shoulder", "elbow")}
LOADED = {name: LoadDependentFriction(name, side="motor", coefficient=0.1) for name in ("shoulder", "elbow")}
PLAIN = ViscousFriction("shoulder", side="motor", coefficient=0.2)
RATE, INERTIA, STEP = 250.0, 2.5, 1e-4
"""Sampling [Hz], a wheel [kg m^2] and the step of its encoder [rad]."""


def _two_links(effects: tuple[Effect, ...], elastic: tuple[str, ...] = ()) -> Hypothesis:
    """A hypothesis of an arm whose joints are rigid but for some."""
    joints = {
        name: {"rotor_inertia": 0.1, **({"stiffness": 400.0} if name in elastic else {})}
        for name in ("shoulder", "elbow")
    }
    return Hypothesis(fd.FlexibleJointModel(fd.load_robot("scara_two_link"), joints), {}, effects=effects)


def test_load_dependent_friction_keeps_the_elasticity_of_its_joint() -> None:
    """Also where that is not named; what other joints have is left out, and what stands is not added again."""
    here = _two_links((SOFT["shoulder"], SOFT["elbow"], LOADED["elbow"], PLAIN))
    assert with_elasticity(here, [LOADED["elbow"]]) == (LOADED["elbow"], SOFT["elbow"])
    assert with_elasticity(here, [SOFT["elbow"], LOADED["elbow"]]) == (SOFT["elbow"], LOADED["elbow"])
    assert with_elasticity(here, [PLAIN]) == (PLAIN,)


def test_load_dependent_friction_goes_with_the_elasticity_of_its_joint() -> None:
    """A rigid joint cannot have it; one that the model file says is elastic can."""
    effects: list[Effect] = [LOADED["shoulder"], LOADED["elbow"], PLAIN]
    assert possible(_two_links(()), effects) == (PLAIN,)
    assert possible(_two_links(()), [SOFT["elbow"], *effects]) == (SOFT["elbow"], LOADED["elbow"], PLAIN)
    assert possible(_two_links((), ("shoulder",)), effects) == (LOADED["shoulder"], PLAIN)


@pytest.mark.parametrize(("factors", "closer"), [((1.0, 1.0), True), ((0.5, 1.9), True), ((0.5, 2.1), False)])
def test_closer_is_the_geometric_mean_of_the_channels(factors: tuple[float, float], closer: bool) -> None:
    """Half the error at one encoder is worth twice the error at another, whatever their units."""
    before = np.random.default_rng(0).standard_normal((9, 20, 2)) * [1.0, 1e-4]
    assert nearer(before, before * factors) is closer


def test_one_window_does_not_tell_whether_a_model_is_closer() -> None:
    """It may be on the wrong side of a stick: the median window counts; half of them and more do."""
    before = np.ones((9, 20, 1))
    few, many = 0.5 * before, 0.5 * before
    few[:4], many[:5] = 1e3, 1e3
    assert nearer(before, few)
    assert not nearer(before, many)


def _wheel(folder: Path, inertia: float = INERTIA) -> fd.FlexibleJointModel:
    path = folder / "wheel.urdf"
    path.write_text(f"""<robot name="wheel"><link name="base"/>
<link name="disc"><inertial><mass value="1.0"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="{inertia}"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="disc"/><axis xyz="0 0 1"/>
<limit effort="1000" velocity="100"/></joint></robot>""")
    return fd.FlexibleJointModel(fd.load_robot(path), {}, gravity=[0.0, 0.0, 0.0])


def _turned(steps: float, friction: float = 0.0) -> fd.Recording:
    """The wheel's motion as an encoder saw it whose disc is off by so many of its steps, three times a turn."""
    t = np.arange(round(8.0 * RATE)) / RATE
    torque = 60.0 * np.sin(2.1 * t + 0.3) + 50.0 * np.sin(5.3 * t) + 30.0 * np.sin(11.0 * t)
    x, _ = sliding(torque, 1.0 / RATE, INERTIA, friction)
    seen = x + steps * STEP * np.sin(3.0 * x + 0.4)
    noisy = torque + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    return fd.Recording(t, {"q.axle": STEP * np.round(seen / STEP), "tau.axle": noisy})


@pytest.mark.parametrize(("friction", "seen"), [(0.0, False), (1.0, True)])
def test_an_effect_is_seen_where_its_size_is_more_than_its_error(tmp_path: Path, friction: float, seen: bool) -> None:
    """Dry friction that the wheel does not have is fitted with some size, within its standard deviations of nothing."""
    model = _wheel(tmp_path)
    bare, start = prepared(model, (measured(model, _turned(0.0, friction)),))
    begun = CoulombFriction("axle", side="link", level=0.5)
    law = Proposal({"effect": "coulomb_friction", "joint": "axle", "side": "link"}, lambda point, x: begun)
    made = fit(dataclasses.replace(start, effects=(begun,)), weighed(bare))
    assert is_significant(Candidate("coulomb_friction", law, None, [()], [], 1), made, 0.0) is seen


@pytest.mark.parametrize(("factor", "seen"), [(1.0, False), (0.8, True)])
def test_a_number_is_seen_where_it_differs_from_the_files_by_more_than_its_error(
    tmp_path: Path, factor: float, seen: bool
) -> None:
    """The inertia of the wheel as its file has it, right or a fifth too small."""
    model = _wheel(tmp_path, factor * INERTIA)
    bare, start = prepared(model, (measured(model, _turned(0.0)),))
    number = next(each for each in start.factors if each.parameter == "link_inertia")
    made = fit(dataclasses.replace(start, freed=frozenset({number})), weighed(bare))
    assert is_significant(Candidate("link_inertia", None, number, [()], [], 1), made, 0.0) is seen


@pytest.mark.parametrize("steps", [0.0, 0.7, 10.0])
def test_a_wave_is_named_also_below_a_step_of_the_encoder_and_rounding_is_not(tmp_path: Path, steps: float) -> None:
    """Rounding alone is no wave. One of 0.7 steps is there in every turn, while what is rounded averages out."""
    answer = diagnose(_wheel(tmp_path), [_turned(steps)])
    found = {each.suspect.effect: each.suspect.parameters for each in answer.findings}
    assert set(found) == ({"encoder_eccentricity"} if steps else set())
    if steps:
        assert found["encoder_eccentricity"]["harmonic"].value == pytest.approx(3.0, rel=1e-3)
        assert found["encoder_eccentricity"]["amplitude"].value == pytest.approx(steps * STEP, rel=0.05)


def test_the_least_size_of_a_wave_follows_from_the_steps_that_were_passed(tmp_path: Path) -> None:
    """As a share of the torque it is what this part of the amplitude makes; of friction it is the share itself."""
    model = _wheel(tmp_path)
    bare, start = prepared(model, (measured(model, _turned(0.0)),))
    library = posterior(bare, start).space.library
    friction = ViscousFriction("axle", side="motor", coefficient=1e-3)
    change = library.equations.residual / library.sizes.of(friction, library.equations.residual)[0]
    assert library.sizes.of(friction, change)[1] == SMALLEST_TORQUE_SHARE
    passed = float(np.ptp(_turned(0.0)["q.axle"])) / STEP
    for amplitude in (0.02 * STEP, 0.2 * STEP):
        disc = EncoderEccentricity("q.axle", amplitude=amplitude, harmonic=3.0, phase=0.0)
        share = 2.0 * STEP / np.sqrt(passed) / amplitude
        assert share > SMALLEST_TORQUE_SHARE
        assert library.sizes.of(disc, change)[1] == pytest.approx(share, rel=0.1)


def test_sizes_of_one_law_differ_from_nothing_together(tmp_path: Path) -> None:
    """Levels of both directions: by as many standard deviations as the root of what chi^2 rises by without them."""
    t, levels = np.arange(6000) / 500.0, Levels(2e-6, 0.02)
    force = 4.0 * np.cos(4.4 * t) + 2.5 * np.cos(11.9 * t)
    x, _ = sliding(force, 1.0 / 500.0, INERTIA, 0.01)
    model = slider_model(tmp_path)
    bare, start = prepared(model, (measured(model, slider_recording(x, force, 500.0, levels, 0)),))
    law, space = AsymmetricFriction("lift", side="link", level_positive=0.01, level_negative=0.01), weighed(bare)
    made, without = (fit(dataclasses.replace(start, effects=each), space) for each in ((law,), ()))
    (found,) = made.hypothesis.effects
    sizes = {(found, name): getattr(found, name) for name in ("level_positive", "level_negative")}
    alone = [made.deviation({key: size}) for key, size in sizes.items()]
    assert alone == pytest.approx([size / made.std()[key] for key, size in sizes.items()])
    together = made.deviation(sizes)
    assert together > 1.2 * max(alone)
    assert together**2 == pytest.approx(without.chi2 - made.chi2, rel=0.3)
    assert made.deviation({(found, "level_positive"): np.inf}) == np.inf


def test_what_a_deviation_is_worth_depends_on_the_prior_odds() -> None:
    """The likeliest size makes odds of 19, from even odds and from 1 to 20; from 20 to 1 hardly any is needed."""
    even, seldom = least_deviation(0.0), least_deviation(-np.log(20.0))
    sizes = np.linspace(0.0, 8.0, 8001)
    for z, odds in ((even, 1.0), (seldom, 1.0 / 20.0)):
        factors = norm.pdf(z, sizes) / norm.pdf(z, 0.0)
        assert odds * factors.max() == pytest.approx(19.0, rel=1e-3)
    assert least_deviation(np.log(20.0)) == pytest.approx(norm.ppf(0.95))


@pytest.mark.parametrize("unnamed", [False, True])
def test_a_number_beyond_its_tolerance_is_a_finding_only_where_all_effects_have_names(
    tmp_path: Path, unnamed: bool
) -> None:
    """An inertia half too small, which the fit corrects: beside an effect without a name it may imitate that."""
    model = _wheel(tmp_path, 0.5 * INERTIA)
    bare, start = prepared(model, (measured(model, _turned(0.0)),))
    answer = corrected(posterior(bare, start), weighed(bare))
    (inertia,) = [each.candidate for each in answer.names]
    effect = next(c for c, each in enumerate(answer.candidates) if each.number is None)
    nameless = dataclasses.replace(answer, names=(), genuine={effect: 0.5} if unnamed else {})
    assert [each.candidate for each in reported_names(nameless)] == ([] if unnamed else [inertia])


def test_a_number_that_the_comparison_leaves_within_its_tolerance_is_no_finding(tmp_path: Path) -> None:
    """The right inertia, and a fit that moved it far: small amounts of a law may have moved it, not the wheel."""
    model = _wheel(tmp_path)
    bare, start = prepared(model, (measured(model, _turned(0.0)),))
    answer = corrected(posterior(bare, start), weighed(bare))
    assert not reported_names(answer)
    moved = dataclasses.replace(answer.hypothesis, factors=dict.fromkeys(answer.hypothesis.factors, 2.0))
    fitted = dataclasses.replace(answer.fitted, hypothesis=moved)
    assert not reported_names(dataclasses.replace(answer, fitted=fitted))


def test_what_an_encoder_rounds_away_is_no_model_error() -> None:
    """It rounds down, half a step on average, which winds a spring; with the offsets of the fit the rest is noise."""
    levels = Levels(position=1e-4, torque=0.01)
    seen = two_link_recording(levels, seed=2)
    half = 0.5 * np.sqrt(12.0) * levels.position
    rounded = {name: x - half if name.startswith("q") else x for name, x in seen.channels.items()}
    model = two_link(ARM)
    space, start, _ = workspace(model, (measured(model, fd.Recording(seen.t, rounded)),))
    made = fit(start, space)
    assert leaves_noise(made, space)
    bare = dataclasses.replace(made, hypothesis=dataclasses.replace(made.hypothesis, counts=()))
    assert not leaves_noise(bare, space)
