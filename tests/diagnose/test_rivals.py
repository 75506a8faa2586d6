"""Laws that the data cannot tell apart are not told apart by rounding."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose import contest, rivals
from flexdyn.diagnose.candidates import Candidate
from flexdyn.diagnose.hypothesis import Hypothesis
from flexdyn.diagnose.numbers import FileNumber
from flexdyn.diagnose.refine import Refined
from flexdyn.diagnose.rivals import is_rival
from flexdyn.diagnose.stage import Named, Stage
from flexdyn.diagnose.verify import SURE, Trial, confirmed, surely_less
from tests.arms import two_link
from tests.oracles.two_link import TwoLink

MANY: Any = SimpleNamespace(thinned=lambda most: most)  # windows of which nobody asks more


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


def beside(chi2: float, *effects: fd.effects.Effect) -> Any:
    """A fit with these effects that leaves so much, near noise."""
    hypothesis = Hypothesis(two_link(TwoLink()), {LEVEL: 1.0}, effects=effects)
    regression = SimpleNamespace(rows=1000, data_chi2=1000.0)
    return SimpleNamespace(hypothesis=hypothesis, regression=regression, reduced=1.0, chi2=chi2, reached=chi2)


def drag_beside_offset(trial: Any, *, left: float) -> tuple[Stage, fd.effects.Effect]:
    """A torque offset whose rival did as well, and the drag that was found then; they leave so much together."""
    offset, coulomb = LAWS
    drag = fd.effects.QuadraticDrag("shoulder", side="link", coefficient=0.3)
    first = Candidate(beside(9e6, offset), 0.0, 0.0, offset, None, 9e6)
    rival = Candidate(beside(9e6, coulomb), 0.0, 0.0, coulomb, None, 9e6)
    both = beside(left, offset, drag)
    second = Candidate(both, 0.0, 0.0, drag, None, left)
    return Stage(both, trial, (Named(first, (rival,)), Named(second))), drag


@pytest.mark.parametrize(("behind", "left"), [(1000.0, 0), (1.0, 1)])
def test_rivals_are_asked_again_beside_what_was_found_since(
    behind: float, left: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before the second effect was known the first one's rival did as well; now it must do so beside it."""
    asked = []

    def fit(start: Hypothesis, _space: Any, hopeless: float) -> Any:
        assert hopeless > 0.0
        asked.append(start.effects)
        return beside(1000.0 + behind, *start.effects)

    monkeypatch.setattr(rivals, "fit", fit)
    nothing: Any = None
    stage, drag = drag_beside_offset(nothing, left=1000.0)
    search: Any = SimpleNamespace(space=None, say=lambda *_: None)
    after = rivals.asked_again(search, stage)
    assert asked == [(drag, LAWS[1])]
    assert len(after.named[0].rivals) == left
    assert after.named[0].candidate.chi2 == 1000.0
    assert after.named[1] is stage.named[1]


