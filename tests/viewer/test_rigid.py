"""The translucent arm without elasticity: the same torques and start, simulated with rigid joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
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
    assert [note.rpartition(": ")[2] for note in ghost.notes] == ["shoulder", "shoulder, elbow"]


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
