"""How many moments a page holds, and the factor that makes deflections visible."""

from __future__ import annotations

import math

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.viewer.motion import FASTEST, MOST_FRAMES, PlayedMotion, frame_times, frames_of, magnification
from flexdyn.viewer.show import SHOWN_ANGLE


def motion(t: np.ndarray) -> PlayedMotion:
    """One joint that stands still at these times."""
    return PlayedMotion("arm", t, np.zeros((len(t), 1)), np.full((len(t), 1), np.nan))


@pytest.mark.parametrize(
    ("duration", "samples", "frames"),
    [(5.0, 5001, 1201), (60.0, 60_001, MOST_FRAMES), (0.01, 3, 3), (3600.0, 3_600_001, MOST_FRAMES), (1.0, 2, 2)],
)
def test_the_number_of_frames_is_bounded(duration: float, samples: int, frames: int) -> None:
    """240 in a second, 3600 at most, never more than there are samples; first and last are kept."""
    times = frame_times(motion(np.linspace(2.0, 2.0 + duration, samples)))
    assert len(times) == frames
    assert (times[0], times[-1]) == (2.0, 2.0 + duration)
    assert np.diff(times) == pytest.approx(duration / (frames - 1))
    assert 1.0 / np.diff(times)[0] < FASTEST * 1.0001 or samples == frames


@pytest.mark.parametrize("largest", [1e-7, 3e-4, 0.002, 0.0123, 0.1, 0.3])
def test_the_largest_deflection_is_shown_at_about_25_degrees(largest: float) -> None:
    """With a factor of 1, 2 or 5 and zeros, the nearest there is."""
    factor = magnification(np.array([[0.0, -largest], [np.nan, 0.3 * largest]]), SHOWN_ANGLE)
    assert factor / 10 ** math.floor(math.log10(factor) + 1e-9) in (
        pytest.approx(1),
        pytest.approx(2),
        pytest.approx(5),
    )
    assert 15.0 < math.degrees(factor * largest) < 40.0


@pytest.mark.parametrize("deflection", [[0.0], [np.nan], [], [1e-30], [2.0]])
def test_nothing_is_made_smaller_nor_magnified_without_end(deflection: list[float]) -> None:
    """A factor of 1 where there is no deflection, none that is known, only rounding, or one large as it is."""
    assert magnification(np.array(deflection), SHOWN_ANGLE) == 1.0


def test_motions_that_never_meet_are_refused() -> None:
    """Clocks that differ, such as the time of day against zero."""
    later = motion(np.linspace(1e9, 1e9 + 1.0, 5))
    with pytest.raises(fd.InputError, match=r"spans 1000000000 to 1000000001 s.*with 0 to 1 s.*shift the clock"):
        frames_of(motion(np.linspace(0.0, 1.0, 5)), later)


def test_of_a_still_arm_and_a_moving_one_the_frames_are_those_of_the_moving_one() -> None:
    """Whichever is the first: the other one stands."""
    still, moving = motion(np.zeros(1)), motion(np.linspace(3.0, 4.0, 5))
    for frames in (frames_of(still, moving), frames_of(moving, still)):
        assert frames.ghost is not None
        assert frames.arm.t.tolist() == frames.ghost.t.tolist() == moving.t.tolist()
