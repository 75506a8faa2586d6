"""Commands as data: checked, locked, and a line on what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.simulation.command_input import make_drive
from flexdyn.simulation.given_command import read_command_file
from tests.arms import repickled


@pytest.fixture(scope="module")
def model() -> fd.FlexibleJointModel:
    """The paper's arm."""
    return fd.load_model("scara_two_link")


@pytest.mark.parametrize(
    ("t", "values", "words"),
    [
        ([0.0], [1.0], "samples: t is (samples,) and values (samples, n)"),
        ([0.0, 1.0], [[1.0], [2.0], [3.0]], "samples: t is (samples,) and values (samples, n)"),
        ([[0.0, 1.0]], [1.0, 2.0], "samples: t is (samples,)"),
        ([0.0, 1.0, 1.0], [1, 2, 3], "samples.t[2]: time must increase, got 1.0"),
        ([0.0, 1.0, 0.5], [1, 2, 3], "samples.t[2]: time must increase, got 0.5"),
        ([0.0, math.nan], [1, 2], "samples.t[1]: a finite number is needed"),
        ([0.0, 1.0], [1, math.inf], "samples.values[1]: a finite number is needed"),
        ([0.0, 1.0], ["a", "b"], "values: numbers are needed"),
        ([0.0, 1.0], [10**400, 0], "values: numbers are needed"),
        ([0.0, 1.0], [[1, 2], [3]], "values: numbers are needed"),
        (None, [1.0, 2.0], "samples: t is (samples,)"),
        ([0.0, 1.0], {"a": [1, 2], "b": [1, 2, 3]}, "values: one column (samples,) for each joint is needed"),
        ([0.0, 1.0], {}, "values: one column (samples,) for each joint is needed"),
    ],
)
def test_samples_without_sense_are_refused(t: Any, values: Any, words: str) -> None:
    """One line that names the row."""
    with pytest.raises(fd.InputError) as caught:
        fd.Samples(t, values)
    assert str(caught.value).startswith(words)


def test_samples_are_copied_and_locked() -> None:
    """What the user's arrays become later does not reach them, also after pickling."""
    t, values = np.array([1.0, 2.0, 4.0]), np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    samples = fd.Samples(t, values, "linear")
    t[0], values[0, 0] = 9.0, 9.0
    for each in (samples, repickled(samples)):
        assert (each.t[0], each.values[0, 0], each.duration, each.interpolation) == (1.0, 1.0, 3.0, "linear")
        for array in (each.t, each.values):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0.0
    named = repickled(fd.Samples([0, 1], {"elbow": [1, 2]}))
    np.testing.assert_array_equal(named.columns(("shoulder", "elbow")), [[0, 1], [0, 2]])


def test_an_unknown_interpolation_is_refused() -> None:
    """With what there is."""
    with pytest.raises(fd.InputError, match="no such interpolation, got 'spline'; it is hold, linear, monotone, cubic"):
        fd.Samples([0, 1], [1, 2], "spline")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (fd.Samples([0, 1], [1, 2]), "samples.values: 2 columns are needed, got 1; the joints are shoulder, elbow"),
        (fd.Samples([0, 1], {"elbo": [1, 2]}), "samples.values: the robot has no such joint, got 'elbo'"),
        ([1.0, 2.0, 3.0], "command: one number, or one for each of the 2 joints, is needed"),
        ([1.0, math.nan], "command: finite numbers are needed"),
        (object(), "command: numbers are needed"),
        ({"elbow": 1.0}, "command.shoulder: a joint is missing"),
        ("nowhere.csv", "nowhere.csv: "),
        (fd.PD([1, 2], 1.0, 1.0), "pd.reference: no reference to track"),
        (fd.PD(fd.Samples([0, 1], [1, 2]), 1.0, 1.0), "samples.values: 2 columns are needed"),
        (fd.PD(fd.Samples([0, 1], np.ones((2, 2))), 1.0, 1.0, feedforward=3), "pd.feedforward: Samples or a recording"),
        (fd.PD(fd.Samples([0, 1], np.ones((2, 2))), [1, 2, 3], 1.0), "pd.kp: one number, or one for each"),
        (fd.PD(fd.Samples([0, 1], np.ones((2, 2))), 1.0, math.inf), "pd.kd: finite numbers are needed"),
    ],
)
def test_a_command_that_does_not_fit_the_arm(model: fd.FlexibleJointModel, command: Any, words: str) -> None:
    """Columns, joints and gains are checked against the model."""
    with pytest.raises(fd.InputError) as caught:
        make_drive(model, command, 1.0)
    assert str(caught.value).startswith(words)


