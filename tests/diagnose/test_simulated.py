"""Hypotheses fitted to windows of a sliding mass whose motion was computed without flexdyn."""

from __future__ import annotations

import dataclasses
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.corrected import corrected
from flexdyn.diagnose.decision.one_law import with_best
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.hypothesis import Hypothesis
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.inference.passes import Posterior
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.diagnose.shooting.gap import shoot
from flexdyn.diagnose.shooting.windows import Windows
from flexdyn.diagnose.simulated.reweighting import reweighed, share_in_windows
from flexdyn.diagnose.simulated.rivals_in_windows import preferred_by_windows
from flexdyn.diagnose.simulated.structures import Simulated
from flexdyn.diagnose.simulated.window_fit import WindowFit, fit_to_windows, searched, to_windows, unlike_noise
from flexdyn.diagnose.simulated.window_scan import promising
from flexdyn.model.uncertain_parameters import FileNumber
from tests.diagnose.truths import Levels, slider_model, slider_recording, sliding
from tests.diagnose.workspaces import workspace

RATE, MASS, LEVEL = 500.0, 2.5, 3.0
LEVELS = Levels(2e-6, 0.02)
T = np.arange(6000) / RATE
FORCE = 4.0 * np.sin(2.0 * np.pi * 0.7 * T) + 2.5 * np.sin(2.0 * np.pi * 1.9 * T)


def _begun(folder: Path, level: float, seed: int = 0) -> tuple[Fit, Windows]:
    """A mass under Coulomb friction of 3 N, seen with noise; a hypothesis with another level, and its windows."""
    x, v = sliding(FORCE, 1.0 / RATE, MASS, LEVEL)
    assert 0.05 < (v == 0.0).mean() < 0.8
    recording = slider_recording(x, FORCE, RATE, LEVELS, seed)
    model = slider_model(folder)
    space, start, _ = workspace(model, (measured(model, recording),))
    friction = fd.effects.CoulombFriction("lift", side="link", level=level)
    made = fit(dataclasses.replace(start, effects=(friction,)), space, steps=1)
    return made, Windows.of(model, [recording], LEVELS.noise(1))


def _level(found: Hypothesis) -> float:
    (effect,) = found.effects
    assert isinstance(effect, fd.effects.CoulombFriction)
    return effect.level


@pytest.mark.parametrize("level", [2.4, 3.6])
def test_numbers_come_from_windows_that_stick_and_slide(tmp_path: Path, level: float) -> None:
    """A level that is 20 % off comes to the true one within its error, and the gap to noise."""
    made, windows = _begun(tmp_path, level)
    start = WindowFit.of(made, windows)
    found = fit_to_windows(start)
    assert start.shot.gap > 5.0
    assert found.shot.gap == pytest.approx(1.0, abs=0.2)
    assert found.log_posterior > start.log_posterior + 100.0
    (std,) = found.made.std().values()
    assert 0.0 < std < 0.02 * LEVEL
    assert abs(_level(found.made.hypothesis) - LEVEL) < 4.0 * std
    assert found.made.stationary


def test_a_fit_to_windows_is_never_worse_than_its_start(tmp_path: Path) -> None:
    """From the true level, as from any other."""
    made, windows = _begun(tmp_path, LEVEL)
    start = WindowFit.of(made, windows)
    found = fit_to_windows(start)
    assert found.log_posterior >= start.log_posterior
    assert found.shot.log_likelihood == shoot(found.made.hypothesis.seen(), windows, start.shot.x0).log_likelihood


def test_a_fit_of_a_wrong_law_ends_where_its_steps_are_small_against_what_is_left(tmp_path: Path) -> None:
    """Viscous friction in the place of Coulomb friction: no damping leads to noise, and one more fit gains little."""
    made, windows = _begun(tmp_path, LEVEL)
    viscous = fd.effects.ViscousFriction("lift", side="link", coefficient=1.0)
    wrong = fit(dataclasses.replace(made.hypothesis, effects=(viscous,)), made.space, steps=1)
    found, right = fit_to_windows(WindowFit.of(wrong, windows)), fit_to_windows(WindowFit.of(made, windows))
    assert right.made.stationary
    assert not found.made.stationary  # it ended, and does not say that it arrived
    # What separates the windows from noise: about what the right law gains.
    gained = right.shot.log_likelihood - found.shot.log_likelihood
    assert found.shot.above_noise == pytest.approx(gained, rel=0.1)
    assert right.shot.above_noise < 0.01 * gained
    assert fit_to_windows(found).log_posterior - found.log_posterior < 0.05 * gained


