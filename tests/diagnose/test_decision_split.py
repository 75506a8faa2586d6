"""Which samples are test data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.decision.split import moving, parts
from tests.diagnose.truths import Levels, slider_model, slider_recording

RATE = 250.0
T = np.arange(5000) / RATE
LEVELS = Levels(1e-5, 0.02)


def _recording(x: np.ndarray, start: float = 0.0) -> fd.Recording:
    made = slider_recording(x, np.sin(T), RATE, LEVELS, seed=1)
    return fd.Recording(start + made.t, made.channels, meta=made.meta, name="monday")


def test_the_last_fifth_of_what_moves_is_kept_for_the_test(tmp_path: Path) -> None:
    """The mass moves for 10 s and then rests for 10 s: the test data begin after 8 s of motion."""
    model, x = slider_model(tmp_path), np.where(T < 10.0, np.sin(3.0 * T), np.sin(30.0))
    (first,), (last,) = parts(model, [_recording(x, start=5.0)])
    assert last.recording.t[0] == pytest.approx(13.0, abs=0.2)
    np.testing.assert_array_equal(np.concatenate([first.recording.t, last.recording.t]), 5.0 + T)
    joined = np.concatenate([first.recording["q.lift"], last.recording["q.lift"]])
    np.testing.assert_array_equal(joined, _recording(x)["q.lift"])
    assert (first.role, last.role) == ("fit", "test")


def test_clocks_go_on_in_the_test_data(tmp_path: Path) -> None:
    """What changes with time since the start of the run, such as a warm-up, does not begin anew."""
    (first,), (last,) = parts(slider_model(tmp_path), [_recording(np.sin(3.0 * T), start=5.0)])
    assert first.data.t[0] == 0.0
    assert last.data.t[0] == pytest.approx(last.recording.t[0] - 5.0)
    assert len(first.data.t) + len(last.data.t) == len(T)


def test_with_recordings_to_check_nothing_is_withheld(tmp_path: Path) -> None:
    """All of the one is fitted, all of the other is tested on."""
    one, other = _recording(np.sin(3.0 * T)), _recording(np.cos(2.0 * T))
    fitted, tests = parts(slider_model(tmp_path), [one], [other])
    assert [each.recording for each in fitted] == [one]
    assert [each.recording for each in tests] == [other]


def test_noise_alone_does_not_move(tmp_path: Path) -> None:
    """A resting joint's encoder rattles."""
    model = slider_model(tmp_path)
    x = np.where(T < 10.0, 0.3, 0.3 + 0.01 * np.sin(T - 10.0))
    moves = moving(measured(model, _recording(x)))
    assert not moves[: int(9.8 * RATE)].any()
    assert moves[int(10.2 * RATE) :].mean() > 0.95


def test_sources_tell_spans_and_noise(tmp_path: Path) -> None:
    """Spans in the recording's own time, levels by channel."""
    model = slider_model(tmp_path)
    (first,), _ = parts(model, [_recording(np.sin(3.0 * T), start=5.0)])
    source = first.source(model.joint_names, LEVELS.noise(1))
    assert (source.file, source.role, source.start) == ("monday", "fit", 5.0)
    assert source.rate == pytest.approx(RATE)
    assert source.noise == {"q.lift": 1e-5, "tau.lift": 0.02}
