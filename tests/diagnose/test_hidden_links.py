"""Links that nobody measures, simulated along the motion of their motors, and how they respond to torques."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import flexdyn as fd
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.equations.covariance import whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.hidden_links import of_first_states
from flexdyn.diagnose.equations.response import LinkResponse
from flexdyn.diagnose.experiment.apart import Known, space_along
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.linear import linearised
from flexdyn.diagnose.hypothesis.prepared import MOST_SIMULATED, behind_motors, prepared, recorded_noise
from flexdyn.diagnose.hypothesis.unweighted import Unweighted
from flexdyn.diagnose.hypothesis.workspace import Workspace, beginning_as, weighed
from flexdyn.diagnose.inference.posterior import posterior
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE, one_after_the_other

Array = NDArray[np.float64]
RINGING = dataclasses.replace(ARM, stiffness=(4000.0, 3000.0), damping=(2.0, 1.5))
FINE, COARSE = 1e-7, 2e-5
"""Standard deviations of encoders [rad]."""


@cache
def _swept(seconds: float = 8.0) -> tuple[Array, Array]:
    """States of RINGING with the elbow's motor stuck, then the shoulder's, and the torques; steps make links ring."""
    t = np.arange(round(seconds * RATE)) / RATE
    first, idle = t < 0.5 * seconds, 1.7 * np.sin(9.0 * t)
    jerks = 2.0 * np.sign(np.sin(2.5 * t))
    tau = np.stack([np.where(first, jerks, idle), np.where(first, idle, 0.5 * jerks)], axis=1)
    return one_after_the_other(RINGING, tau), tau


def _recorded(step: float, stop: int | None = None, start: int = 0) -> tuple[fd.FlexibleJointModel, Measured]:
    states, tau = (x[start:stop] for x in _swept())
    draw = np.random.default_rng(1)
    channels = {}
    for j, joint in enumerate(JOINTS):
        channels[f"theta.{joint}"] = np.sqrt(12.0) * step * np.round(states[:, 2 + j] / (np.sqrt(12.0) * step))
        channels[f"tau.{joint}"] = tau[:, j] + 0.01 * draw.standard_normal(len(tau))
    model = two_link(RINGING)
    return model, measured(model, fd.Recording(np.arange(len(tau)) / RATE, channels))


def _weighed(model: fd.FlexibleJointModel, data: Measured, *, simulated: bool) -> Workspace:
    at = Equations(model, (data,), Filters.of_rate(data.dt), quasi_static=not simulated, simulated=simulated)
    return weighed(Unweighted.of(at, recorded_noise((data,)), file_numbers(model)))


def test_a_link_that_rings_behind_a_resting_motor_leaves_noise() -> None:
    """The record begins in the middle of the motion: offsets and first states are fitted."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    work = _weighed(model, data, simulated=True)
    used = ~work.whiten.mask.reshape(-1, 2)[:, 0]
    assert used.sum() > 50
    assert np.sqrt(np.mean(work.white(work.equations.residual).reshape(-1, 2)[used, 0] ** 2)) < 1.3


