"""Pictures of a report: laws with the numbers found, residuals thinned and averaged."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.diagnose.report.law import effect_of, law_picture
from flexdyn.diagnose.report.pictures import residual_figure
from flexdyn.diagnose.report.suspects import Number, Suspect
from flexdyn.diagnose.report.trace import ResidualTrace
from flexdyn.plots.laws import law_figure
from tests.arms import SLIDER, repickled
from tests.diagnose import report_cases as cases


def test_a_sliding_joint_reads_newton_and_metre(tmp_path: Path) -> None:
    """The picture of a law has the units of its joint."""
    (tmp_path / "slider.urdf").write_text(SLIDER, encoding="utf-8")
    model = fd.FlexibleJointModel(fd.load_robot(tmp_path / "slider.urdf"))
    suspect = Suspect("coulomb_friction", "lift", "link", {"level": Number(2.5, 0.1, "N")})
    effect = effect_of(suspect)
    assert effect == fd.effects.CoulombFriction("lift", side="link", level=2.5)
    axes = law_figure(effect, prismatic=True).axes[0]
    assert (axes.get_xlabel()[-5:], axes.get_ylabel()[-3:]) == ("[m/s]", "[N]")
    picture = law_picture(suspect, model)
    assert picture is not None
    assert picture != law_picture(suspect, fd.load_model("scara_two_link"))


@pytest.mark.parametrize(
    "suspect",
    [
        Suspect("presliding_friction", "elbow", "motor"),
        Suspect("payload", None, None, {"mass": Number(1.0, 0.1, "kg")}),
        Suspect("no_such_effect", "elbow", "motor"),
        Suspect("coulomb_friction", "elbow", "motor", {"level": Number(math.nan, 0.1, "N m")}),
    ],
)
def test_what_cannot_be_drawn_is_left_out(suspect: Suspect) -> None:
    """No numbers, no law, no such effect, a number that is none."""
    assert law_picture(suspect, fd.load_model("scara_two_link")) is None


def test_every_law_of_the_catalogue_can_stand_in_a_report() -> None:
    """With its example's numbers as the ones found: what `draw_law` draws, the report shows."""
    model = fd.load_model("scara_two_link")
    drawn = {name: law_picture(_example(kind), model) for name, kind in fd.effects.catalogue().items()}
    assert {name for name, picture in drawn.items() if picture is None} == {"payload", "parameter_error"}
    assert all(picture is None or picture.startswith("<svg") for picture in drawn.values())


def test_averages_show_a_law_under_noise() -> None:
    """Through dots of ten times its size the averages follow the law before, and are nothing after."""
    draw = np.random.default_rng(4)
    v = draw.uniform(-0.5, 0.5, 40_000)
    noise = 0.3 * draw.standard_normal(len(v))
    cloud = ResidualTrace.thinned("elbow", "v [rad/s]", "r [N m]", v, noise + 0.03 * np.sign(v), noise)
    assert len(cloud.x) < 2000
    x, before, after = cloud.means.T
    off = np.abs(x) > 0.02
    np.testing.assert_allclose((before - after)[off], 0.03 * np.sign(x[off]), atol=1e-12)
    assert np.abs(after).max() < 5.0 * 0.3 / np.sqrt(len(v) / len(x))
    assert 0.1 < residual_figure(cloud)["limit"] < 1.0
    assert len(repickled(cloud).means) == len(x)
    line = ResidualTrace.thinned("elbow", "t [s]", "r [N m]", np.arange(5000.0), v[:5000], v[:5000])
    assert len(line.means) == 0
    assert residual_figure(line)["limit"] is None


def test_long_residuals_are_thinned_and_keep_their_peaks() -> None:
    """Over time every peak stays, and so does a hole; a cloud keeps its points unchanged, fewer of them."""
    t = np.arange(0.0, 50.0, 1e-3)
    before, after = np.sin(t), 0.1 * np.cos(t)
    before[12345], before[100:200] = 7.0, math.nan
    line = ResidualTrace.thinned("elbow", "t [s]", "r [N m]", t, before, after)
    assert len(line.x) < 0.2 * len(t)
    assert np.nanmax(line.before) == 7.0
    assert np.isnan(line.before).any()
    cloud = ResidualTrace.thinned("elbow", "omega [rad/s]", "r [N m]", np.cos(t), before, after)
    assert len(cloud.x) <= 1500
    rows = {(x, y) for x, y in zip(np.cos(t).tolist(), after.tolist(), strict=True)}
    assert {(x, y) for x, y in zip(cloud.x.tolist(), cloud.after.tolist(), strict=True)} <= rows


def test_traces_are_locked() -> None:
    """Nobody changes them, not in another process either."""
    trace = cases.residuals("elbow")[0]
    for each in (trace, repickled(trace)):
        with pytest.raises(ValueError, match="read-only"):
            each.before[0] = 1.0


def _example(kind: type[fd.effects.Effect]) -> Suspect:
    entry = kind.example().to_dict()
    numbers = {field.name: Number(entry.pop(field.name), 0.1, "1") for field in kind.parameters()}
    place: Callable[[str], Any] = entry.pop
    del entry["effect"]
    joint, side = (place(key) if key in entry else None for key in ("joint", "side"))
    return Suspect(kind.name, joint, side, numbers, entry)
