"""The translucent arm without elasticity: the same torques and start, simulated with rigid joints."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.viewer.rigid import LAW_AGAIN, OPEN_LOOP
from flexdyn.viewer.sources import first, second
from tests.viewer.arms import swinging, two_link_run


def moving_run() -> fd.Run:
    """An arm that starts bent and in motion and is pushed on."""
    push = fd.Samples([0.0, 0.1, 0.2, 0.3], {"elbow": [0.2, -0.1, 0.3, 0.0]})
    return fd.simulate(fd.load_model("scara_two_link"), push, q0=[0.3, -0.4], v0=[0.5, -1.0])


def test_a_run_beside_the_rigid_arm_under_its_torques() -> None:
    """Positions are those of the rigid model, driven by the run's recording from the run's first state."""
    run = moving_run()
    ghost = second("rigid", None, first(run, None))
    expected = fd.simulate(run.model.rigid(), run.to_recording(), q0=run.q[0], v0=run.v[0])
    assert np.array_equal(ghost.t, run.t)
    assert np.array_equal(ghost.q, expected.q)
    assert np.abs(ghost.q - run.q).max() > 1e-3
    assert np.isnan(ghost.deflection).all()
    assert ghost.label == "scara_two_link, rigid"
    assert ghost.notes == ()


def test_a_recording_beside_the_rigid_arm() -> None:
    """As its run, also where its clock does not start at zero; the page's times are the recording's."""
    run = moving_run()
    rec = run.to_recording().trim(0.1, 0.3)
    ghost = second("rigid", None, first(rec, None))
    expected = fd.simulate(run.model.rigid(), rec, q0=run.q[100], v0=run.v[100])
    assert ghost.t.tolist() == rec.t.tolist()
    assert ghost.q == pytest.approx(expected.q, abs=1e-9)
    assert ghost.q[0].tolist() == run.q[100].tolist()


def test_what_a_recording_does_not_hold_is_said() -> None:
    """No torque where none was recorded, no velocity but the model's, and the page says both."""
    run = moving_run()
    rec = fd.Recording(run.t, {name: run.to_recording()[name] for name in ("q.shoulder", "q.elbow", "tau.elbow")})
    ghost = second("rigid", None, first(rec, run.model))
    expected = fd.simulate(run.model.rigid(), rec, q0=run.q[0], v0=[0.0, 0.0])
    assert np.array_equal(ghost.q, expected.q)
    assert ghost.notes[0] == OPEN_LOOP
    assert [note.rpartition(": ")[2] for note in ghost.notes[1:]] == ["shoulder", "shoulder, elbow"]


def tracked(**changes: Any) -> fd.PD:
    """A controller of the two-link arm; its gravity is none, so the arms differ by their springs alone."""
    wanted = np.array([[0.3, -0.4], [0.6, 0.4], [0.3, -0.4]])
    return fd.PD(fd.Samples([0.0, 0.2, 0.4], wanted, "cubic"), kp=40.0, kd=2.0, **changes)


@pytest.mark.parametrize("kind", ["pd", "servo", "controller"])
def test_a_controller_runs_on_the_rigid_arm(kind: str) -> None:
    """Its torques there are its own: replayed ones would lead elsewhere."""
    pd, model = tracked(), fd.load_model("scara_two_link")
    commands = {
        "pd": pd,
        "servo": fd.Servo(reference=pd.reference, position_gain=20.0, velocity_gain=2.0),
        "controller": fd.Controller(lambda t, state: 40.0 * ([0.4, 0.1] - state.theta) - 2.0 * state.omega),
    }
    run = fd.simulate(model, commands[kind], duration=0.4, q0=[0.3, -0.4], v0=[0.2, 0.0])
    ghost = second("rigid", None, first(run, None))
    expected = fd.simulate(model.rigid(), commands[kind], duration=0.4, q0=[0.3, -0.4], v0=[0.2, 0.0])
    replayed = fd.simulate(model.rigid(), run.to_recording(), q0=run.q[0], v0=run.v[0])
    assert np.array_equal(ghost.q, expected.q)
    assert np.abs(ghost.q - replayed.q).max() > 5e-3
    assert ghost.label == "scara_two_link, rigid, under the controller"
    assert ghost.notes == ((LAW_AGAIN,) if kind == "controller" else ())


