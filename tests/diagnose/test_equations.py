"""Residuals of the equations of motion, over motions that were computed without flexdyn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

import flexdyn as fd
from flexdyn.arrays import Array
from flexdyn.diagnose.data.channel_noise import encoder_noise
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.equations import columns
from flexdyn.diagnose.equations.covariance import SampleNoise, whitener
from flexdyn.diagnose.equations.equations import MODELS_KEPT, Equations
from flexdyn.diagnose.equations.noise import torque_noise
from flexdyn.diagnose.equations.sensor_columns import of_lag_shape
from flexdyn.diagnose.hypothesis import number_columns
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import two_link
from tests.diagnose.truths import ARM, JOINTS, RATE, Levels, two_link_motion, two_link_recording

BOTH, LINK, MOTOR = ("q", "theta"), ("q",), ("theta",)


def equations(levels: Levels, seed: int, signals: tuple[str, ...] = BOTH) -> Equations:
    """Of the true model along a recording with white noise."""
    states, tau = two_link_motion()
    draw = np.random.default_rng(seed)
    channels = {}
    for j, joint in enumerate(JOINTS):
        for signal, column in (("q", j), ("theta", 2 + j)):
            if signal in signals:
                channels[f"{signal}.{joint}"] = states[:, column] + levels.position * draw.standard_normal(len(tau))
        channels[f"tau.{joint}"] = tau[:, j] + levels.torque * draw.standard_normal(len(tau))
    model = two_link(ARM)
    data = measured(model, fd.Recording(np.arange(len(tau)) / RATE, channels))
    return Equations(model, (data,), Filters.of_rate(data.dt))


def noise_of(levels: Levels) -> SampleNoise:
    """The levels that the recordings were made with."""
    position, torque = np.full(2, levels.position), np.full(2, levels.torque)
    return SampleNoise(position, position, torque, np.zeros(2))


@pytest.mark.parametrize(("signals", "most"), [(BOTH, 1e-5), (LINK, 0.02)], ids=["both encoders", "link"])
def test_an_offset_of_an_encoder_is_seen_by_the_inertia_that_changes_with_position(
    signals: tuple[str, ...], most: float
) -> None:
    """On an arm that no gravity loads, by nothing else: its column is the change of the residual."""
    at = equations(Levels(1e-7, 1e-3), 0, signals)
    offset = fd.effects.SensorOffset("q.elbow", offset=1e-4)
    column, change = columns.of_effect(at, offset), at.change([*at.model.effects, offset])
    assert float(np.abs(change).max()) > 0.0
    assert np.linalg.norm(column - change) < most * np.linalg.norm(change)


@pytest.mark.parametrize("signals", [BOTH, LINK, MOTOR], ids=["both encoders", "link", "motor"])
@pytest.mark.parametrize(
    "levels", [Levels(2e-5, 0.05), Levels(1e-6, 0.05), Levels(1e-4, 1e-3)], ids=["both", "torque noise", "sensor noise"]
)
def test_a_true_model_leaves_white_noise(signals: tuple[str, ...], levels: Levels) -> None:
    """Unit variance and no correlation: the noise's way through the filters is known exactly."""
    left = []
    for seed in range(4):
        at = equations(levels, seed, signals)
        white = whitener(at, noise_of(levels), np.zeros(len(at.residual), dtype=bool))
        left.append(white(at.residual))
    rows = np.concatenate(left)
    assert float(np.mean(rows**2)) == pytest.approx(1.0, abs=0.12)
    many = len(at.kinds)
    for lag in (1, many, 2 * many):
        assert abs(float(np.mean(rows[lag:] * rows[:-lag]))) < 0.1


def test_the_equations_are_those_that_are_measured() -> None:
    """Both encoders: motor and link apart; one: their sum."""
    assert equations(Levels(), 0).kinds == ((0, "motor"), (0, "link"), (1, "motor"), (1, "link"))
    assert equations(Levels(), 0, LINK).kinds == ((0, "total"), (1, "total"))