def test_a_ringing_link_tells_its_stiffness() -> None:
    """One that is taken to follow its load without delay has rows that hardly know of it."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    stiffness = [number.parameter for number in file_numbers(model)].index("stiffness")
    told, hidden = (_weighed(model, data, simulated=each).numbers[:, stiffness] for each in (True, False))
    assert np.linalg.norm(told) > 100.0 * np.linalg.norm(hidden)


def test_links_begin_as_the_record_says() -> None:
    """A record from the middle of the motion, where links ring: from rest their simulation would ring otherwise."""
    model, data = _recorded(FINE, start=round(1.0 * RATE), stop=round(4.0 * RATE))
    at = Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)
    _, start = prepared(model, (data,))
    bare = Unweighted.of(at, recorded_noise((data,)), start.factors)
    begun = beginning_as(bare, start)
    used = ~(bare.mask | begun.mask)
    left, more = (np.linalg.norm(each.equations.residual[used]) for each in (begun, bare))
    assert left < 0.1 * more
    again = weighed(begun).first_states(begun.equations.residual)
    first = weighed(bare).first_states(bare.equations.residual)
    assert np.abs(again[::2]).max() < 0.2 * np.abs(first[::2]).max()  # deflections


@pytest.mark.parametrize(("step", "simulated"), [(FINE, True), (COARSE, False)])
def test_the_encoders_noise_decides(step: float, simulated: bool) -> None:
    """Coarse encoders would make simulated links vibrate by more than all other noise."""
    bare, start = prepared(*_of_one(_recorded(step, stop=round(4.0 * RATE))))
    behind = behind_motors(bare, start)
    assert (behind is not None) == simulated
    if behind is not None:
        assert (behind.equations.simulated, behind.equations.quasi_static) == (True, False)


def test_beside_a_motor_that_reverses_all_the_time_links_are_simulated() -> None:
    """The position that its torque tells is unknown at every reversal, and all equations contain it."""
    t, draw = np.arange(round(4.0 * RATE)) / RATE, np.random.default_rng(2)
    way = {"shoulder": 0.01 * np.sin(2.0 * math.pi * 12.0 * t), "elbow": 0.5 * t + 0.2 * np.sin(1.3 * t)}
    channels = {f"theta.{joint}": x + FINE * draw.standard_normal(len(t)) for joint, x in way.items()}
    channels |= {f"tau.{joint}": 0.01 * draw.standard_normal(len(t)) for joint in JOINTS}
    model = two_link(RINGING)
    bare, _ = prepared(model, (measured(model, fd.Recording(t, channels)),))
    assert bare.equations.simulated
    used = ~bare.mask.reshape(-1, 2)
    assert not used[:, 0].any()
    assert used[:, 1].sum() > 30


def _of_one(made: tuple[fd.FlexibleJointModel, Measured]) -> tuple[fd.FlexibleJointModel, tuple[Measured, ...]]:
    """A model and its only recording."""
    return made[0], (made[1],)


def test_what_computed_positions_hide_is_seen_behind_the_motors() -> None:
    """A fast ripple of the torque: most of it is behind the wide filter that computed positions need."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    ripple = fd.effects.TorqueRipple("shoulder", amplitude=0.05, harmonic=60.0, phase=0.4)
    tau = data.tau.copy()
    tau[:, 0] -= ripple.amplitude * np.sin(ripple.harmonic * data.theta[:, 0] + ripple.phase)
    found = posterior(*prepared(model, (dataclasses.replace(data, tau=tau),)))
    assert found.bare.equations.simulated
    kinds = [found.space.candidates[c].kind for c, _ in found.best]
    assert kinds == ["torque_ripple"]


def test_a_ring_that_computed_positions_lack_is_no_effect() -> None:
    """Links that follow their load do not ring; those behind their motors do, and explain all without any effect."""
    found = posterior(*prepared(*_of_one(_recorded(FINE, stop=round(4.0 * RATE)))))
    assert found.bare.equations.simulated
    assert not found.best


@pytest.mark.slow
def test_where_simulated_links_are_farther_off_they_do_not_count() -> None:
    """A brake that closes at once, in the middle of the record, is no motion that a spline through samples holds."""
    found = posterior(*prepared(*_of_one(_recorded(FINE))))
    assert found.bare.equations.quasi_static


def test_first_states_of_a_record_tell_nothing_about_another_motion() -> None:
    """What is known of the numbers has the columns of equations along a new motion, with the first states free."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    work = _weighed(model, data, simulated=True)
    start = prepared(model, (data,))[1]
    made = fit(start, work, steps=1)
    known, other = Known.of(made), space_along(work, start.factors, data)
    assert known.root.shape[1] == linearised(start, other).regression.X.shape[1]
    whole = made.regression.with_priors
    numbers = len(start.factors)
    spread = np.linalg.inv(whole.T @ whole)[:numbers, :numbers]
    mine = np.linalg.inv(known.root.T @ known.root)[:numbers, :numbers] / max(1.0, made.reduced)
    np.testing.assert_allclose(np.sqrt(np.diag(mine)), np.sqrt(np.diag(spread)), rtol=1e-3)


def test_links_of_a_long_record_are_not_simulated() -> None:
    """Every candidate would simulate all of it again."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    many = np.arange(MOST_SIMULATED // 2 + 100) % len(data.t)
    long = dataclasses.replace(
        data,
        t=np.arange(len(many)) / RATE,
        **{signal: getattr(data, signal)[many] for signal in ("q", "theta", "tau", "tau_s")},
    )
    bare, start = prepared(model, (long,))
    assert bare.equations.quasi_static
    assert behind_motors(bare, start) is None


def test_a_column_is_what_the_law_changes() -> None:
    """Of a harder spring behind a motor, against the equations with it, for a small one, but for other first states."""
    model, data = _recorded(FINE, stop=round(4.0 * RATE))
    at = Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)
    deflection = np.abs(at.motions[0].delta[:, 0]).max()
    harder = fd.effects.HardeningSpring("shoulder", cubic=1e-3 * RINGING.stiffness[0] / deflection**2)
    column = at.of_spring(0, harder)
    exact = at.of(model.replace(effects=[harder])).residual - at.residual
    assert np.linalg.norm(exact) > 0.0
    states, _ = of_first_states(at)
    column, exact = (each - states @ np.linalg.lstsq(states, each)[0] for each in (column, exact))
    assert np.linalg.norm(column - exact) < 0.1 * np.linalg.norm(exact)