def test_innovations_of_the_true_model_have_unit_variance(tmp_path: Path) -> None:
    """Of a free mass, over seeds; a mass that is 5 % off stands out, and its windows are less likely."""
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    model, likely, misfit = slider_model(tmp_path), [], []
    for seed in range(6):
        windows = Windows.of(model, [slider_recording(x, FORCE, RATE, LEVELS, seed)], LEVELS.noise(1))
        shots = [shoot(each, windows) for each in (model, model.replace(effects=[_lighter(0.05)]))]
        misfit.append(shots[0].misfit)
        likely.append([each.log_likelihood for each in shots])
    rows = len(misfit) * len(misfit[0]) * windows.blocks
    assert np.mean(misfit) == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / rows))
    assert all(right > wrong + 50.0 for right, wrong in likely)


def _lighter(share: float) -> fd.effects.ParameterError:
    """An error of the sliding mass."""
    return fd.effects.ParameterError(of="mass", parameter="link_mass", factor=1.0 - share)


def _compared(folder: Path, offset: float, level: float) -> tuple[Posterior, Hypothesis, Windows]:
    """A mass under friction and a force that is not recorded: posterior, start, windows."""
    model = slider_model(folder)
    x, _ = sliding(FORCE + offset, 1.0 / RATE, MASS, level)
    recording = slider_recording(x, FORCE, RATE, LEVELS, 0)
    bare, start = prepared(model, (measured(model, recording),))
    return posterior(bare, start), start, Windows.of(model, [recording], LEVELS.noise(1))


@pytest.mark.slow
def test_windows_bring_back_what_the_search_had_lost(tmp_path: Path) -> None:
    """A posterior that holds nothing: the friction comes from windows, which then decide alone."""
    found, start, windows = _compared(tmp_path, 0.0, LEVEL)
    nothing = frozenset[tuple[int, int]]()
    empty = fit(start, found.fitted.space, steps=1)
    lost = dataclasses.replace(found, best=nothing, fitted=empty, earlier=(frozenset(),))
    by_windows = reweighed(lost, windows, lambda made: True)
    assert by_windows is not None
    assert by_windows.explained
    again = by_windows.found
    (level,) = (each.level for each in again.fitted.hypothesis.effects if isinstance(each, fd.effects.CoulombFriction))
    assert level == pytest.approx(LEVEL, rel=0.03)
    assert not again.earlier
    # What the level takes off the windows is thousands of times what is left.
    (place,) = [c for c, _ in again.best]
    assert share_in_windows(Simulated(again, windows), place) > 1e3
    assert not unlike_noise(shoot(again.fitted.hypothesis.seen(), windows))
    assert unlike_noise(shoot(empty.hypothesis.seen(), windows))


def test_windows_decide_about_a_part_that_the_equations_leave_without_a_name(tmp_path: Path) -> None:
    """Equations that hardly prefer the friction: windows, which are noise with it, show that it is there."""
    found, _, windows = _compared(tmp_path, 0.0, LEVEL)
    nothing = frozenset[tuple[int, int]]()
    unsure = dataclasses.replace(found, known={found.best: 0.0, nothing: -0.5})
    assert not unlike_noise(shoot(found.fitted.hypothesis.seen(), windows))
    as_before = reweighed(unsure, windows, lambda made: True)
    weighed = reweighed(unsure, windows, lambda made: True, all_named=False)
    assert as_before is not None
    assert as_before.found.known == unsure.known
    assert weighed is not None
    assert weighed.found.best == found.best
    assert weighed.found.known[found.best] > weighed.found.known[nothing] + 100.0


def test_windows_at_noise_lack_nothing(tmp_path: Path) -> None:
    """With the friction nothing more is simulated; without it the search adds it."""
    found, _, windows = _compared(tmp_path, 0.0, LEVEL)
    simulated, nothing = Simulated(found, windows), frozenset[tuple[int, int]]()
    simulated.fit(found.best)
    assert simulated.grown(found.best) == found.best
    assert set(simulated.fits) == {found.best}
    simulated.fit(nothing)
    grown = simulated.grown(nothing)
    assert grown > nothing
    assert not unlike_noise(simulated.fits[grown].shot)


