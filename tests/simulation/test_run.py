"""Run: locked arrays that pickle, what is computed from them, and how much memory they take."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.simulation.inputs_and_signals import SIGNALS
from tests.arms import repickled, slider


@pytest.fixture(scope="module")
def run() -> fd.Run:
    """The paper's arm, driven for half a second."""
    return fd.simulate(fd.load_model("scara_two_link"), [0.3, 0.2], 0.5, theta0=[0.1, 1.6])


def test_a_run_cannot_be_overwritten(run: fd.Run) -> None:
    """Neither its arrays nor its attributes nor its statistics."""
    for name in ("t", *SIGNALS):
        with pytest.raises(ValueError, match="read-only"):
            getattr(run, name)[0] = 1.0
    with pytest.raises(AttributeError):
        run.q = run.v  # type: ignore[misc]
    with pytest.raises(TypeError):
        run.stats["steps"] = 0  # type: ignore[index]


def test_a_run_pickles(run: fd.Run) -> None:
    """Everything in it arrives, and is locked there too."""
    again = repickled(run)
    for name in ("t", *SIGNALS):
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name))
        assert not getattr(again, name).flags.writeable
    assert (again.model, again.solver, again.notes) == (run.model, run.solver, run.notes)
    assert dict(again.stats) == dict(run.stats)
    np.testing.assert_array_equal(again.energy.mechanical, run.energy.mechanical)


def test_a_run_describes_itself(run: fd.Run) -> None:
    """Shapes, joints, deflection and one line for the prompt."""
    assert run.q.shape == (501, 2)
    assert run.joint_names == ("shoulder", "elbow")
    np.testing.assert_array_equal(run.deflection, run.theta - run.q)
    assert repr(run) == f"<Run scara_two_link: 0.5 s, 501 samples, DormandPrince, {run.stats['steps']} steps>"
    assert set(run.stats) == {"steps", "rejected", "evaluations", "events"}
    assert run.stats["evaluations"] > 6 * run.stats["steps"]


def test_where_the_tool_goes(run: fd.Run) -> None:
    """Forward kinematics of two links of 1.05 m, by default of the last frame; the base stays."""
    angle = run.q.sum(axis=1)
    x = 1.05 * np.column_stack([np.cos(run.q[:, 0]) + np.cos(angle), np.sin(run.q[:, 0]) + np.sin(angle)])
    np.testing.assert_allclose(run.frame_positions()[:, :2], x, atol=1e-12)
    np.testing.assert_array_equal(run.frame_positions("tool"), run.frame_positions())
    assert (run.frame_positions("base") == 0.0).all()
    with pytest.raises(fd.InputError, match="no such frame, got 'tol'; did you mean 'tool'"):
        run.frame_positions("tol")


def test_what_the_transmission_carries(run: fd.Run) -> None:
    """tau_s = K (theta - q) + D (omega - v) on elastic joints."""
    model = run.model
    np.testing.assert_allclose(
        run.tau_s, model.stiffness * run.deflection + model.damping * (run.omega - run.v), atol=1e-12
    )


def test_what_a_rigid_gear_carries(tmp_path: Path) -> None:
    """tau_s = tau_applied - f_motor - J a on a rigid joint: with an offset, friction and a rotor, in closed form."""
    effects = [
        fd.effects.TorqueOffset("lift", offset=3.0),
        fd.effects.ViscousFriction("lift", side="motor", coefficient=4.0),
        fd.effects.ViscousFriction("lift", side="link", coefficient=2.0),
    ]
    model = fd.FlexibleJointModel(slider(tmp_path), {"lift": {"rotor_inertia": 1.5}}, effects)
    run = fd.simulate(model, [30.0], 1.0, v0=[0.4])
    acceleration = (33.0 - 6.0 * run.v - 2.5 * 9.81) / 4.0
    assert (run.tau == 30.0).all()
    assert (run.tau_applied == 33.0).all()
    np.testing.assert_allclose(run.tau_s, 33.0 - 4.0 * run.v - 1.5 * acceleration, rtol=1e-12)
    np.testing.assert_allclose(run.tau_s, 2.5 * (acceleration + 9.81) + 2.0 * run.v, rtol=1e-12)


def test_the_last_sample_feels_the_last_force(tmp_path: Path) -> None:
    """A force whose samples end with the run acts in its last sample too, as the last torque does."""
    lift = fd.FrameWrench("mass", fd.Samples([0.0, 0.5, 1.0], np.tile([0.0, 0.0, 5.0, 0.0, 0.0, 0.0], (3, 1))))
    model = fd.FlexibleJointModel(slider(tmp_path), {"lift": {"rotor_inertia": 1.5}})
    run = fd.simulate(model, [30.0], 1.0, external=lift, rate=10)
    np.testing.assert_allclose(run.tau_s, 30.0 - 1.5 * (35.0 - 2.5 * 9.81) / 4.0, rtol=1e-12)


def test_a_run_is_a_recording(run: fd.Run) -> None:
    """Every signal of every joint, with solver, notes and the model as text that reads back."""
    recording = run.to_recording()
    assert set(recording.channels) == {f"{signal}.{joint}" for signal in SIGNALS for joint in run.joint_names}
    np.testing.assert_array_equal(recording.signal("tau_s", run.joint_names), run.tau_s)
    assert recording.meta["solver"]["name"] == "DormandPrince"
    assert tuple(recording.meta["notes"]) == run.notes


def test_the_model_in_a_recording_reads_back(run: fd.Run, tmp_path: Path) -> None:
    """Saved with the run, it is the model that ran."""
    run.save(tmp_path / "run.h5")
    (tmp_path / "scara_two_link.yaml").write_text(fd.read_recording(tmp_path / "run.h5").meta["model"])
    assert fd.load_model(tmp_path / "scara_two_link.yaml") == run.model


def test_a_format_that_is_not_there_is_refused(run: fd.Run, tmp_path: Path) -> None:
    """And leaves nothing behind."""
    with pytest.raises(fd.InputError, match=r"run\.docx"):
        run.save(tmp_path / "run.docx")
    with pytest.raises(fd.InputError, match="no such folder"):
        run.save(tmp_path / "nowhere" / "run.csv")
    assert list(tmp_path.iterdir()) == []


MEMORY = """
import resource
import numpy as np
import flexdyn as fd

model = fd.load_model("panda")
fd.simulate(model, None, 0.01, theta0="equilibrium")
pose = np.array([0, -0.8, 0, -2.4, 0, 1.6, 0.8])
path = fd.Samples([0.0, 30.0, 60.0], pose + 0.1 * np.arange(3)[:, None], "cubic")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
run = fd.simulate(model, fd.PD(path, 600.0, 60.0), 60.0, fd.solvers.RungeKutta4(step=1e-3, smoothing=0.1), rate=1000)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
stored = run.t.nbytes + sum(getattr(run, name).nbytes for name in fd.simulation.inputs_and_signals.SIGNALS)
print(len(run.t), run.q.shape[1], stored, 1024 * (after - before))
"""


@pytest.mark.skipif(sys.platform == "darwin", reason="ru_maxrss counts bytes there")
def test_memory_of_a_minute_of_seven_joints() -> None:
    """Stored at 1 kHz it adds under 60 MB to the process, most of it the arrays themselves."""
    done = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True)
    samples, joints, stored, added = map(int, done.stdout.split())
    assert (samples, joints) == (60_001, 7)
    assert stored < 30e6
    assert added < 60e6
