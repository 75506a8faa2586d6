"""XL330: the fitted servo follows its logs from the goal alone, and the firmware's law is the one of the logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from xl330_data import HERE, SOLVER, Log, errors, from_goals, of_duties, read_logs
from xl330_fit import model_of, point_of, search

import flexdyn as fd

DATA = Path(__file__).parents[3] / "shared" / "data" / "bam_xl330"
MEASURED = pytest.mark.skipif(
    not (DATA / "xl330_kp100_sin_sin.csv").is_file(), reason=f"{DATA} is absent: the logs of the XL330 are read there"
)


@pytest.fixture(scope="module")
def logs() -> tuple[Log, ...]:
    """All eight."""
    return read_logs(DATA)


@MEASURED
def test_from_the_goal_alone(logs: tuple[Log, ...]) -> None:
    """At most 16 mrad over all logs; fitted to two gains, at most 45 mrad on the other two."""
    assert errors(fd.load_model(HERE / "fitted.yaml"), logs).mean() < 0.016
    unseen = [log for log in logs if log.gain in (200, 800)]
    assert errors(fd.load_model(HERE / "fitted_100_400.yaml"), unseen).mean() < 0.045


@MEASURED
def test_the_error_is_not_one_of_the_step(logs: tuple[Log, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Located events at tight tolerances give the same motion as steps of a millisecond."""
    fitted, two = fd.load_model(HERE / "fitted.yaml"), [log for log in logs if log.name.endswith("sin_sin")]
    steps = from_goals(fitted, two)
    monkeypatch.setattr("xl330_data.SOLVER", fd.solvers.DormandPrince(rtol=1e-6, atol=1e-8))
    for coarse, exact in zip(steps, from_goals(fitted, two), strict=True):
        assert np.abs(coarse - exact).mean() < 2e-3
    assert isinstance(SOLVER, fd.solvers.TimeStepping)


@MEASURED
def test_duty_of_the_goal_is_the_recorded_one(logs: tuple[Log, ...]) -> None:
    """The firmware's law along the measured positions gives the PWM that the servo reported."""
    chosen = [log for log in logs if log.name == "kp200_sin_time_square"]
    (duty,) = of_duties(chosen)
    raw = fd.read_recording(
        DATA / "xl330_kp200_sin_time_square.csv",
        map=fd.ChannelMap.from_dict(
            {
                "flexdyn_map": 1,
                "time": {"from": "t", "start": "zero"},
                "channels": {"duty.servo": {"from": "pwm_count", "full_counts": 885}},
            }
        ),
    )
    seen = raw["duty.servo"][: len(duty)]
    middle = 0.5 * (duty["duty.servo"][1:] + duty["duty.servo"][:-1])  # a sample stands between two means
    assert np.sqrt(np.mean((middle - seen[1:]) ** 2)) < 0.02 * np.abs(seen).max()


def test_points_of_the_search_are_models() -> None:
    """There and back; and the search finds the bottom of a bowl that is a hundred times as long as wide."""
    fitted = fd.load_model(HERE / "fitted.yaml")
    again = model_of(point_of(fitted), fd.load_model(HERE / "plain.yaml"))
    for ours, theirs in zip(again.effects, fitted.effects, strict=True):
        assert ours.values == pytest.approx(theirs.values, rel=1e-9)
    assert again.joints["servo"].stiffness == pytest.approx(fitted.joints["servo"].stiffness)
    bowl = np.array([1.0, 10.0, 100.0])
    found = search(lambda x: float((bowl * (x - 1.0)) @ (bowl * (x - 1.0))), np.zeros(3), 1500)
    np.testing.assert_allclose(found, 1.0, atol=1e-3)
