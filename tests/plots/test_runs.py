"""Pictures of motions: what is drawn is what was simulated or measured, in both renderers, with units."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.plots.motions import VIEW_NAMES
from flexdyn.plots.palette import HUES
from flexdyn.plots.panel import Curve
from flexdyn.plots.picture import FILES, Picture
from tests.arms import slider

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def run() -> fd.Run:
    """The two-link arm under a pulse that jumps, at 100 Hz: few enough points for Matplotlib to write every one."""
    pulse = fd.Samples([0.0, 0.3, 0.6], {"shoulder": [0.3, -0.3, 0.0], "elbow": [0.2, -0.2, 0.0]}, "hold")
    return fd.simulate(fd.load_model("scara_two_link"), pulse, duration=1.0, rate=100)


@pytest.fixture(scope="module")
def log(run: fd.Run) -> fd.Recording:
    """Of the same motion, measured at 40 Hz with an offset of the shoulder's encoder."""
    t = np.arange(0.0, 1.0, 0.025)
    q = {f"q.{joint}": np.interp(t, run.t, run.q[:, j]) for j, joint in enumerate(run.joint_names)}
    return fd.Recording(t, {**q, "q.shoulder": q["q.shoulder"] + 0.01, "tau.elbow": np.ones(len(t))}, name="log")


def curves(picture: Picture) -> dict[str, Curve]:
    """All curves by name."""
    return {curve.name: curve for panel in picture.panels for curve in panel.curves}


def traces(picture: Picture) -> dict[str, Any]:
    """Plotly's traces with samples, by name."""
    return {trace.name: trace for trace in picture.plotly().data if len(trace.x) > 1}


def svg_curves(path: Path) -> dict[str, Array]:
    """Points of the curves in an SVG, by name, as they stand on the page."""
    found = {}
    for name, body in re.findall(r'<g id="([\w ,.]+)">\s*<path d="([^"]*)"', path.read_text(encoding="utf-8")):
        if "." in name:
            found[name] = np.array(re.findall(r"-?\d+\.?\d*", body), dtype=float).reshape(-1, 2)
    return found


def signals(run: fd.Run) -> dict[str, Array]:
    """Everything that the overview draws of joints, by hand."""
    found: dict[str, Array] = {}
    for j, joint in enumerate(run.joint_names):
        found |= {f"q.{joint}": run.q[:, j], f"theta.{joint}": run.theta[:, j], f"tau.{joint}": run.tau[:, j]}
        found |= {f"tau_s.{joint}": run.tau_s[:, j], f"deflection.{joint}": run.theta[:, j] - run.q[:, j]}
    return found


def test_the_page_in_the_browser_holds_the_runs_own_numbers(run: fd.Run) -> None:
    """Every curve of the overview has the run's samples to the last bit; the energy is the ledger's."""
    drawn = traces(run.plot())
    for name, values in signals(run).items():
        assert np.array_equal(drawn[name].x, run.t), name
        assert np.array_equal(drawn[name].y, values), name
    assert np.array_equal(drawn["all of it"].y, run.energy.mechanical)
    assert np.array_equal(drawn["supplied by the motors"].y, run.energy.supplied.sum(axis=1))
    coulomb = [lost for name, lost in run.energy.dissipated.items() if name.startswith("coulomb_friction.")]
    assert np.array_equal(drawn["lost: coulomb_friction"].y, sum(coulomb))
    assert {drawn[f"tau.{joint}"].line.shape for joint in run.joint_names} == {"hv"}
    assert {drawn[f"q.{joint}"].line.shape for joint in run.joint_names} == {"linear"}


def test_the_file_holds_them_too(run: fd.Run, tmp_path: Path) -> None:
    """Points read back from the SVG are the samples, put on the page by a straight line across and one up."""
    run.plot(tmp_path / "run.svg", start=0.2, end=0.7)
    drawn = svg_curves(tmp_path / "run.svg")
    t = run.t[20:71]
    for name, values in signals(run).items():
        points = drawn[name]
        if name.startswith("tau."):  # a staircase: the corner before each sample stands at the last value
            assert len(points) == 2 * len(t) - 1
            np.testing.assert_array_equal(points[1::2, 1], points[:-2:2, 1])
            points = points[::2]
        for column, truth in ((0, t), (1, values[20:71])):
            slope, offset = np.polyfit(truth, points[:, column], 1)
            assert slope * (1, -1)[column] > 0.0  # an SVG counts downwards
            np.testing.assert_allclose(points[:, column], slope * truth + offset, atol=2e-5, err_msg=name)