@pytest.mark.parametrize("signals", [BOTH, LINK, MOTOR], ids=["both encoders", "link", "motor"])
@pytest.mark.parametrize(
    "effect",
    [
        fd.effects.ViscousFriction("shoulder", side="link", coefficient=0.5),
        fd.effects.ViscousFriction("elbow", side="motor", coefficient=0.5),
        fd.effects.TorqueOffset("shoulder", offset=0.3),
        fd.effects.HardeningSpring("elbow", cubic=2e4),
        fd.effects.ParallelSpring("shoulder", stiffness=2.0, rest=0.2),
        fd.effects.JointCoupling("elbow", other="shoulder", coefficient=0.4),
    ],
    ids=lambda effect: str(effect.name),
)
def test_a_column_is_what_the_effect_changes(effect: fd.effects.Effect, signals: tuple[str, ...]) -> None:
    """The residual of the model with the effect, less that without it, whichever encoders there are.

    Friction that moves a made-up position does so to first order.
    """
    at = equations(Levels(1e-6, 1e-3), 0, signals)
    with_it = at.of(at.model.replace(effects=[*at.model.effects, effect]))
    change = with_it.residual - at.residual
    near = 0.05 if effect.name == "viscous_friction" and signals != BOTH else 1e-9
    assert np.linalg.norm(columns.of_effect(at, effect) - change) < near * np.linalg.norm(change)


@pytest.mark.parametrize("channel", ["q.elbow", "theta.elbow"])
@pytest.mark.parametrize(
    "spring",
    [
        fd.effects.SpringHysteresis("elbow", stiffness=600.0, width=0.004),
        fd.effects.HardeningSpring("elbow", cubic=5e7),
        fd.effects.LoadDependentFriction("elbow", side="motor", coefficient=0.2),
    ],
    ids=lambda effect: str(effect.name),
)
def test_an_encoders_error_bends_every_spring(spring: fd.effects.Effect, channel: str) -> None:
    """The column of an eccentricity is what it changes where a transmission has another law than its stiffness.

    Friction that takes a share of the spring's torque changes with it.
    """
    plain = equations(Levels(1e-6, 1e-3), 0, BOTH)
    at = plain.of(plain.model.replace(effects=[*plain.model.effects, spring]))
    wrong = fd.effects.EncoderEccentricity(channel, amplitude=1e-5, harmonic=2.0, phase=0.3)
    change = at.of(at.model.replace(effects=[*at.model.effects, wrong])).residual - at.residual
    assert np.linalg.norm(columns.of_effect(at, wrong) - change) < 0.01 * np.linalg.norm(change)
    stiffness_alone = columns.of_effect(plain, wrong)
    assert np.linalg.norm(stiffness_alone - change) > 0.05 * np.linalg.norm(change)


@pytest.mark.parametrize("signals", [BOTH, MOTOR], ids=["both encoders", "motor"])
def test_a_numbers_column_is_the_slope_of_the_residual(signals: tuple[str, ...]) -> None:
    """By central differences over the whole model, positions that are made up included."""
    at = equations(Levels(1e-6, 1e-3), 0, signals)
    numbers = file_numbers(at.model)
    for number, found in zip(numbers, number_columns.of_numbers(at, tuple(numbers)).T, strict=True):
        sides = [
            at.of(at.model.replace(effects=[*at.model.effects, number.error(1.0 + step)])).residual
            for step in (1e-3, -1e-3)
        ]
        slope = (sides[0] - sides[1]) / 2e-3
        near = 0.03 if signals == BOTH else 0.15  # made-up positions take no notice of the damper
        assert np.linalg.norm(found - slope) < near * np.linalg.norm(slope) + 1e-9, number


LAWS = (
    fd.effects.ViscousFriction("shoulder", side="motor", coefficient=0.4),
    fd.effects.PreslidingFriction("elbow", side="link", level=0.3, stiffness=60.0, damping=0.2),
    fd.effects.ParallelSpring("shoulder", stiffness=3.0, rest=0.2),
    fd.effects.LoadDependentFriction("elbow", side="motor", coefficient=0.05),
)
"""Laws of which all but the last stand alone in their equations; that one takes what the others make of the load."""


