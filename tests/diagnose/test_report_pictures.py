"""Pictures of a report: residuals thinned and averaged."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flexdyn.diagnose.report.pictures import residual_figure
from flexdyn.diagnose.report.trace import ResidualTrace
from tests.arms import repickled
from tests.diagnose import report_cases as cases


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