def test_windows_whose_innovations_are_noise_are_equally_likely(tmp_path: Path) -> None:
    """With the friction, and with a drag beside it: priors alone divide them. A level 3 % off is told from both."""
    found, _, windows = _compared(tmp_path, 0.0, LEVEL)
    drag = next(c for c, each in enumerate(found.space.candidates) if each.kind == "quadratic_drag")
    more, nothing = found.best | {(drag, 0)}, frozenset[tuple[int, int]]()
    simulated = Simulated(found, windows)
    for each in (found.best, more, nothing):
        simulated.start(each)
    made, known = simulated.fits, simulated.known
    prior = {
        each: made[each].log_posterior - made[each].shot.log_likelihood + found.space.log_volume(each) for each in made
    }
    assert made[more].shot.log_likelihood != made[found.best].shot.log_likelihood
    assert known[more] - known[found.best] == pytest.approx(prior[more] - prior[found.best])
    assert known[nothing] < known[more] - 1000.0
    (law,) = found.fitted.hypothesis.effects
    wrong = fd.effects.CoulombFriction("lift", side="motor", level=0.97 * LEVEL)
    both = (found.fitted.hypothesis, found.fitted.hypothesis.with_instead(law, wrong))
    shots = [shoot(each.seen(), windows) for each in both]
    assert [shot.has_white_innovations() for shot in shots] == [True, False]


def test_what_windows_have_found_is_fitted_to_them_where_another_part_goes(tmp_path: Path) -> None:
    """Friction beside a mass that turns out to be right, and gets no name: the equations may not see the friction."""
    found, _, windows = _compared(tmp_path, 0.0, LEVEL)
    candidates, plain = found.space.candidates, weighed(dataclasses.replace(found.bare, noise=found.noise))
    c = next(c for c, each in enumerate(candidates) if each.number and each.number.parameter == "link_mass")
    number, both = candidates[c].number, found.best | {(c, 0)}
    assert number is not None
    here = dataclasses.replace(found.fitted.hypothesis, freed=frozenset({number}))
    held = dataclasses.replace(found, best=both, known={both: 0.0}, fitted=to_windows(windows, found.fitted, here))
    answer = corrected(held, plain, refit=partial(to_windows, windows))
    assert [candidates[each.candidate].kind for each in answer.names] == ["coulomb_friction"]
    assert _level(answer.hypothesis) == pytest.approx(LEVEL, rel=0.01)
    assert answer.fitted.block == held.fitted.block > 0
    assert not corrected(held, plain).fitted.block


def test_windows_promise_what_is_missing_and_nothing_where_nothing_is(tmp_path: Path) -> None:
    """A weak force that the recording does not hold: without its law the windows ask for it, with it for nothing."""
    offset = 0.003
    found, start, windows = _compared(tmp_path, offset, 0.0)
    lacking = fit_to_windows(WindowFit.of(fit(start, found.fitted.space, steps=1), windows))
    best = promising(lacking, found.space, frozenset(), {})[0]
    assert best.gain > 10.0
    (step, whole), *_ = best.tried
    assert isinstance(whole, fd.effects.TorqueOffset)
    assert whole.offset == pytest.approx(offset, rel=0.1)
    right = fit_to_windows(lacking.with_one_more(whole, None, step))
    assert all(each.gain < 3.0 for each in promising(right, found.space, frozenset({best.point}), {}))


def test_what_windows_do_not_need_has_no_share_in_them(tmp_path: Path) -> None:
    """A drag that a free mass does not have."""
    model = slider_model(tmp_path)
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    recording = slider_recording(x, FORCE, RATE, LEVELS, 0)
    bare, start = prepared(model, (measured(model, recording),))
    found = posterior(bare, start)
    (drag,) = [c for c, each in enumerate(found.space.candidates) if each.kind == "quadratic_drag"][:1]
    here = dataclasses.replace(
        found.fitted.hypothesis, effects=(fd.effects.QuadraticDrag("lift", side="motor", coefficient=0.5),)
    )
    held = dataclasses.replace(found, best=frozenset({(drag, 0)}), fitted=fit(here, found.fitted.space, steps=1))
    windows = Windows.of(model, [recording], LEVELS.noise(1))
    assert not unlike_noise(shoot(found.fitted.hypothesis.seen(), windows))
    assert share_in_windows(Simulated(held, windows), drag) == 0.0