@pytest.mark.parametrize("rate", [0, -5.0, math.inf, math.nan, "1 kHz", True, None])
def test_rates(rate: Any) -> None:
    """A control rate is a number above 0 Hz."""
    with pytest.raises(fd.InputError, match=r"^pd\.rate: a rate above 0 Hz is needed"):
        fd.PD(None, 1.0, 1.0, rate=rate)
    with pytest.raises(fd.InputError, match=r"^controller\.rate: a rate above 0 Hz is needed"):
        fd.Controller(lambda t, x: x.q, rate=rate)


def test_pd_and_controller_check_the_rest() -> None:
    """Feedback is theta or q; a law is callable."""
    with pytest.raises(fd.InputError, match=r"^pd\.feedback: no such feedback, got 'Theta'; it is theta or q"):
        fd.PD(None, 1.0, 1.0, feedback="Theta")  # type: ignore[arg-type]
    with pytest.raises(fd.InputError, match=r"^controller\.law: a callable"):
        fd.Controller(3.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"samples": [1, 2, 3]}, "external.samples: a wrench has six columns, got 3"),
        ({"samples": fd.Samples([0, 1], np.zeros((2, 3)))}, "external.samples: a wrench has six columns, got 3"),
        ({"samples": [1, 2, 3, 4, 5, math.nan]}, "external.samples: finite numbers are needed"),
        ({"samples": "up"}, "external.samples: numbers are needed"),
        ({"samples": np.zeros(6), "axes": "tool"}, "external.axes: no such axes, got 'tool'; they are world or frame"),
    ],
)
def test_wrenches_without_sense_are_refused(settings: Any, words: str) -> None:
    """Six finite numbers, in axes that exist."""
    with pytest.raises(fd.InputError) as caught:
        fd.FrameWrench("tool", **settings)
    assert str(caught.value).startswith(words)


def test_a_wrench_needs_a_frame_of_the_robot(model: fd.FlexibleJointModel) -> None:
    """The near miss is named, and something else than a wrench is refused; one on the base does no work."""
    with pytest.raises(fd.InputError, match="no such frame, got 'tol'; did you mean 'tool'"):
        fd.simulate(model, None, 0.1, external=fd.FrameWrench("tol", np.zeros(6)))
    with pytest.raises(fd.InputError, match="external: a FrameWrench is needed"):
        fd.simulate(model, None, 0.1, external=[np.zeros(6)])  # type: ignore[list-item]
    runs = [fd.simulate(model, None, 0.1, external=e) for e in (None, fd.FrameWrench("base", np.ones(6)))]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_a_command_file(tmp_path: Path, model: fd.FlexibleJointModel) -> None:
    """``pd:`` in YAML takes the keys of PD; paths are relative to the file."""
    t = np.linspace(0.0, 0.2, 21)
    path = fd.Recording(t, {"q.elbow": 1.5 + t, "q.shoulder": t**2})
    fd.write_recording(path, tmp_path / "path.csv")
    (tmp_path / "pd.yaml").write_text("pd: {reference: path.csv, kp: {shoulder: 5, elbow: 4}, kd: 1e0, rate: 5e2}")
    run = fd.simulate(model, str(tmp_path / "pd.yaml"), rate=100)
    same = fd.simulate(model, fd.PD(path, [5, 4], 1, 500), rate=100)
    np.testing.assert_array_equal(run.q, same.q)
    assert run.t[-1] == pytest.approx(0.2)
    assert run.q[0].tolist() == [0.0, 1.5]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pid: {}", "pid: no such key; did you mean 'pd'?"),
        ("{}", "command: one of pd and torques is needed, got []"),
        ("pd: {reference: a.csv, kp: 1}", "pd.kd: the key is missing"),
        ("pd: {reference: a.csv, kp: 1, kd: 1, feedbak: q}", "pd.feedbak: no such key; did you mean 'feedback'?"),
        ("pd: {reference: 3, kp: 1, kd: 1}", "pd.reference: the path of a recording is needed, got 3"),
        ("pd: {reference: a.csv, kp: 1, kd: 1, rate: -1}", "pd.rate: a rate above 0 Hz is needed, got -1"),
        ("pd: 3", "pd: a mapping of keys is needed, got 3"),
    ],
)
def test_a_mistake_in_a_command_file(tmp_path: Path, text: str, words: str) -> None:
    """One line with file, key and remedy."""
    file = tmp_path / "pd.yaml"
    file.write_text(text)
    with pytest.raises(fd.InputError) as caught:
        read_command_file(file)
    assert str(caught.value).startswith(f"{file}: {words}")