@pytest.mark.parametrize("signals", [BOTH, MOTOR, LINK], ids=["both encoders", "motor", "link"])
def test_a_laws_column_is_the_slope_of_the_residual(signals: tuple[str, ...]) -> None:
    """Of its numbers in the file and of its parameters beside it, by central differences over the whole model."""
    given = equations(Levels(1e-6, 1e-3), 0, signals)
    wrong = fd.effects.ParameterError("shoulder", parameter="damping", factor=1.1)
    at = given.of(given.model.replace(effects=[wrong, *LAWS]))
    numbers = [number for number in file_numbers(at.model) if number.of.startswith("effects")]
    assert len(numbers) == 7
    near = 2e-3 if signals == BOTH else 0.15  # a made-up position takes notice of forces to first order
    for number, found in zip(numbers, number_columns.of_numbers(at, tuple(numbers)).T, strict=True):
        sides = [
            at.of(at.model.replace(effects=[*at.model.effects, number.error(1.0 + step)])).residual
            for step in (1e-3, -1e-3)
        ]
        slope = (sides[0] - sides[1]) / 2e-3
        assert np.linalg.norm(found - slope) < near * np.linalg.norm(slope) + 1e-9, number
        law = next(each for each in LAWS if getattr(each, number.parameter, None) == number.value)
        by_value = (
            columns.of_parameter(at, law, number.parameter, number_columns.RELATIVE_NUMBER_STEP * number.value)
            * number.value
        )
        assert np.linalg.norm(found - by_value) < 1e-6 * np.linalg.norm(found), number


@pytest.mark.parametrize("signal", ["q", "theta"])
@pytest.mark.parametrize(("name", "step"), [("amplitude", 1e-5), ("phase", 1e-3)])
def test_a_sensors_column_is_the_slope_of_the_residual(signal: str, name: str, step: float) -> None:
    """By central differences of the whole model around an encoder's disc that is off its axis."""
    given = equations(Levels(1e-6, 1e-3), 0)
    disc = fd.effects.EncoderEccentricity(f"{signal}.shoulder", amplitude=1e-3, harmonic=3.0, phase=0.4)
    at = given.of(given.model.replace(effects=[*given.model.effects, disc]))
    sides = [disc.replace(**{name: getattr(disc, name) + way * step}) for way in (1.0, -1.0)]
    up, down = (at.of(at.model.replace(effects=[*given.model.effects, each])).residual for each in sides)
    slope, found = (up - down) / (2.0 * step), columns.of_parameter(at, disc, name, step)
    assert np.linalg.norm(found - slope) < 0.02 * np.linalg.norm(slope)


@pytest.mark.parametrize("signal", ["q", "theta", "tau"])
@pytest.mark.parametrize("delay", [1e-3, 12.2e-3])
def test_the_column_of_a_lag_is_the_slope_of_the_residual(signal: str, delay: float) -> None:
    """By central differences of the whole model, also where the lag is several samples long."""
    given = equations(Levels(1e-6, 1e-3), 0)
    lag = fd.effects.ChannelLag(f"{signal}.shoulder", delay=delay)
    at = given.of(given.model.replace(effects=[*given.model.effects, lag]))
    sides = [lag.replace(delay=delay + way * 1e-5) for way in (1.0, -1.0)]
    up, down = (at.of(at.model.replace(effects=[*given.model.effects, each])).residual for each in sides)
    slope, found = (up - down) / 2e-5, columns.of_parameter(at, lag, "delay", 1e-5)
    assert np.linalg.norm(found - slope) < (0.005 if signal == "tau" else 0.02) * np.linalg.norm(slope)


def test_a_lag_is_seen_as_it_is() -> None:
    """To first order, the column of a lag is the residual of a recording that lags, less that of one that does not."""
    model = two_link(ARM)
    true = two_link_recording(Levels(1e-9, 1e-9), 0)
    lag = fd.effects.ChannelLag("theta.shoulder", delay=5e-4)
    late = dict(true.channels) | {"theta.shoulder": lag.measured(true["theta.shoulder"], true.t)}
    filters = Filters.of_rate(1.0 / true.rate)
    before, after = (Equations(model, (measured(model, each),), filters) for each in (true, fd.Recording(true.t, late)))
    change = after.residual - before.residual
    predicted = -columns.of_effect(before, lag)  # the column takes a lag off that the model says is there
    inner = slice(40, -40)
    assert np.linalg.norm((predicted - change)[inner]) < 0.05 * np.linalg.norm(change[inner])


