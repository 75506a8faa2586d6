"""Motions written as points: in a command file, in a model file, as a mapping; and recorded references followed."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import flexdyn as fd
from flexdyn.cli import main
from flexdyn.control.points import CommandPoints, command_of
from flexdyn.simulation.command_input import make_drive
from tests.arms import repickled

MOVE: dict[str, Any] = {
    "pd": {"reference": {"t": [0, 0.5, 1.0], "shoulder": [0.2, 0.6, 0.2]}, "kp": 40.0, "kd": 4.0, "rate": 500}
}
MODEL = """\
flexdyn: 1
robot: {urdf: scara_two_link, gravity: [0, 0, -9.81]}
joints: {"*": {rotor_inertia: 1.0e-5, gear_ratio: 100, stiffness: 900, damping: 1.5}}
initial: {q: {elbow: 1.5}}
command:
  pd:
    reference: {t: [0, 0.5, 1.0], shoulder: [0.2, 0.6, 0.2]}
    kp: 40
    kd: 4
"""


@pytest.fixture(scope="module")
def model() -> fd.FlexibleJointModel:
    """The paper's arm with stiff gears, no effects."""
    drives = {"*": {"stiffness": 900.0, "damping": 1.5}}
    return fd.load_model("scara_two_link").replace(joints=drives, effects=[])