def test_both_renderers_put_a_panel_in_the_same_place(run: fd.Run) -> None:
    """Axes of Matplotlib and Plotly cover the same share of the page, over the same range, with the same labels."""
    picture = run.plot(views=["positions", "torques", "phase", "energy"])
    layout, axes = picture.plotly().layout, picture.figure().axes
    assert len(axes) == len(picture.panels) == 2 * 3 + 3
    for number, (panel, ax) in enumerate(zip(picture.panels, axes, strict=True), start=1):
        across, up = layout[f"xaxis{number}"], layout[f"yaxis{number}"]
        place = ax.get_position()
        assert across.domain == pytest.approx((place.x0, place.x1))
        assert up.domain == pytest.approx((place.y0, place.y1))
        assert (ax.get_xlim(), ax.get_ylim()) == (across.range, up.range) == (panel.x_range, panel.y_range)
        assert (ax.get_ylabel(), ax.get_xlabel()) == (up.title.text, across.title.text)


def test_nothing_overlaps(run: fd.Run, log: fd.Recording) -> None:
    """Axes with their labels, titles and legends keep clear of each other and stay on the page."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    for picture in (
        run.plot(),
        fd.plot(log, run),
        fd.plot(run, views=["phase", "loops"]),
        fd.plot(log, joints="elbow"),
    ):
        figure = picture.figure()
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        boxes = [ax.get_tightbbox(canvas.get_renderer()) for ax in figure.axes]
        boxes += [entry.get_window_extent(canvas.get_renderer()) for entry in (*figure.legends, *figure.texts)]
        for i, box in enumerate(boxes):
            assert box.x0 >= 0
            assert box.y0 >= 0
            assert box.x1 <= figure.bbox.x1
            assert box.y1 <= figure.bbox.y1
            for other in boxes[:i]:
                # Half a point of a tick's number may reach past the end of its axis.
                assert not box.padded(-2.0).overlaps(other.padded(-2.0)), (i, box, other)


def test_every_axis_has_a_unit(run: fd.Run, tmp_path: Path) -> None:
    """Radians for a revolute joint; metres and newtons for a prismatic one, of a run and of its file."""
    units = {"position": "rad", "theta - q": "rad", "torque": "N m", "velocity": "rad/s", "tau_s": "N m", "energy": "J"}
    for panel in run.plot(views=VIEW_NAMES).panels:
        quantity, unit = panel.up[:-1].split(" [")
        assert unit == units[quantity]
        assert panel.across in ("t [s]", "position [rad]", "theta - q [rad]")
    run.save(tmp_path / "run.npz")
    assert [p.up for p in fd.plot(tmp_path / "run.npz").panels] == [p.up for p in run.plot().panels[:-1]]
    elastic = {"lift": {"rotor_inertia": 0.2, "stiffness": 2e4}}
    lifted = fd.simulate(fd.FlexibleJointModel(slider(tmp_path), elastic), [25.0], duration=0.1)
    lifted.save(tmp_path / "lift.h5")
    for source in (lifted, tmp_path / "lift.h5"):
        picture = fd.plot(source, views=["positions", "velocities", "deflection", "torques", "loops"])
        labels = [panel.up for panel in picture.panels]
        assert labels == ["position [m]", "velocity [m/s]", "theta - q [m]", "force [N]", "tau_s [N]"]


def test_what_was_measured_lies_grey_below_with_the_residual(run: fd.Run, log: fd.Recording) -> None:
    """The residual of a run against a log that is 0.01 rad too high is -0.01 rad throughout, and so says its title."""
    picture = fd.plot(log, run, views="positions")
    above, beneath = picture.panels[:2]
    assert [curve.name for curve in above.curves] == [
        "q.shoulder, log",
        *(f"{s}.shoulder, scara_two_link" for s in ("q", "theta")),
    ]
    measured, simulated, _ = above.curves
    assert measured.dots
    assert measured.colour not in HUES
    assert simulated.colour == HUES[0] == above.colour
    assert beneath.title == "RMS q 0.01 rad"
    (residual,) = beneath.curves
    assert np.array_equal(residual.x, log.t)
    np.testing.assert_allclose(residual.y, -0.01, atol=1e-12)
    assert "log: recorded, 40 samples" in picture.notes[0]


def test_a_log_of_the_motors_side_alone(log: fd.Recording) -> None:
    """Logs without link encoders are drawn and subtracted by what they have, in the joint's unit."""
    meta = {"units": {"theta.slide": "m"}}
    logs = [fd.Recording(log.t, {"theta.slide": offset + log.t}, meta=meta) for offset in (0, 2)]
    above, beneath = fd.plot(*logs).panels
    assert above.up == "position [m]"
    assert (beneath.title, beneath.up) == ("RMS theta 2 m", "residual [m]")


