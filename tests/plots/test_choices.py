"""What is drawn of motions: windows, joints, views, saved runs; and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.plots.motions import MOST_VIEW_ROWS
from tests.plots.test_runs import curves, signals


@pytest.fixture(scope="module")
def run() -> fd.Run:
    """The two-link arm under a pulse that jumps, at 100 Hz: few enough points for Matplotlib to write every one."""
    pulse = fd.Samples([0.0, 0.3, 0.6], {"shoulder": [0.3, -0.3, 0.0], "elbow": [0.2, -0.2, 0.0]}, "hold")
    return fd.simulate(fd.load_model("scara_two_link"), pulse, duration=1.0, rate=100)


def test_a_window_of_time(run: fd.Run) -> None:
    """Only samples between start and end are drawn, both ends included; an empty window is refused."""
    drawn = curves(run.plot(start=0.2, end=0.5))
    assert np.array_equal(drawn["q.elbow"].x, run.t[20:51])
    assert np.array_equal(drawn["all of it"].y, run.energy.mechanical[20:51])
    with pytest.raises(fd.InputError, match=r"has 0 samples from 2 to 3 s; its samples go from 0 to 1 s"):
        run.plot(start=2.0, end=3.0)


def test_many_joints() -> None:
    """Of 30 joints a page of several views shows the first 8 and says so; one view shows all; names choose any."""
    t = np.linspace(0.0, 1.0, 20)
    rec = fd.Recording(t, {f"{signal}.j{j}": np.sin(t + j) for j in range(30) for signal in ("q", "tau")})
    page = fd.plot(rec)
    assert len({panel.title for panel in page.panels}) == MOST_VIEW_ROWS
    assert any("The first 8 of 30 joints" in note for note in page.notes)
    assert [panel.title for panel in fd.plot(rec, views="torques").panels] == [f"j{j}" for j in range(30)]
    assert {panel.title for panel in fd.plot(rec, joints=["j29", "j11"]).panels} == {"j29", "j11"}


def test_long_recordings_make_small_files_that_keep_the_peak(tmp_path: Path) -> None:
    """A million samples with one spike: the spike is drawn at its height, the page says so, the file stays small."""
    t = np.linspace(0.0, 1000.0, 1_000_000)
    q = np.sin(t)
    q[654_321] = 7.5
    picture = fd.plot(fd.Recording(t, {"q.axis": q}, name="long"), path=tmp_path / "long.svg")
    curve = curves(picture)["q.axis"]
    assert curve.y.max() == 7.5
    assert curve.x[np.argmax(curve.y)] == t[654_321]
    assert any("1000000 samples" in note for note in picture.notes)
    assert (tmp_path / "long.svg").stat().st_size < 400_000


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"views": "postions"}, r"views: no such view, got 'postions'; did you mean 'positions'\?"),
        ({"joints": ["elbo"]}, r"joints: no such joint, got 'elbo'; did you mean 'elbow'\?"),
        ({"views": "temperature"}, r"views: there is nothing to draw of temperature; the channels are q.shoulder, "),
        ({"path": "run.gif"}, r"run.gif: unknown suffix of a picture, got '.gif'; known: .png, .pdf, .svg, .html"),
        ({"views": []}, r"views: no view is chosen; known: positions"),
    ],
)
def test_what_cannot_be_drawn(run: fd.Run, choice: dict[str, Any], words: str) -> None:
    """One line that names what is wrong, with the near miss."""
    with pytest.raises(fd.InputError, match=words):
        run.plot(**choice)


def test_what_is_no_motion() -> None:
    """Nothing, something else, and a recording without any joint are refused."""
    with pytest.raises(fd.InputError, match="there is nothing to draw; give a run or a recording"):
        fd.plot()
    with pytest.raises(fd.InputError, match="neither a run nor a recording, got 3"):
        fd.plot(3)
    with pytest.raises(fd.InputError, match="has no signal of any joint; channels are named"):
        fd.plot(fd.Recording([0.0, 1.0], {"voltage": [0.0, 1.0]}))
    with pytest.raises(fd.InputError, match="beyond what can be drawn"):
        fd.plot(fd.Recording([0.0, 1.0], {"q.a": [-1.7e308, 1.7e308]}))


def test_motions_without_common_time(run: fd.Run) -> None:
    """They are drawn, without a residual, and the page says why."""
    later = fd.Recording([5.0, 6.0], {"q.elbow": [0.0, 1.0]}, name="later")
    picture = fd.plot(run, later, views="positions")
    assert any(
        "No residual, because there is no time in common with scara_two_link: later" in note for note in picture.notes
    )
    assert not [panel for panel in picture.panels if panel.up.startswith("residual")]


@pytest.mark.parametrize(("library", "suffix"), [("matplotlib", ".png"), ("plotly", ".html")])
def test_a_missing_library(
    run: fd.Run, library: str, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each renderer names its own library and the extra that brings it."""
    for name in [*sys.modules]:
        if name.split(".")[0] == library:
            monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(fd.MissingExtra, match=rf"{library} is not installed; .*flexdyn\[plot\]"):
        run.plot(tmp_path / f"run{suffix}")