def test_noise_of_encoders_makes_simulated_links_vibrate_as_predicted() -> None:
    """A motionless arm whose encoders are noisy: rows of all joints have unit variance."""
    draw, model = np.random.default_rng(3), two_link(RINGING)
    samples = round(20.0 * RATE)
    channels = {f"theta.{joint}": 0.3 + 1e-5 * draw.standard_normal(samples) for joint in JOINTS}
    channels |= {f"tau.{joint}": 1e-3 * draw.standard_normal(samples) for joint in JOINTS}
    data = measured(model, fd.Recording(np.arange(samples) / RATE, channels))
    at = Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)
    white = whitener(at, recorded_noise((data,)), np.zeros(len(at.residual), dtype=bool))(at.residual)
    late = white.reshape(-1, 2)[len(white) // 8 :]
    assert 0.7 < np.sqrt(np.mean(late**2)) < 1.3


def test_links_respond_as_masses_on_springs() -> None:
    """Against SciPy: two coupled links whose mass matrix changes, under smooth torques."""
    t = np.arange(3000) * 0.002
    (k1, k2), (d1, d2) = (4000.0, 11000.0), (4.0, 2.0)

    def mass(s: float) -> list[list[float]]:
        coupling = 0.4 + 0.1 * math.cos(s)
        return [[1.2 + 0.3 * math.sin(1.3 * s), coupling], [coupling, 0.5]]

    def torque(s: float) -> list[float]:
        return [20.0 * math.sin(6.0 * s) ** 3, 5.0 * math.sin(31.0 * s) ** 3]

    def rates(s: float, x: Array) -> list[float]:
        q1, q2, v1, v2 = x.tolist()  # plain floats: SciPy asks tens of thousands of times
        (m11, m12), (_, m22) = mass(s)
        tau1, tau2 = torque(s)
        r1, r2 = tau1 - d1 * v1 - k1 * q1, tau2 - d2 * v2 - k2 * q2
        determinant = m11 * m22 - m12 * m12
        return [v1, v2, (m22 * r1 - m12 * r2) / determinant, (m11 * r2 - m12 * r1) / determinant]

    whole = solve_ivp(rates, (0.0, t[-1]), np.zeros(4), "DOP853", t, rtol=1e-9, atol=1e-13)
    masses = np.array([mass(s) for s in t])
    springs, dampers = (np.tile(np.diag(each), (len(t), 1, 1)) for each in ([k1, k2], [d1, d2]))
    response = LinkResponse.of(masses, springs, dampers, 0.002)
    found = response(np.array([torque(s) for s in t]))
    assert np.abs(found - whole.y[:2].T).max() < 1e-3 * np.abs(found).max()


def test_a_spring_that_is_stiff_for_the_clock_follows_its_load() -> None:
    """Its vibration is far beyond what samples can hold."""
    t = np.arange(1000) * 0.01
    torque = np.sin(2.0 * t)[:, None] ** 3
    M, K, D = (np.full((1000, 1, 1), each) for each in (0.5, 1e6, 1e4))
    response = LinkResponse.of(M, K, D, 0.01)
    assert np.abs(response(torque) - torque / 1e6).max() < 0.05 / 1e6


def test_gravity_changes_the_frequency_of_a_vibration() -> None:
    """The arm hangs straight down behind motors at rest: ``(K + G - w^2 M) x = 0``, for fifty periods."""
    arm = dataclasses.replace(ARM, stiffness=(400.0, 300.0), damping=(0.0, 0.0), gravity=9.81)
    model, t = two_link(arm), np.arange(round(22.0 * RATE)) / RATE
    down = np.tile([-0.5 * math.pi, 0.0], (len(t), 1))
    channels = {f"theta.{joint}": down[:, j] for j, joint in enumerate(JOINTS)}
    channels |= {f"tau.{joint}": np.zeros(len(t)) for joint in JOINTS}
    data = measured(model, fd.Recording(t, channels))
    at = Equations(model, (data,), Filters.of_rate(data.dt), simulated=True)
    along = at.motions[0]
    M = at.links.mass_matrix(down[0])
    ahead, back = (at.links.bias(down[:2] + step * np.eye(2), np.zeros((2, 2))) for step in (1e-5, -1e-5))
    K = np.diag(arm.stiffness) + (ahead - back).T / 2e-5
    squares, shapes = eigh(K, M)
    assert np.sqrt(squares[0]) * t[-1] > 50.0 * 2.0 * math.pi
    assert np.abs(np.sqrt(eigh(np.diag(arm.stiffness), M)[0][0] / squares[0]) - 1.0) > 0.01
    free = at.response(along).free(shapes[:, 0], np.zeros(2))
    swings = np.cos(np.sqrt(squares[0]) * (along.t - along.t[0]))[:, None] * shapes[:, 0]
    assert np.abs(free - swings).max() < 0.05 * np.abs(swings).max()
