"""Sensor effects: what is recorded, against NumPy; the run itself stays true."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import flexdyn as fd
from flexdyn.effects import ChannelLag, EncoderEccentricity, SensorEffect, SensorGain, SensorOffset, measure, recovered
from tests.arms import unlisted
from tests.effects.arms import ELASTIC, model_of

RNG = np.random.default_rng(5)
T = np.sort(RNG.uniform(0.0, 2.0, 200))
X = RNG.normal(0.0, 1.5, 200)


@given(st.floats(-5, 5), st.floats(-3, 3), st.floats(-3, 3))
def test_laws_of_the_value(first: float, second: float, third: float) -> None:
    """Offset, gain and eccentricity act sample by sample."""
    np.testing.assert_allclose(SensorOffset("v.j", offset=first).measured(X, T), X + first, rtol=1e-15)
    np.testing.assert_allclose(SensorGain("v.j", gain=first).measured(X, T), (1 + first) * X, rtol=1e-14, atol=1e-14)
    disc = EncoderEccentricity("theta.j", amplitude=first, harmonic=second, phase=third)
    np.testing.assert_allclose(disc.measured(X, T), X + first * np.sin(second * X + third), rtol=1e-15)


@pytest.mark.parametrize("delay", [1e-4, 0.0137, 0.4])
def test_a_lag_reads_the_channel_between_its_samples(delay: float) -> None:
    """Of a line it gives the line; before the first sample has arrived it holds that."""
    line = 3.0 * T - 1.0
    late = ChannelLag("q.j", delay=delay).measured(line, T)
    np.testing.assert_allclose(late, np.where(T - delay < T[0], line[0], 3.0 * (T - delay) - 1.0), rtol=1e-12)


def test_a_lag_of_a_held_torque_keeps_its_steps() -> None:
    """Torque asked for is held from one sample to the next, also when late; rounding of t - delay loses no sample."""
    t = np.arange(500) / 1000.0
    x = np.random.default_rng(0).normal(size=500)
    np.testing.assert_array_equal(ChannelLag("tau.j", delay=0.007).measured(x, t)[7:], x[:-7])
    np.testing.assert_array_equal(ChannelLag("tau.j", delay=0.0075).measured(x, t)[8:], x[:-8])
    np.testing.assert_array_equal(ChannelLag("tau.j", delay=0.007).measured(x, t)[:8], np.full(8, x[0]))


def test_several_on_one_channel() -> None:
    """Lag, eccentricity, gain, offset in this order; those of one kind add."""
    effects: list[SensorEffect] = [
        SensorOffset("q.j", offset=0.3),
        SensorGain("q.j", gain=0.1),
        ChannelLag("q.j", delay=0.02),
        EncoderEccentricity("q.j", amplitude=0.2, harmonic=2.0, phase=0.1),
        SensorGain("q.j", gain=-0.4),
        SensorOffset("q.j", offset=0.5),
        ChannelLag("q.j", delay=0.01),
        EncoderEccentricity("q.j", amplitude=0.1, phase=0.7),
    ]
    late = np.interp(T - 0.03, T, X)
    bent = late + 0.2 * np.sin(2.0 * late + 0.1) + 0.1 * np.sin(late + 0.7)
    np.testing.assert_allclose(measure(effects, X, T), 0.7 * bent + 0.8, atol=1e-13)
    np.testing.assert_allclose(measure(effects[::-1], X, T), measure(effects, X, T), atol=1e-13)


@unlisted
class Saturation(SensorEffect):
    """A user's own: the sensor ends at a limit."""

    def measured(self, x: Any, t: Any) -> Any:
        """Clipped."""
        return np.clip(x, -0.5, 0.5)


def test_a_users_own_sensor_effect_comes_last() -> None:
    """It sees what flexdyn's own make of the channel."""
    own = [Saturation("q.j"), SensorGain("q.j", gain=1.0)]
    np.testing.assert_array_equal(measure(own, X, T), np.clip(X + X, -0.5, 0.5))


