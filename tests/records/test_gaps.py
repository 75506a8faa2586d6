"""Gaps: told when a file is read, and respected by everything that comes after."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.errors import InputError
from flexdyn.plots.thinning import broken, outline
from flexdyn.records import Recording, RecordingWarning
from flexdyn.records.signals.gaps import apart_at_gaps, in_gaps
from tests.diagnose import slides
from tests.diagnose.stopped import taken_by_a_diagnosis

RATE = 100.0
WHOLE = np.arange(1000) / RATE
HOLE = (WHOLE < 4.0) | (WHOLE >= 6.5)


def swing(t: np.ndarray = WHOLE[HOLE], name: str = "log") -> Recording:
    """A motion of both joints of the paper's arm."""
    columns = {f"{signal}.{joint}": np.sin(2.0 * t) for joint in ("shoulder", "elbow") for signal in ("q", "tau")}
    return Recording(t, columns, name=name)


def test_a_gap_is_told_when_it_is_read(tmp_path: Path) -> None:
    """How long, from when on, how many; the recording knows it; a whole one says nothing; samples are untouched."""
    fd.write_recording(swing(), tmp_path / "log.h5")
    with pytest.warns(
        RecordingWarning, match=r"log\.h5: a gap in the data: 2\.51 s from t = 3\.99 s on; nothing is filled"
    ):
        rec = fd.read_recording(tmp_path / "log.h5")
    assert rec.gaps == ((3.99, 6.5),)
    assert rec == swing()
    fd.write_recording(swing(WHOLE), tmp_path / "whole.h5")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fd.read_recording(tmp_path / "whole.h5").gaps == ()


def test_dropped_rows_are_a_gap_too(tmp_path: Path) -> None:
    """Empty cells that a repair drops."""
    column = [f"{t:.2f},{'' if 4 <= t < 4.5 else t}" for t in WHOLE]
    (tmp_path / "log.csv").write_text("\n".join(["t,q.a", *column]) + "\n", encoding="utf-8")
    with pytest.warns(RecordingWarning, match=r"a gap in the data: 0\.51 s from t = 3\.99 s on"):
        fd.read_recording(tmp_path / "log.csv", repair=["drop_nan"])


def test_resampling_and_derivatives_refuse_to_bridge_it() -> None:
    """Both say what to do, which works."""
    with pytest.raises(InputError, match=r"a gap of 2\.51 s follows.*\.split\(gaps="):
        swing().resample(rate=50.0)
    with pytest.raises(InputError, match="the samples are not uniform"):
        fd.derivatives(swing())
    assert [piece.duration for piece in swing().split(gaps=0.1)] == pytest.approx([3.99, 3.49])


def test_a_comparison_leaves_it_out() -> None:
    """Whichever of the two has it; a straight line across it would have been off by much more."""
    whole, holed = swing(WHOLE, "whole"), swing(name="holed")
    found = fd.compare(whole, holed)
    assert found["q.elbow"].largest == 0.0
    assert found.samples == len(holed)
    assert fd.compare(holed, whole)["q.elbow"].largest == 0.0
    crossed = np.interp(WHOLE, holed.t, holed["q.elbow"])
    assert np.abs(crossed - whole["q.elbow"]).max() > 1.0
    inside = Recording(np.array([4.5, 5.0, 5.5]), {"q.elbow": [0.0, 0.0, 0.0]}, name="inside")
    with pytest.raises(InputError, match=r"q\.elbow: holed has a gap there"):
        fd.compare(inside, holed)