def test_a_joint_has_one_colour_on_every_page(run: fd.Run) -> None:
    """The elbow alone, or in another view, is drawn in the hue that it has beside the shoulder."""
    for choice in ({}, {"joints": "elbow"}, {"views": "loops"}, {"views": ["phase", "velocities"]}):
        for name, curve in curves(run.plot(**choice)).items():
            if "." in name:
                assert curve.colour == HUES[run.joint_names.index(name.split(" ")[0].split(".")[1])]


def test_loops_and_phase_planes(run: fd.Run) -> None:
    """Torque stands over deflection, velocity over position, for link and rotor."""
    drawn = curves(run.plot(views=["loops", "phase"]))
    assert np.array_equal(drawn["tau_s.elbow over deflection"].x, run.deflection[:, 1])
    assert np.array_equal(drawn["tau_s.elbow over deflection"].y, run.tau_s[:, 1])
    assert np.array_equal(drawn["omega.shoulder over theta"].x, run.theta[:, 0])
    assert np.array_equal(drawn["v.shoulder over q"].y, run.v[:, 0])


def test_signals_that_say_nothing_of_their_own_are_left_out(run: fd.Run) -> None:
    """A rigid arm has no second angle, and a plain motor applies what it is asked."""
    assert not [name for name in curves(run.plot()) if name.startswith("tau_applied")]
    rigid = fd.simulate(run.model.rigid(), duration=0.1, rate=100)
    drawn = curves(rigid.plot(views="positions"))
    assert list(drawn) == ["q.shoulder", "q.elbow"]


@pytest.mark.parametrize(
    "name", ["$\\frac{x$", "a_b^c$$", "<img src=x onerror=alert(1)>", "{}%{x}&amp;", "关节", "n" * 200]
)
def test_names_are_shown_as_they_are(name: str, tmp_path: Path) -> None:
    """Dollars, backslashes and tags in a joint's name are neither set as formulas nor read as markup."""
    rec = fd.Recording([0.0, 1.0], {f"q.{name}": [0.0, 1.0]}, name=name)
    shown = name if len(name) < 50 else f"{name[:30]}…{name[-17:]}"
    picture = fd.plot(rec)
    assert picture.panels[0].title == shown
    titles = 1 + (picture.headline == shown)  # the page's own is cut where the page ends
    escaped = shown.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    if name != "关节":  # letters that Matplotlib's font lacks are boxes there
        picture.save(tmp_path / "name.svg")
        assert (tmp_path / "name.svg").read_text(encoding="utf-8").count(f">{escaped}</text>") == titles
    texts = [annotation.text for annotation in picture.plotly().layout.annotations]
    assert texts.count(f"<b>{escaped}</b>") == titles


def test_the_same_picture_is_the_same_file(run: fd.Run, tmp_path: Path) -> None:
    """Drawn twice, every format has the same bytes: no times, no random names."""
    for suffix in FILES:
        first, second = (tmp_path / f"{i}{suffix}" for i in range(2))
        for path in (first, second):
            fd.plot(run, views="positions", path=path)
        assert first.read_bytes() == second.read_bytes(), suffix


def test_an_axis_of_a_constant_is_not_filled_by_rounding(run: fd.Run) -> None:
    """A level of 3 with errors of 1e-15 is a flat line in the middle of its axis."""
    t = np.linspace(0.0, 1.0, 50)
    level = 3.0 + 1e-15 * np.sin(40.0 * t)
    (panel,) = fd.plot(fd.Recording(t, {"q.a": level})).panels
    assert math.isclose(sum(panel.y_range), 6.0)
    assert np.ptp(panel.y_range) > 0.1
