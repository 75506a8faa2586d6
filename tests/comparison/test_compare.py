"""Comparing two motions: errors as they follow by hand, over the time both cover."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import repickled, slider

T = np.linspace(0.0, 2.0, 2001)[:-1]
"""Two whole turns of sin(2 pi t) at 1 kHz, the last sample not the first of the next turn."""


def sine(shift: float = 0.0, offset: float = 0.0, gain: float = 1.0) -> fd.Recording:
    """``gain sin(2 pi t + shift) + offset`` at two joints' encoders, the second twice as large."""
    wave = gain * np.sin(2.0 * math.pi * T + shift) + offset
    return fd.Recording(T, {"q.a": wave, "theta.b": 2.0 * wave})


def test_an_offset() -> None:
    """Of a constant offset RMS, largest error and bias are the offset; spread of a sine is its amplitude / sqrt 2."""
    row = fd.compare(sine(), sine(offset=-0.25))["q.a"]
    assert (row.rms, row.largest, row.bias) == pytest.approx((0.25, 0.25, -0.25), rel=1e-12)
    assert row.relative == pytest.approx(0.25 * math.sqrt(2.0), rel=1e-12)
    assert row.unit == "rad"


def test_a_shift() -> None:
    """Sines apart by phi differ by a sine of amplitude 2 sin(phi/2): RMS is that over sqrt 2, the bias is zero."""
    phi = 0.3
    found = fd.compare(sine(), sine(shift=phi))
    amplitude = 2.0 * math.sin(phi / 2.0)
    for channel, size in (("q.a", 1.0), ("theta.b", 2.0)):
        row = found[channel]
        assert row.rms == pytest.approx(size * amplitude / math.sqrt(2.0), rel=1e-12)
        assert row.largest == pytest.approx(size * amplitude, rel=1e-5)
        assert row.bias == pytest.approx(0.0, abs=1e-14)
        assert row.relative == pytest.approx(amplitude, rel=1e-12)
        # cos(2 pi t + phi / 2) is 1 or -1 there
        assert abs(math.cos(2.0 * math.pi * row.at + phi / 2.0)) == pytest.approx(1.0, abs=1e-5)


def test_a_motion_against_itself() -> None:
    """No error at all, and none either against its own samples on a grid that differs by rounding."""
    run = fd.simulate(fd.load_model("scara_two_link"), [0.1, 0.1], duration=0.3, rate=100)
    found = fd.compare(run, run)
    assert (found.first, found.second) == ("scara_two_link (1)", "scara_two_link (2)")
    assert len(found.rows) == 14
    assert not any(row.rms or row.largest or row.bias for row in found.rows)
    steps = np.where(T < 1.0, 1.0, -1.0)
    grid = np.cumsum(np.full(2000, 1e-3)) - 1e-3
    assert (grid != T).any()
    rounded = fd.compare(fd.Recording(grid, {"tau.a": steps}), fd.Recording(T, {"tau.a": steps}))
    assert rounded["tau.a"].largest == 0.0
    assert rounded.samples == 2000


def test_torque_is_held_and_positions_are_not() -> None:
    """Halfway between the samples 0 and 2 of the second a torque is still 0, a position 1."""
    first = fd.Recording([0.0, 0.5, 1.0, 1.5], {name: np.zeros(4) for name in ("tau.a", "tau_applied.a", "q.a")})
    second = fd.Recording([0.0, 1.0, 2.0], {name: [0.0, 2.0, 2.0] for name in ("tau.a", "tau_applied.a", "q.a")})
    found = fd.compare(first, second)
    for name, errors in (("tau.a", [0, 0, 2, 2]), ("tau_applied.a", [0, 0, 2, 2]), ("q.a", [0, 1, 2, 2])):
        assert found[name].rms == pytest.approx(math.sqrt(sum(e * e for e in errors) / 4), rel=1e-15)
        assert found[name].bias == sum(errors) / 4
        assert found[name].at == 1.0
        assert found[name].relative is None  # the first does not vary


def test_only_common_time_and_common_channels_count() -> None:
    """The first's samples in the overlap are compared; what one has alone is listed."""
    first = fd.Recording(np.arange(0.0, 5.0), {"q.a": np.arange(5.0), "q.b": np.zeros(5)})
    second = fd.Recording([1.5, 9.0], {"q.a": [1.5, 9.0], "v.a": [0.0, 0.0]})
    found = fd.compare(first, second)
    assert (found.start, found.end, found.samples) == (2.0, 4.0, 3)
    assert found["q.a"].largest < 1e-15
    assert (found.only_first, found.only_second) == (("q.b",), ("v.a",))
    window = fd.compare(first, second, start=2.5, end=4.5)
    assert (window.start, window.end, window.samples) == (3.0, 4.0, 2)


def test_the_rigid_limit_of_an_arm(tmp_path: Path) -> None:
    """A run against the file of another, by path: elastic and rigid differ, and the file is the run bit for bit."""
    model = fd.load_model("scara_two_link")
    elastic = fd.simulate(model, [0.1, 0.0], duration=0.5)
    rigid = fd.simulate(model.rigid(), [0.1, 0.0], duration=0.5)
    rigid.save(tmp_path / "rigid.h5")
    found = fd.compare(elastic, str(tmp_path / "rigid.h5"))
    error = rigid.q[:, 1] - elastic.q[:, 1]
    assert found["q.elbow"].rms == pytest.approx(float(np.sqrt(np.mean(error**2))), rel=1e-12)
    assert found["q.elbow"].largest == np.abs(error).max()
    assert not fd.compare(rigid, tmp_path / "rigid.h5")["q.elbow"].rms


