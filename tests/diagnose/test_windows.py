"""Cutting recordings into windows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.diagnose.shooting.windows import Windows
from tests.diagnose.truths import Levels, slider_model

LEVELS = Levels(1e-5, 0.01).noise(1)


def recording(t: np.ndarray, channel: str = "q.lift") -> fd.Recording:
    """A channel that counts the samples, so that every sample says where it came from."""
    units = {channel: "m", "tau.lift": "N"}
    return fd.Recording(t, {channel: np.arange(len(t), dtype=float), "tau.lift": 0 * t}, meta={"units": units})


@pytest.mark.parametrize("rate", [250.0, 1000.0, 1234.5, 4000.0])
def test_windows_are_half_a_second_at_any_rate(tmp_path: Path, rate: float) -> None:
    """They follow one another without a sample between them; the last partial one is dropped."""
    windows = Windows.of(slider_model(tmp_path), [recording(np.arange(int(2.3 * rate)) / rate)], LEVELS)
    assert len(windows) == 4
    assert windows.rows / rate == pytest.approx(0.5, abs=0.01)
    assert windows.rows == windows.block * windows.blocks
    seen = windows.measured[:, :, 0]
    np.testing.assert_array_equal(seen.ravel(), np.arange(seen.size))


def test_no_window_crosses_a_gap(tmp_path: Path) -> None:
    """A clock that stood still for 20 ms ends one stretch and begins the next."""
    t = np.arange(1600) / 1000.0
    t[700:] += 0.02
    windows = Windows.of(slider_model(tmp_path), [recording(t)], LEVELS)
    assert windows.places[:, 1].tolist() == [0, 700]
    assert np.diff(windows.t, axis=1).max() < 0.0011


def test_windows_of_several_recordings_keep_their_place(tmp_path: Path) -> None:
    """Each says which recording it is from, and its times are of that recording."""
    first, second = recording(np.arange(600) / 1000.0), recording(5.0 + np.arange(1100) / 1000.0)
    windows = Windows.of(slider_model(tmp_path), [first, second], LEVELS)
    assert windows.places.tolist() == [[0, 0], [1, 0], [1, 500]]
    np.testing.assert_allclose(windows.t[:, 0], [0.0, 5.0, 5.5])


def test_a_model_with_a_delay_is_compared_over_the_same_windows(tmp_path: Path) -> None:
    """It does not know the torques before a recording: windows that begin there are left out, if there are others."""
    model = slider_model(tmp_path)
    late = model.replace(effects=[fd.effects.CommandDelay("lift", delay=0.02)])
    whole, short = recording(np.arange(1600) / 1000.0), recording(np.arange(600) / 1000.0)
    windows = Windows.of(model, [whole, short], LEVELS)
    assert Shooter(late, windows).torques_known.tolist() == [False, True, True, False]
    later = windows.preceded()
    assert later.places.tolist() == [[0, 500], [0, 1000]]
    assert Shooter(late, later).torques_known.all()
    assert len(Windows.of(model, [short], LEVELS).preceded()) == 1


def test_a_channel_that_one_recording_lacks_is_not_measured_there(tmp_path: Path) -> None:
    """Its samples are NaN, which later counts as nothing."""
    first, second = recording(np.arange(600) / 1000.0), recording(np.arange(600) / 1000.0, "theta.lift")
    windows = Windows.of(slider_model(tmp_path), [first, second], LEVELS)
    assert windows.channels == ("q.lift", "theta.lift")
    assert np.isnan(windows.measured[0, :, 1]).all()
    assert np.isfinite(windows.measured[1, :, 1]).all()


def test_long_recordings_are_thinned_out_evenly(tmp_path: Path) -> None:
    """Memory stays bounded, and both ends stay in."""
    windows = Windows.of(slider_model(tmp_path), [recording(np.arange(20_000) / 1000.0)], LEVELS, most=5)
    assert windows.places[:, 1].tolist() == [0, 5000, 10000, 14500, 19500]


def test_some_of_the_windows_are_those_and_no_others(tmp_path: Path) -> None:
    """The first, the last and every second one between; more than there are is all of them."""
    windows = Windows.of(slider_model(tmp_path), [recording(np.arange(4500) / 1000.0)], LEVELS)
    some = windows.thinned(5)
    assert some.places[:, 1].tolist() == [0, 1000, 2000, 3000, 4000]
    np.testing.assert_array_equal(some.measured, windows.measured[::2])
    np.testing.assert_array_equal(windows.thinned(20).places, windows.places)


@pytest.mark.parametrize(
    ("recordings", "line"),
    [
        ([recording(np.arange(400) / 1000.0)], "too short"),
        ([recording(np.arange(999) / 1000.0), recording(np.arange(999) / 500.0)], "different rates"),
        ([fd.Recording([0.0, 1.0], {"tau.lift": [0, 0]}, meta={"units": {"tau.lift": "N"}})], "no position"),
        ([], "no position"),
    ],
)
def test_what_cannot_be_cut_is_said_in_a_line(tmp_path: Path, recordings: list[fd.Recording], line: str) -> None:
    """Too short, two rates, nothing measured."""
    with pytest.raises(fd.InputError, match=line):
        Windows.of(slider_model(tmp_path), recordings, LEVELS)