@unlisted
class Bent(SensorEffect):
    """A user's own: a scale that is not even."""

    def error(self, x: Any) -> Any:
        """Of the third order."""
        return 0.1 * x**3


def test_what_a_sensor_did_is_undone() -> None:
    """All but the lag: gains and offsets add, discs see one angle, and a user's own law is inverted by itself."""
    effects: list[SensorEffect] = [
        SensorOffset("q.j", offset=0.3),
        Bent("q.j"),
        SensorGain("q.j", gain=-0.4),
        EncoderEccentricity("q.j", amplitude=0.02, harmonic=2.0, phase=0.1),
        SensorGain("q.j", gain=0.1),
        EncoderEccentricity("q.j", amplitude=0.01, phase=0.7),
    ]
    np.testing.assert_allclose(recovered(effects, measure(effects, X, T), T), X, atol=1e-12)
    late = [*effects, ChannelLag("q.j", delay=0.01)]
    np.testing.assert_array_equal(recovered(late, X, T), recovered(effects, X, T))
    np.testing.assert_array_equal(recovered([], X, T), X)


EFFECTS: list[SensorEffect] = [
    SensorOffset("q.elbow", offset=0.25),
    ChannelLag("theta.shoulder", delay=0.01),
    SensorGain("tau_s.elbow", gain=-0.2),
]


def test_a_recording_shows_them_and_the_run_does_not() -> None:
    """Only the channels named change; the note says so; the motion is that of the model without them."""
    runs = [fd.simulate(model_of(ELASTIC, effects), [0.5, -0.3], 0.3, q0=[0.1, 0.2]) for effects in ([], EFFECTS)]
    for signal in ("q", "theta", "v", "omega", "tau", "tau_applied", "tau_s"):
        np.testing.assert_array_equal(getattr(runs[0], signal), getattr(runs[1], signal))
    true, measured = (run.to_recording() for run in runs)
    changed = {channel for channel in true.channels if not np.array_equal(true[channel], measured[channel])}
    assert changed == {"q.elbow", "theta.shoulder", "tau_s.elbow"}
    np.testing.assert_array_equal(measured["q.elbow"], runs[1].q[:, 1] + 0.25)
    np.testing.assert_allclose(measured["tau_s.elbow"], 0.8 * runs[1].tau_s[:, 1], rtol=1e-14)
    shifted = np.concatenate([np.full(10, runs[1].theta[0, 0]), runs[1].theta[:-10, 0]])
    np.testing.assert_allclose(measured["theta.shoulder"], shifted, atol=1e-12)
    assert "sensor_offset acts on the channel q.elbow" in measured.meta["notes"]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (
            {"channel": "elbow"},
            r"effects\[0\]\.sensor_offset\.channel: a channel is needed, got 'elbow'; write <signal>",
        ),
        ({"channel": 3}, r"effects\[0\]\.sensor_offset\.channel: a channel is needed, got 3"),
        ({"channel": "p.elbow"}, r"effects\[0\]\.channel: no such signal, got 'p\.elbow'; "),
        ({"channel": "temperature.elbow"}, r"effects\[0\]\.channel: no such signal"),
        (
            {"channel": "q.elbo"},
            r"effects\[0\]\.channel: the robot has no such joint, got 'q\.elbo'; did you mean 'elbow'",
        ),
        (
            {"effect": "encoder_eccentricity", "channel": "v.elbow", "amplitude": 0.1, "phase": 0.0},
            r"effects\[0\]\.encoder_eccentricity\.channel: the effect does not act on this signal.*q or theta",
        ),
    ],
)
def test_a_channel_that_is_not_there(entry: dict[str, Any], words: str) -> None:
    """One line that names the near miss."""
    whole = {"effect": "sensor_offset", "offset": 1.0} | entry
    if whole["effect"] != "sensor_offset":
        del whole["offset"]
    with pytest.raises(fd.InputError, match=f"^{words}"):
        model_of(ELASTIC, [whole])  # type: ignore[list-item]