def test_a_low_pass_is_a_lag_of_another_shape() -> None:
    """Of a torque behind a low pass of first order, another delay leaves what the shape of the lag then explains."""
    late = 12e-3
    true = two_link_recording(Levels(1e-9, 1e-9), 0)
    share, first = -np.expm1(-1.0 / (true.rate * late)), true["tau.shoulder"][0]  # held from sample to sample
    passed = first + lfilter([0.0, share], [1.0, share - 1.0], true["tau.shoulder"] - first)
    seen = fd.Recording(true.t, dict(true.channels) | {"tau.shoulder": passed})
    lag = fd.effects.ChannelLag("tau.shoulder", delay=late)
    at = Equations(two_link(ARM, [lag]), (measured(two_link(ARM), seen),), Filters.of_rate(1.0 / true.rate))
    inner = slice(80, -80)
    left, slope = at.residual[inner], columns.of_parameter(at, lag, "delay", 1e-5)[inner]
    both = np.stack([slope, of_lag_shape(at, lag)[inner]], axis=1)
    by_delay, by_both = (_explained(left, each) for each in (both[:, :1], both))
    assert np.linalg.norm(by_both) < 0.1 * np.linalg.norm(by_delay)


def _explained(rows: Array, by: Array) -> Array:
    """What columns leave of rows."""
    return np.asarray(rows - by @ np.linalg.lstsq(by, rows, rcond=None)[0])


def test_noise_is_found_in_the_data() -> None:
    """Encoder steps exactly; the torque's noise from what the equations leave, within a tenth."""
    levels, model = Levels(2e-6, 0.05), two_link(ARM)
    data = measured(model, two_link_recording(levels, 1))
    at = Equations(model, (data,), Filters.of_rate(data.dt))
    mask = np.zeros(len(at.residual), dtype=bool)
    encoders = SampleNoise(encoder_noise(at.data, "q"), encoder_noise(at.data, "theta"), np.ones(2), np.zeros(2))
    np.testing.assert_allclose(encoders.q, levels.position, rtol=0.05)
    np.testing.assert_allclose(torque_noise(at, at.residual, mask, encoders), levels.torque, rtol=0.12)


@pytest.mark.parametrize(("offset", "shared"), [(1e-3, True), (0.5, False)])
def test_slopes_of_the_links_are_those_of_a_motion_that_is_near(offset: float, shared: bool) -> None:
    """They cost as much as the motion itself; beyond a hundredth of its range they are its own."""
    base = equations(Levels(), 0)
    seen = fd.effects.SensorOffset("q.elbow", offset=offset)
    there = base.of(base.model.replace(effects=[*base.model.effects, seen]))
    assert (there.motions[0].near is base.motions[0]) is shared
    alone = Equations(there.model, base.data, base.filters)
    assert alone.motions[0].near is None
    lag = fd.effects.ChannelLag("q.elbow", delay=1e-4)
    one, other = (columns.of_effect(each, lag, 1e-4) for each in (there, alone))
    np.testing.assert_allclose(one, other, atol=0.005 * np.abs(other).max())


def test_equations_of_the_last_models_are_kept() -> None:
    """Of equal models they are the same ones; of one that others followed they are computed anew, and are equal."""
    given = equations(Levels(1e-6, 1e-3), 0, MOTOR)
    levels = [0.1 * k for k in range(MODELS_KEPT + 1)]
    models = [given.model.replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=x)]) for x in levels]
    first, *others = (given.of(each) for each in models)
    assert given.of(models[-1].replace()) is others[-1]
    again = given.of(models[0])
    assert again is not first
    np.testing.assert_array_equal(again.residual, first.residual)


@pytest.mark.parametrize(("parameter", "shared"), [("stiffness", True), ("link_mass", False)])
def test_motions_are_shared_where_the_links_stay_what_they_are(parameter: str, shared: bool) -> None:
    """Also between models whose links were both corrected before; and a shared motion is the one it would be."""
    given = equations(Levels(1e-6, 0.01), 0)
    links = sorted({number.of for number in file_numbers(given.model) if number.joint is None})
    heavier = fd.effects.ParameterError(links[0], parameter="link_mass", factor=1.02)
    at = given.of(given.model.replace(effects=[heavier]))
    assert at.motions is not given.motions
    error = fd.effects.ParameterError(JOINTS[0] if shared else links[-1], parameter=parameter, factor=1.01)
    other = at.model.replace(effects=[heavier, error])
    assert (at.of(other).motions is at.motions) == shared
    alone = Equations(other, given.data, given.filters, at.of(other).stiffness)
    assert np.abs(at.of(other).residual - alone.residual).max() < 1e-9 * np.abs(alone.residual).max()