@pytest.mark.parametrize(
    ("reached", "gap", "takes"),
    [
        (1000.0, 1.0, True),
        (19_995.0, 1.0, False),  # as well, not better
        (1000.0, 9.0, False),  # the check says otherwise
        (30_000.0, 1.0, False),
    ],
)
def test_a_rival_that_surely_does_better_beside_what_was_found_takes_the_place(
    reached: float, gap: float, takes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a third effect would be found that makes up for the wrong one."""
    monkeypatch.setattr(rivals, "fit", lambda start, _space, hopeless: beside(reached, *start.effects))
    was: Any = SimpleNamespace(gap=5.0)
    now: Any = SimpleNamespace(gap=gap)
    stage, drag = drag_beside_offset(was, left=20_000.0)
    search: Any = SimpleNamespace(space=None, say=lambda *_: None, tried=lambda fitted: Stage(fitted, now))
    after = rivals.outdone(search, stage)
    if not takes:
        assert after is stage
        return
    assert after.fitted.hypothesis.effects == (drag, LAWS[1])
    assert [each.candidate.effect for each in after.named] == [drag, LAWS[1]]
    assert not after.named[1].rivals
    among = [(each.effect, each.behind, each.gap) for each in after.named[1].among]
    assert among == [(LAWS[1], 0.0, 1.0), (LAWS[0], 19_000.0, 5.0)]


def windowed(seed: int, size: float, gap: float) -> Trial:
    """A check whose equations leave three times the noise, and whose windows are off by so much."""
    draw = np.random.default_rng(seed)
    by_window = size * draw.uniform(0.9, 1.1, size=24)
    shot: Any = SimpleNamespace(by_window=by_window, misfit=50.0 * by_window, gap=gap)
    return Trial(shot, 3.0 * draw.chisquare(100, size=24), np.full(24, 100.0))


@pytest.mark.parametrize(
    ("amplitude", "less", "gap", "named"),
    [(2e-6, 0.7, 1.2, True), (2e-6, 0.7, 2.1, False), (2e-6, 0.995, 1.9, False), (2e-4, 0.995, 1.9, True)],
)
def test_an_error_of_less_than_a_count_is_wanted_by_windows_alone(
    amplitude: float, less: float, gap: float, named: bool
) -> None:
    """They must surely be less off, and in all: a filter's error beside backlash looks like an error of position."""
    effect = fd.effects.KinematicError("elbow", amplitude=amplitude, harmonic=1.0, phase=0.0)
    now, trial = windowed(0, 2.0, 2.0), windowed(0, 2.0 * less, gap)
    assert confirmed(now, fitted(None, 5000.0), trial, fitted(effect, 4000.0)) is named


@pytest.mark.parametrize(
    ("struck", "drop", "named"),
    [(10.0, 1000.0, True), (10.0, 50.0, False), (100.0, 1000.0, False)],
    ids=["taken", "doubtful in the fit", "half of it left"],
)
def test_what_one_window_shows_is_wanted_where_it_is_taken(struck: float, drop: float, named: bool) -> None:
    """An end stop that is met in one window of 24, which without it is off by 200; the others say next to nothing."""
    effect = fd.effects.EndStop("elbow", lower=-np.inf, upper=1.0, stiffness=1e3, damping=1.0)
    draw = np.random.default_rng(0)
    rows, one = 3.0 * draw.chisquare(100, size=24), np.eye(24)[5]
    usual = draw.uniform(0.9, 1.1, size=24)

    def trial(by_window: Any) -> Trial:
        gap = float(np.sqrt((by_window**2).mean()))
        shot: Any = SimpleNamespace(by_window=by_window, misfit=50.0 * by_window, gap=gap)
        return Trial(shot, rows, np.full(24, 100.0))

    now = trial(usual + 200.0 * one)
    after = trial(usual * draw.uniform(0.98, 1.01, size=24) + struck * one)
    assert confirmed(now, fitted(None, 5000.0), after, fitted(effect, 5000.0 - drop)) is named


LAWS = (fd.effects.TorqueOffset("elbow", offset=0.1), fd.effects.CoulombFriction("elbow", side="motor", level=0.1))
LEVEL = FileNumber("effects[0]", "level", 2.0, 0.03, "elbow")


def candidate(
    factor: float,
    std: float,
    effects: tuple[fd.effects.Effect, ...],
    number: FileNumber | None,
    rest: np.ndarray | None = None,
    *,
    made_up: bool = False,
) -> Candidate:
    """Of a fit in which a number of the file came to a factor, freed or not."""
    freed = frozenset() if number is None else frozenset({number})
    hypothesis = Hypothesis(two_link(TwoLink()), {LEVEL: factor}, freed, effects)
    rows = np.random.default_rng(len(effects)).standard_normal(50)
    regression = SimpleNamespace(y=rows, left=rows if rest is None else rest)
    fitted: Any = SimpleNamespace(
        hypothesis=hypothesis,
        factor_std=lambda: {LEVEL: std},
        std=dict,
        regression=regression,
        equations=SimpleNamespace(made_up=np.array([made_up, False])),
    )
    return Candidate(fitted, 100.0, 0.0, effects[-1] if number is None else None, number, 1000.0)


@pytest.mark.parametrize(("factor", "std", "rival"), [(0.84, 0.005, False), (0.95, 0.005, True), (0.84, 0.06, True)])
def test_a_number_that_is_wrong_with_both_laws_is_wrong(factor: float, std: float, rival: bool) -> None:
    """Another law is a rival of a wrong number only where the number stays in its tolerance beside it."""
    offset = candidate(factor, std, (fd.effects.TorqueOffset("elbow", offset=1e-3),), None)
    assert is_rival(offset, candidate(0.83, 0.005, (), LEVEL)) is rival
    assert is_rival(candidate(0.83, 0.005, (), LEVEL), offset)


@pytest.mark.parametrize(("priors", "left"), [(500.0, 0), (5.0, 1)])
def test_what_the_file_says_of_its_numbers_decides_between_laws(
    priors: float, left: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows that are alike keep a rival, but not one for which the file's numbers must bend far."""
    windows = np.random.default_rng(0).chisquare(300.0, size=60)
    named = candidate(1.0, 0.01, LAWS[:1], None)
    rival = candidate(1.0, 0.01, LAWS[1:], None, np.zeros(50))
    costs = {id(named): windows.sum(), id(rival): windows.sum() + priors}

    def asked(_search: Any, each: Candidate, _windows: Any, _like: Any = None) -> Refined:
        return Refined(each.fitted.hypothesis, np.zeros(3), costs[id(each)], 18_000, windows)

    monkeypatch.setattr(contest, "_asked", asked)
    nothing: Any = None
    stage = Stage(named.fitted, nothing, (Named(named, (rival,)),))
    assert len(contest.contested(nothing, stage, MANY).named[0].rivals) == left


@pytest.mark.parametrize(("made_up", "left"), [(True, 0), (False, 1)])
def test_windows_are_asked_where_equations_leave_rows_out(
    made_up: bool, left: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Laws that leave the same rows are one law by two names, unless an encoder is missing: rests are left out then."""
    windows = np.random.default_rng(0).chisquare(300.0, size=60)
    rows = np.zeros(50)
    named = candidate(1.0, 0.01, LAWS[:1], None, rows, made_up=made_up)
    rival = candidate(1.0, 0.01, LAWS[1:], None, rows, made_up=made_up)

    def asked(_search: Any, each: Candidate, some: Any, _like: Any = None) -> Refined:
        assert some == contest.WINDOWS
        off = windows * (1.0 if each is named else 1.3)
        return Refined(each.fitted.hypothesis, np.zeros(3), float(off.sum()), 18_000, off)

    monkeypatch.setattr(contest, "_asked", asked)
    nothing: Any = None
    stage = Stage(named.fitted, nothing, (Named(named, (rival,)),))
    assert len(contest.contested(nothing, stage, MANY).named[0].rivals) == left
