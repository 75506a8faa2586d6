"""Mistakes that a first script makes: each error says what to write instead."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.records.suggestion import nearly_signals
from tests.arms import slider

T = np.array([0.0, 0.1, 0.2])


@pytest.fixture(scope="module")
def model() -> fd.FlexibleJointModel:
    """The paper's arm: shoulder and elbow."""
    return fd.load_model("scara_two_link")


def law(t: float, state: fd.State) -> list[float]:
    """A controller's law."""
    return [-1.0 * state.q[0] - 0.1 * state.v[0], t * 0.0]


class Named:
    """Callable, without a name of its own."""

    def __call__(self, t: float) -> list[float]:
        """Torques."""
        return [t, t]


@pytest.mark.parametrize("command", [law, lambda t, state: [0.0, 0.0], Named()])
def test_a_function_is_told_about_controllers(model: fd.FlexibleJointModel, command: Callable[..., Any]) -> None:
    """What the line says works."""
    with pytest.raises(fd.InputError, match=r"command: a function is no command.*fd\.Controller\(law, rate=1000\)"):
        fd.simulate(model, command, duration=0.1)
    assert len(fd.simulate(model, fd.Controller(law, rate=1000), duration=0.01).t) == 11


def test_other_things_that_are_no_command(model: fd.FlexibleJointModel) -> None:
    """A class, a model, a function as reference."""
    with pytest.raises(fd.InputError, match=r"a class is no command, got 'Controller'"):
        fd.simulate(model, fd.Controller, duration=0.1)
    with pytest.raises(fd.InputError, match="give the model first"):
        fd.simulate(model, model, duration=0.1)
    with pytest.raises(fd.InputError, match=r"pd\.reference: .*sampled first: fd\.Samples"):
        fd.simulate(model, fd.PD(np.sin, 1.0, 0.1), duration=0.1)


def test_a_urdf_is_no_model_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The line holds the Python that makes one, and the command; the Python runs as it stands."""
    slider(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(fd.InputError, match="a robot is no model yet") as caught:
        fd.load_model("slider.urdf")
    told = str(caught.value)
    assert "flexdyn new slider.urdf -o slider.yaml" in told
    written = re.search(r"fd\.FlexibleJointModel\(.*?\}\)", told)
    assert written is not None
    made = eval(written[0].replace("{...}", "{}"), {"fd": fd})  # noqa: S307 - what a user would paste
    assert made.joint_names == ("lift",)
    with pytest.raises(fd.InputError, match=r"a robot is no model yet.*load_robot\('ur10'\)"):
        fd.load_model("ur10")
    with pytest.raises(fd.InputError, match=r"FlexibleJointModel\(robot\)"):
        fd.load_model(made.robot)


def test_a_model_file_is_no_robot(tmp_path: Path) -> None:
    """load_robot and load_model are easily mixed up."""
    fd.save_model(fd.load_model("scara_two_link"), tmp_path / "arm.yaml")
    with pytest.raises(fd.InputError, match=r"a YAML file is no robot; .*fd\.load_model"):
        fd.load_robot(tmp_path / "arm.yaml")


def test_a_channel_with_another_sign_between_is_asked_back(model: fd.FlexibleJointModel, tmp_path: Path) -> None:
    """When it is read, when it is asked for, and when it is missed as a command."""
    rec = fd.Recording(T, {"q_shoulder": T, "tau_shoulder": T, "tau_elbow": T})
    with pytest.raises(fd.InputError, match=r"q\.shoulder: no such channel; did you mean 'q_shoulder'"):
        _ = rec["q.shoulder"]
    with pytest.raises(
        fd.InputError, match=r"no tau.*did you mean tau\.shoulder for tau_shoulder, tau\.elbow for tau_elbow"
    ):
        fd.simulate(model, rec)
    fd.write_recording(rec, tmp_path / "log.csv")
    with pytest.warns(
        fd.RecordingWarning, match=r"log\.csv: no channel is a signal of a joint: did you mean q\.shoulder for"
    ):
        fd.read_recording(tmp_path / "log.csv")
    dotted = fd.Recording(T, {"q.shoulder": T})
    with pytest.raises(fd.InputError, match=r"q_shoulder: no such channel; did you mean 'q\.shoulder'"):
        _ = dotted["q_shoulder"]


def test_names_that_are_nearly_signals() -> None:
    """Any sign but a dot after a signal's name; who has called one channel right has called the others on purpose."""
    names = ["q_a", "TAU-b", "tau_s_c", "tau_s", "v a", "theta/d", "quality", "tau_applied_e", "force.a"]
    assert nearly_signals([*names, "q.a"]) == {}
    assert nearly_signals(names) == {
        "q_a": "q.a",
        "TAU-b": "tau.b",
        "tau_s_c": "tau_s.c",
        "v a": "v.a",
        "theta/d": "theta.d",
        "tau_applied_e": "tau_applied.e",
    }