def test_a_controller_starts_where_the_run_started() -> None:
    """Also where the run's first sample is later."""
    model, times = fd.load_model("scara_two_link"), np.linspace(0.1, 0.4, 31)
    run = fd.simulate(model, tracked(), duration=0.4, q0=[0.3, -0.4], times=times)
    ghost = second("rigid", None, first(run, None))
    expected = fd.simulate(model.rigid(), tracked(), duration=0.4, q0=[0.3, -0.4], times=times)
    assert np.array_equal(ghost.q, expected.q)
    assert np.array_equal(ghost.t, times)


def test_a_recording_of_a_controlled_run_says_that_its_torques_are_replayed() -> None:
    """It does not hold its controller; given one, that runs on the rigid arm."""
    run = fd.simulate(fd.load_model("scara_two_link"), tracked(), duration=0.4, q0=[0.3, -0.4])
    shown = first(run.to_recording(), None)
    ghost = second("rigid", None, shown)
    assert ghost.notes == (OPEN_LOOP,)
    assert ghost.label.endswith("in open loop")
    held = second("rigid", None, shown, tracked())
    assert np.array_equal(held.q, second("rigid", None, first(run, None)).q)
    with pytest.raises(fd.InputError, match=r"command.*arm without elasticity alone"):
        second(run, None, shown, tracked())
    with pytest.raises(fd.InputError, match=r"command.*no second arm"):
        fd.play(run, command=tracked(), html="no.html")


def test_runs_of_controllers_pickle() -> None:
    """With the controller, unless it is a law that does not pickle."""
    model = fd.load_model("scara_two_link")
    for command, kept in ((tracked(), True), (fd.Controller(lambda t, state: [0.0, 0.0]), False)):
        run = fd.simulate(model, command, duration=0.01)
        assert run.inputs.controller is command
        again = pickle.loads(pickle.dumps(run))  # noqa: S301
        assert (again.inputs.controller is not None) == kept
        assert np.array_equal(again.q, run.q)


def test_forces_at_frames_are_not_applied() -> None:
    """A run's wrench does not act on the rigid arm, and the page says so."""
    push = fd.FrameWrench("tool", [0.0, 0.5, 0.0, 0.0, 0.0, 0.0])
    run = fd.simulate(fd.load_model("scara_two_link"), duration=0.1, external=push)
    ghost = second("rigid", None, first(run, None))
    assert (ghost.q == run.q[0]).all()
    assert np.ptp(run.q) > 1e-4
    assert ghost.notes == ("forces at frames are not applied to the rigid arm",)


def test_the_page_shows_it(tmp_path: Path) -> None:
    """Named in the legend, as the rigid arm."""
    fd.play(two_link_run(), "rigid", html=tmp_path / "page.html")
    assert "translucent: scara_two_link, rigid" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_an_arm_of_any_robot() -> None:
    """Joints that slide and mimics go along."""
    run = swinging(fd.load_model("scara"), duration=0.05)
    ghost = second("rigid", None, first(run, None))
    assert np.array_equal(ghost.q, fd.simulate(run.model.rigid(), run.to_recording(), q0=run.q[0], v0=run.v[0]).q)


def test_mistakes() -> None:
    """A model has no torques, a recording may have none, and one sample is no motion."""
    run, model = moving_run(), fd.load_model("scara_two_link")
    rec = run.to_recording()
    still = fd.Recording(run.t, {name: rec[name] for name in ("q.shoulder", "q.elbow")})
    for source, match in (
        (model, r"compare.*a model alone has no torques.*give a run or a recording"),
        (still, r"channels.*no tau of any joint of the arm.*tau\.shoulder"),
        (fd.simulate(model, duration=0.1, times=[0.05]), r"one sample is no motion"),
    ):
        with pytest.raises(fd.InputError, match=match):
            second("rigid", model, first(source, model))