def test_curves_break_off() -> None:
    """A NaN in the middle of the gap, the samples at its ends kept; also where a long curve is thinned."""
    rec = swing()
    picture = fd.plot(rec, swing(WHOLE, "whole"))
    curves = [curve for panel in picture.panels for curve in panel.curves if curve.group == "log"]
    assert curves
    for curve in curves:
        (at,) = np.flatnonzero(np.isnan(curve.y))
        assert curve.x[at - 1] == 3.99
        assert curve.x[at + 1] == 6.5
        assert np.isfinite(curve.y).sum() == len(rec)
    assert all(np.isfinite(panel.y_range).all() for panel in picture.panels)
    t = np.concatenate([np.arange(40000), 60000 + np.arange(40000)]) * 1e-3
    x, y = broken(t, np.sin(t), outline(t, np.sin(t)))
    (at,) = np.flatnonzero(np.isnan(y))
    assert (x[at - 1], x[at + 1]) == (39.999, 60.0)


def test_a_diagnosis_takes_the_pieces(tmp_path: Path) -> None:
    """As recordings of their own; pieces shorter than a second are left out, which is said."""
    whole = slides.recording(lambda v: 0.0, seconds=8.0)

    def rows(keep: np.ndarray, name: str) -> Recording:
        channels = {key: x[keep] for key, x in whole.channels.items()}
        return Recording(whole.t[keep], channels, meta=whole.meta, name=name)

    log, check = rows((whole.t < 4.0) | (whole.t >= 4.5), "log"), rows(whole.t >= 0.0, "check")
    assert taken_by_a_diagnosis(slides.model(tmp_path), log, check) == [("log", 0.0, 2000), ("log", 4.5, 1750)]
    short = swing(WHOLE[(WHOLE < 4.0) | (WHOLE >= 9.5)])
    with pytest.warns(RecordingWarning, match=r"log: 1 of 2 pieces between gaps are shorter than 1 s and left out"):
        assert [each.duration for each in apart_at_gaps([short])] == [3.99]


def test_times_inside_a_gap() -> None:
    """Its ends belong to what was recorded."""
    t = swing().t
    np.testing.assert_array_equal(in_gaps(t, np.array([3.0, 3.99, 4.0, 6.49, 6.5, 9.0])), [0, 0, 1, 1, 0, 0])
    assert not in_gaps(WHOLE, WHOLE).any()


def test_a_command_with_a_gap_says_so() -> None:
    """Nobody knows the torque of that time: it is held, and the run's notes say it; likewise a reference."""
    model = fd.load_model("scara_two_link")
    run = fd.simulate(model, swing(), rate=100)
    assert "the command has a gap of 2.51 s from t = 3.99 s on, over which its last value is held" in run.notes
    assert not [note for note in fd.simulate(model, swing(WHOLE), rate=100).notes if "gap" in note]
    tracked = fd.simulate(model, fd.PD(swing(), kp=5.0, kd=1.0), rate=100)
    assert "the reference has a gap of 2.51 s from t = 3.99 s on, over which it is interpolated" in tracked.notes


def test_maps_of_a_diagnosis_one_for_all_or_one_for_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the order of FIT and CHECK; another number is refused before anything is read."""
    files = []
    for k, name in enumerate(("a", "b")):
        files.append(tmp_path / f"{name}.csv")
        fd.write_recording(Recording(WHOLE, {f"x{k}": WHOLE, f"i{k}": WHOLE}), files[-1])
        text = f"{{flexdyn_map: 1, channels: {{q.elbow: x{k}, tau.elbow: i{k}}}}}"
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    call = ["diagnose", "scara_two_link", str(files[0]), "--check", str(files[1]), "-o", str(tmp_path / "out")]
    maps = ["--map", str(tmp_path / "a.yaml"), "--map", str(tmp_path / "b.yaml")]
    assert main([*call, *maps]) == 2
    assert "tau.shoulder: no torque of the joint was recorded" in capsys.readouterr().err, "both were read"
    assert main([*call, *maps[:2]]) == 2
    assert "b.csv" in (told := capsys.readouterr().err)
    assert "no such column" in told
    assert main([*call, *maps, *maps[:2]]) == 2
    assert "--map: 3 maps for 2 recordings; give one for all, or one for each" in capsys.readouterr().err