def test_numbers_at_the_ends_of_what_doubles_hold() -> None:
    """Squares that would overflow or vanish do neither; numbers whose sum would are refused."""
    for size in (1e280, 1e-280):
        zero, wave = (fd.Recording(T, {"q.a": gain * size * np.sin(T)}) for gain in (0.0, 1.0))
        row = fd.compare(zero, wave)["q.a"]
        assert row.rms == pytest.approx(size * float(np.sqrt(np.mean(np.sin(T) ** 2))), rel=1e-12)
    huge = [fd.Recording([0.0, 1.0], {"q.a": [sign * 1.7e308] * 2}) for sign in (1.0, -1.0)]
    with pytest.raises(fd.InputError, match=r"q\.a: the numbers are too great to be compared, got 1\.7e\+308"):
        fd.compare(*huge)


def test_units(tmp_path: Path) -> None:
    """A prismatic joint's errors are in metres; a joint that is revolute in the other motion is refused."""
    run = fd.simulate(fd.FlexibleJointModel(slider(tmp_path)), [24.0], duration=0.1)
    plain = fd.Recording(run.t, {"q.lift": run.q[:, 0], "tau.lift": run.tau[:, 0]})
    assert [row.unit for row in fd.compare(run, plain).rows] == ["m", "N"]
    assert [row.unit for row in fd.compare(plain, run).rows] == ["m", "N"]
    turning = fd.Recording(run.t, {"q.lift": run.q[:, 0]}, meta={"units": {"q.lift": "rad"}}, name="turning")
    with pytest.raises(fd.InputError, match=r"q\.lift: the channel is in m in slider and in rad in turning"):
        fd.compare(run, turning)


def test_what_cannot_be_compared() -> None:
    """No common channel, no common time, an empty window, a channel that is not there: one line each."""
    one = fd.Recording([0.0, 1.0], {"q.a": [0.0, 1.0]}, name="one")
    with pytest.raises(fd.InputError, match=r"one and two have no channel in common; the one has q\.a; the other q\.b"):
        fd.compare(one, fd.Recording([0.0, 1.0], {"q.b": [0.0, 1.0]}, name="two"))
    with pytest.raises(fd.InputError, match=r"one goes from 0 to 1 s, two from 5 to 6 s: two samples are needed"):
        fd.compare(one, fd.Recording([5.0, 6.0], {"q.a": [0.0, 1.0]}, name="two"))
    with pytest.raises(fd.InputError, match=r"one.* has 1 samples in the time to be compared"):
        fd.compare(one, one, start=0.5)
    with pytest.raises(fd.InputError, match=r"q.e: no such common channel; did you mean 'q\.a'|known: q\.a"):
        fd.compare(one, one)["q.e"]
    with pytest.raises(fd.InputError, match="neither a run nor a recording, got 3; give what"):
        fd.compare(one, 3)


def test_a_comparison_is_data() -> None:
    """It pickles, is JSON by `to_dict`, and answers which channels it has."""
    found = fd.compare(sine(), sine(offset=0.1))
    again = repickled(found)
    assert again == found
    document = json.loads(json.dumps(found.to_dict()))
    assert document["channels"][1]["channel"] == "theta.b"
    assert document["channels"][1]["rms"] == found["theta.b"].rms
    assert document["samples"] == 2000
    assert "q.a" in found
    assert "q.z" not in found


def test_the_picture_shows_the_numbers(tmp_path: Path) -> None:
    """A bar of every channel is as long as its RMS, its mark at the largest error; the worst channel stands below."""
    found = fd.compare(sine(), sine(shift=0.3))
    picture = found.plot(tmp_path / "errors.svg")
    bars, above, beneath = picture.panels
    assert [(bar.name, bar.length, bar.mark) for bar in bars.bars] == [
        (r.channel, r.rms, r.largest) for r in found.rows
    ]
    assert bars.across == "error [rad]"
    assert above.title.startswith("theta.b")
    np.testing.assert_array_equal(beneath.curves[0].y, sine(shift=0.3)["theta.b"] - sine()["theta.b"])
    drawn = [trace for trace in picture.plotly().data if trace.type == "bar"]
    assert list(drawn[0].x) == [row.rms for row in found.rows]
    assert len(fd.compare(sine(), sine()).plot().panels) == 1  # nothing apart, nothing to show over time
    widths = [patch.get_width() for patch in picture.figure().axes[0].patches]
    assert widths == pytest.approx([row.rms for row in found.rows])


def test_a_picture_of_very_many_channels() -> None:
    """Of 60 channels in one unit the 28 with the greatest RMS are drawn, and the page says so."""
    t = np.linspace(0.0, 1.0, 30)
    first = fd.Recording(t, {f"q.j{j}": np.sin(t) for j in range(60)})
    second = fd.Recording(t, {f"q.j{j}": np.sin(t) + 0.01 * j for j in range(60)})
    picture = fd.compare(first, second).plot()
    assert [bar.name for bar in picture.panels[0].bars] == [f"q.j{j}" for j in range(32, 60)]
    assert any("The 28 channels in rad of 60" in note for note in picture.notes)