def test_a_saved_run_tells_what_its_samples_hold(run: fd.Run, tmp_path: Path) -> None:
    """Energies of the file's states are the ledger's; the work of held torques too; and the rest is the losses."""
    run.save(tmp_path / "run.npz")
    run.save(tmp_path / "run.csv")
    ledger = run.energy
    for picture in (fd.plot(tmp_path / "run.npz"), fd.plot(tmp_path / "run.csv", model="scara_two_link")):
        assert "simulated" in picture.notes[0]
        assert len(picture.notes) == 1
        drawn = curves(picture)
        assert set(signals(run)) < set(drawn)
        np.testing.assert_allclose(drawn["all of it"].y, ledger.mechanical, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(drawn["kinetic"].y, ledger.kinetic, rtol=1e-12, atol=1e-15)
        supplied = ledger.supplied.sum(axis=1)
        np.testing.assert_allclose(drawn["supplied by the motors"].y, supplied, atol=1e-9)
        lost = sum(ledger.dissipated.values())
        np.testing.assert_allclose(drawn["lost to friction, wrenches, sampling"].y, lost, atol=1e-7)


def test_a_saved_run_without_its_energy_says_why(run: fd.Run, tmp_path: Path) -> None:
    """CSV holds no model; memory is in no file; sensors hide the truth. A measurement is not asked."""
    friction = fd.effects.PreslidingFriction("elbow", side="motor", level=0.1, stiffness=100.0)
    offset = fd.effects.SensorOffset(channel="q.elbow", offset=0.1)
    reasons = {"does not hold its model": run.model, "states of its friction": friction, "other signals": offset}
    for words, extra in reasons.items():
        model = run.model if extra is run.model else run.model.replace(effects=[*run.model.effects, extra])
        path = tmp_path / ("run.csv" if extra is run.model else "run.npz")
        fd.simulate(model, duration=0.05, rate=100).save(path)
        picture = fd.plot(path)
        assert not [panel for panel in picture.panels if "energy" in panel.up]
        (note,) = [note for note in picture.notes if "No energy of" in note]
        assert words in note
    measured = fd.plot(fd.Recording([0.0, 1.0], {"q.a": [0.0, 1.0]}))
    assert len(measured.notes) == 1


@pytest.mark.parametrize(
    ("count", "scale"),
    [*((3, scale) for scale in (5e-324, 1e-310, 1e-200, 1e-12, 1e12, 1e140)), (7000, 5e-324), (7000, 1e140)],
)
def test_numbers_of_any_size_are_drawn(count: int, scale: float, tmp_path: Path) -> None:
    """From the least double on, samples are drawn without a warning in every view, by both renderers."""
    t = np.linspace(0.0, 1.0, count)
    wave = scale * np.round(3.0 * np.sin(9.0 * t))
    rec = fd.Recording(t, {f"{signal}.a": wave for signal in ("q", "v", "tau_s")} | {"theta.a": 2.0 * wave})
    picture = fd.plot(rec, rec, views=["positions", "deflection", "phase", "loops"], path=tmp_path / "size.svg")
    assert all(np.diff(panel.y_range) > 0 for panel in picture.panels)
    fd.compare(rec, rec).plot(tmp_path / "comparison.svg").plotly()


@pytest.mark.parametrize("times", [[0.0, 5e-324], [1e200, 2e200], [1e17, 1e17 + 16], [-1.7e308, 1.7e308]])
def test_times_that_no_axis_can_show(times: list[float]) -> None:
    """Too close for their size, or too great: one line, from both pictures."""
    rec = fd.Recording(times, {"q.a": [0.0, 1.0]})
    with pytest.raises(fd.InputError, match=r"t: times from .* s cannot be drawn; shift or scale the clock"):
        fd.plot(rec)
    with pytest.raises(fd.InputError, match=r"cannot be drawn|two samples are needed"):
        fd.compare(rec, rec).plot()