def test_of_two_laws_that_share_a_name_the_model_gets_the_one_that_windows_prefer(tmp_path: Path) -> None:
    """Coulomb friction in the place of a viscous one that the posterior began with, and not the other way round."""
    found, _, windows = _compared(tmp_path, 0.0, LEVEL)
    (right,) = found.best
    candidates = found.space.candidates
    viscous = next(c for c, each in enumerate(candidates) if each.kind == "viscous_friction")
    wrong = frozenset([(viscous, 0)])
    other = with_best(found, wrong)
    for begun, rivals in ((found, {right[0]: (viscous,)}), (other, {viscous: (right[0],)})):
        preferred = preferred_by_windows(begun, rivals, windows)
        assert preferred.best == found.best
        assert preferred.rejected.keys() == {viscous}
        assert preferred.rejected[viscous] > 1000.0
    alone = preferred_by_windows(other, {viscous: ()}, windows)
    assert (alone.best, alone.rejected) == (wrong, {})


def test_windows_reject_neither_of_two_laws_that_are_the_same_motion(tmp_path: Path) -> None:
    """A mass that is 30 % too small in the file, or a payload of that mass."""
    model = slider_model(tmp_path)
    x, _ = sliding(FORCE, 1.0 / RATE, 1.3 * MASS, 0.0)
    recording = slider_recording(x, FORCE, RATE, LEVELS, 0)
    found = posterior(*prepared(model, (measured(model, recording),)))
    ((mine, _),) = found.best
    kinds = {each.kind: c for c, each in enumerate(found.space.candidates) if each.kind in ("link_mass", "payload")}
    (other,) = set(kinds.values()) - {mine}
    preferred = preferred_by_windows(found, {mine: (other,)}, Windows.of(model, [recording], LEVELS.noise(1)))
    assert (preferred.best, preferred.rejected) == (found.best, {})


def test_a_number_far_out_of_its_tolerance_explains_no_windows(tmp_path: Path) -> None:
    """A mass of the file is 5 % off, its tolerance a thousandth: the windows are at noise, and that is a finding."""
    x, _ = sliding(FORCE, 1.0 / RATE, MASS, 0.0)
    model = slider_model(tmp_path).replace(effects=[_lighter(0.05)]).replace(tolerance=1e-3)
    recording = slider_recording(x, FORCE, RATE, LEVELS, 0)
    space, start, _ = workspace(model, (measured(model, recording),))
    windows = Windows.of(model, [recording], LEVELS.noise(1))
    (mass,) = (number for number in start.factors if number.parameter == "link_mass")
    moved = dataclasses.replace(start, factors={**start.factors, mass: 1.0 / 0.95})
    for freed, explains in ((frozenset[FileNumber](), False), (frozenset({mass}), True)):
        here = dataclasses.replace(moved, freed=freed)
        made = WindowFit.of(fit(here, space, steps=0), windows)
        assert not unlike_noise(made.shot)
        assert made.explains == explains


def test_a_search_shortens_a_delay_that_is_not_there(tmp_path: Path) -> None:
    """Factor by factor, as long as the windows gain by it; it ends, and never below nothing."""
    made, windows = _begun(tmp_path, LEVEL)
    late = fd.effects.CommandDelay("lift", delay=1e-3)
    here = fit(dataclasses.replace(made.hypothesis, effects=(*made.hypothesis.effects, late)), made.space, steps=0)
    start = WindowFit.of(here, windows.divided(4))
    found = searched(start)
    assert found.log_posterior >= start.log_posterior
    (delay,) = (each.delay for each in found.made.hypothesis.effects if isinstance(each, fd.effects.CommandDelay))
    assert 0.0 <= delay < 1e-3


def test_divided_windows_hold_the_same_samples_and_at_least_a_block(tmp_path: Path) -> None:
    """Quarters of windows; of windows of few blocks as many parts as there are."""
    _, windows = _begun(tmp_path, LEVEL)
    quarters = windows.divided(4)
    assert len(quarters) == 4 * len(windows)
    assert quarters.rows == windows.rows // windows.block // 4 * windows.block
    np.testing.assert_array_equal(quarters.t[1], windows.t[0, quarters.rows : 2 * quarters.rows])
    short = windows.divided(10**6)
    assert short.rows == windows.block
    assert len(short) == windows.blocks * len(windows)