def test_a_first_motion_needs_one_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`flexdyn simulate model.yaml` plays the points that stand in it, from the first one, and says so."""
    (tmp_path / "arm.yaml").write_text(MODEL, encoding="utf-8")
    assert main(["simulate", str(tmp_path / "arm.yaml"), "-o", str(tmp_path / "run.npz")]) == 0
    assert "the command is the model file's own" in capsys.readouterr().err
    run = fd.read_recording(tmp_path / "run.npz")
    assert run.t[-1] == 1.0
    assert run["q.shoulder"][0] == 0.2
    assert abs(run["q.shoulder"][500] - 0.6) < 0.1
    np.testing.assert_allclose(run["theta.elbow"], 1.5, atol=0.1)
    loaded = fd.load_model(tmp_path / "arm.yaml")
    direct = fd.simulate(loaded, loaded.command)
    np.testing.assert_array_equal(direct.q[:, 0], run["q.shoulder"])
    assert not fd.simulate(loaded, duration=0.1).tau.any(), "without a command the torque is zero"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("interpolation", ["linear", "cubic", "monotone"])
@pytest.mark.parametrize(
    ("t", "values"),
    [([0, 0.5, 1], [0, 2, -1e308]), ([-1e308, 1, 2], [0, 0.5, 0]), ([0, 5e-324, 1], [0, 1, 0])],
    ids=("large values", "a first time far away", "times too close"),
)
def test_points_without_a_finite_curve_are_refused(
    model: fd.FlexibleJointModel, t: list[float], values: list[float], interpolation: Any
) -> None:
    """One line and no warning of NumPy, where a slope would be infinite or two times become one."""
    with pytest.raises(fd.InputError, match=r"no finite curve goes through them|time must increase"):
        make_drive(model, fd.Samples(t, {"elbow": values}, interpolation), None)


def test_a_command_in_a_model_is_kept(tmp_path: Path, model: fd.FlexibleJointModel) -> None:
    """Saved, loaded, pickled, replaced; locked against change; taken away by None."""
    given = copy.deepcopy(MOVE)
    moving = model.replace(command=given)
    given["pd"]["kp"] = -1.0
    fd.save_model(moving, tmp_path / "scara_two_link.yaml")
    again = fd.load_model(tmp_path / "scara_two_link.yaml")
    assert again == moving == repickled(moving) == moving.replace(tolerance=moving.tolerance)
    assert moving != model == moving.replace(command=None)
    assert again.command == {"pd": MOVE["pd"] | {"reference": {"t": (0, 0.5, 1.0), "shoulder": (0.2, 0.6, 0.2)}}}
    with pytest.raises(TypeError):
        again.command["pd"]["kp"] = 3.0


def test_points_are_met_and_never_passed(model: fd.FlexibleJointModel) -> None:
    """The reference is SciPy's monotone interpolation: at rest where it turns back; the arm's own spring overshoots."""
    made = command_of(MOVE)
    assert isinstance(made, fd.PD)
    assert isinstance(made.reference, CommandPoints)
    whole = made.reference.whole(("shoulder", "elbow"), {"elbow": 1.5})
    breaks, coefficients, last = whole.pieces(whole.values)
    t = np.linspace(0.0, 0.999, 400)
    place = np.searchsorted(breaks, t, "right") - 1
    powers = (t - breaks[place])[:, None] ** np.arange(4)
    drawn = np.einsum("ij,ijk->ik", powers, coefficients[place])
    np.testing.assert_allclose(drawn[:, 0], PchipInterpolator([0, 0.5, 1], [0.2, 0.6, 0.2])(t), atol=1e-12)
    assert drawn[:, 0].max() <= 0.6 + 1e-12
    np.testing.assert_array_equal(drawn[:, 1], 1.5)
    assert last.tolist() == [0.2, 1.5]
    assert fd.simulate(model, MOVE, rate=100).q[0, 0] == 0.2


def test_torques_as_points(tmp_path: Path, model: fd.FlexibleJointModel) -> None:
    """In a file: held from point to point, or linear; joints without points get none."""
    (tmp_path / "push.yaml").write_text("torques: {t: [0, 0.1, 0.2], elbow: [1, -2, 0]}\n", encoding="utf-8")
    held = fd.simulate(model, tmp_path / "push.yaml", rate=100)
    assert held.t[-1] == 0.2
    np.testing.assert_array_equal(held.tau[:, 0], 0.0)
    np.testing.assert_array_equal(held.tau[:20, 1], [1.0] * 10 + [-2.0] * 10)
    sloped = {"torques": {"t": [0, 0.1, 0.2], "elbow": [0, 1, 0], "interpolation": "linear"}}
    np.testing.assert_allclose(fd.simulate(model, sloped, rate=100).tau[5, 1], 0.5, rtol=1e-12)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"pd": {"reference": {"shoulder": [0, 1]}, "kp": 1, "kd": 1}}, r"pd\.reference: points are needed.*JOINT"),
        ({"pd": {"reference": {"t": [0, 1]}, "kp": 1, "kd": 1}}, r"pd\.reference: points of no joint"),
        ({"pd": {"reference": {"t": [0, 1], "a": [1]}, "kp": 1, "kd": 1}}, r"reference\.a: 1 points where t has 2"),
        ({"pd": {"reference": {"t": [1, 0], "shoulder": [1, 2]}, "kp": 1, "kd": 1}}, r"pd\.reference: time must incr"),
        ({"pd": {"reference": {"t": [0, 1], "shoulder": [1, 2]}, "kp": 1}}, r"kd"),
        ({"pd": {"reference": "log.csv", "kp": 1, "kd": 1}}, r"pd\.reference: a path is not taken here.*write points"),
        ({"torques": {"t": [0, 1], "elbow": [0, 1], "interpolation": "cubik"}}, r"did you mean 'cubic'"),
        ({"torques": {"t": [0, 1], "ellbow": [0, 1]}}, r"the robot has no such joint, got 'ellbow'"),
        ({"pd": {}, "torques": {}}, r"one of pd and torques is needed"),
        ({"pid": {}}, r"pid"),
        (3, r"a mapping with pd or torques is needed"),
    ],
)
def test_mistakes_in_points_are_named(model: fd.FlexibleJointModel, entry: Any, words: str) -> None:
    """When the model is made, under the key command."""
    with pytest.raises(fd.InputError, match=rf"command.*{words}"):
        model.replace(command=entry)


STEP = fd.Recording(np.arange(9) * 0.1, {"q.shoulder": [0, 0, 0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5], "q.elbow": [1.5] * 9})


def drawn(model: fd.FlexibleJointModel, interpolation: Any) -> np.ndarray:
    """The reference of a controller that tracks the step, between its samples, as the core has it."""
    samples = make_drive(model, fd.PD(STEP, 1.0, 1.0, interpolation=interpolation), None).reference
    assert samples is not None
    breaks, coefficients, _ = samples.pieces(samples.values)
    t = np.linspace(0.0, breaks[-1] - 1e-9, 2001)
    place = np.searchsorted(breaks, t, "right") - 1
    powers = (t - breaks[place])[:, None] ** np.arange(coefficients.shape[1])
    return np.asarray(np.einsum("ij,ijk->ik", powers, coefficients[place])[:, 0])


def test_a_recorded_reference_is_not_overshot(model: fd.FlexibleJointModel) -> None:
    """A recorded step stays between its two levels; the spline of old went beyond them; hold keeps the step."""
    assert drawn(model, "cubic").max() > 0.53
    for interpolation in (None, "linear", "hold"):
        path = drawn(model, interpolation)
        assert path.min() >= -1e-12
        assert path.max() <= 0.5 + 1e-12
    assert set(drawn(model, "hold").tolist()) == {0.0, 0.5}


def test_yaml_has_the_key(tmp_path: Path, model: fd.FlexibleJointModel) -> None:
    """pd: interpolation: hold gives the run that PD(..., interpolation="hold") gives; other words are refused."""
    fd.write_recording(STEP, tmp_path / "step.csv")
    for word in ("hold", "monotone"):
        text = f"pd: {{reference: step.csv, kp: 40, kd: 4, interpolation: {word}}}\n"
        (tmp_path / "pd.yaml").write_text(text, encoding="utf-8")
        mine = fd.simulate(model, tmp_path / "pd.yaml")
        its = fd.simulate(model, fd.PD(STEP, kp=40, kd=4, interpolation=word))
        np.testing.assert_array_equal(mine.q, its.q)
        if word == "monotone":
            np.testing.assert_array_equal(mine.q, fd.simulate(model, fd.PD(STEP, kp=40, kd=4)).q)
    with pytest.raises(fd.InputError, match=r"pd\.interpolation: no such interpolation, got 'spline'"):
        fd.PD(STEP, 1, 1, interpolation="spline")  # type: ignore[arg-type]
    with pytest.raises(fd.InputError, match=r"pd\.interpolation: Samples have their own"):
        fd.PD(fd.Samples([0, 1], [[0, 0], [1, 1]]), 1, 1, interpolation="hold")
