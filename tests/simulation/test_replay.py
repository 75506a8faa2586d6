"""Recordings as commands: a run fed back into its model reproduces itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import BENT, slider, state, two_link
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
SOLVERS = [fd.solvers.DormandPrince(), fd.solvers.RungeKutta4(step=3e-4)]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("suffix", [None, ".csv", ".npz", ".h5"])
def test_round_trip(tmp_path: Path, solver: fd.solvers.Solver, suffix: str | None) -> None:
    """Recorded torque and first state give the same run bit for bit, from memory and from every format."""
    model = two_link(ARM)
    command = fd.Samples(np.arange(501) / 1000, np.random.default_rng(1).normal(0, 0.5, (501, 2)))
    run = fd.simulate(model, command, None, solver, theta0=[0.1, 1.6], omega0=[0.0, 0.1], **BENT)
    source: fd.Recording | Path = run.to_recording()
    if suffix:
        source = tmp_path / f"run{suffix}"
        run.save(source)
    again = fd.simulate(model, source, None, solver)
    np.testing.assert_array_equal(state(again), state(run))
    np.testing.assert_array_equal(again.tau, run.tau)
    np.testing.assert_array_equal(again.t, run.t)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_controlled_run_replayed_without_its_controller(solver: fd.solvers.Solver) -> None:
    """The torque of a PD run at 1 kHz, replayed open loop, moves the arm alike."""
    model = two_link(ARM)
    t = np.linspace(0, 1, 11)
    path = fd.Samples(t, np.column_stack([np.sin(t), 1.5 + 0.3 * t]), "cubic")
    run = fd.simulate(model, fd.PD(path, 20.0, 3.0), 1.0, solver)
    again = fd.simulate(model, run.to_recording(), None, solver)
    np.testing.assert_allclose(state(again), state(run), atol=1e-12)


def test_one_encoder_is_enough() -> None:
    """With theta or q measured alone, link and rotor start alike; velocities not measured start at zero."""
    model = two_link(ARM, initial={"q": {"shoulder": 0.9}, "v": {"shoulder": 0.9}})
    t = np.linspace(0, 0.1, 11)
    channels = {"tau.shoulder": 0 * t + 0.1, "tau.elbow": 0 * t, "theta.shoulder": 0.3 + t, "q.elbow": 0.7 + t}
    run = fd.simulate(model, fd.Recording(t, channels))
    np.testing.assert_array_equal(state(run)[0][:4], [0.3, 0.7, 0.3, 0.7])
    over = fd.simulate(model, fd.Recording(t, channels), q0=[0.0, 0.0], theta0=[0.0, 0.1])
    np.testing.assert_array_equal(state(over)[0][:4], [0.0, 0.0, 0.0, 0.1])


def test_an_elastic_run_drives_the_rigid_arm() -> None:
    """A rigid joint has one position: a recorded theta away from q does not stand in its way."""
    elastic = two_link(ARM)
    run = fd.simulate(elastic, [0.5, 0.2], 0.5, theta0=[0.1, 1.6], **BENT)
    rigid = fd.simulate(elastic.rigid(), run.to_recording())
    np.testing.assert_array_equal(rigid.q[0], run.q[0])
    np.testing.assert_array_equal(rigid.theta, rigid.q)
    np.testing.assert_array_equal(rigid.tau, run.tau)


def test_a_recording_that_does_not_fit() -> None:
    """A joint that the robot lacks, and a recording without torque, are clear lines."""
    t = np.linspace(0, 1, 11)
    with pytest.raises(
        fd.InputError, match="wrist: the robot has no such joint; the robot's joints are shoulder, elbow"
    ):
        fd.simulate(two_link(ARM), fd.Recording(t, {"tau.wrist": t}))
    with pytest.raises(fd.InputError, match=r"no tau in this recording; columns named tau\.JOINT are needed"):
        fd.simulate(two_link(ARM), fd.Recording(t, {"q.elbow": t}))


def test_a_run_of_a_robot_without_urdf_is_saved_too(tmp_path: Path) -> None:
    """A pin.Model has no file to name, and its runs are recordings all the same; forces of a slider read N."""
    robot = fd.load_robot(slider(tmp_path).pin_model, name="bare")
    run = fd.simulate(fd.FlexibleJointModel(robot), [20.0], 0.1)
    run.save(tmp_path / "run.npz")
    recording = fd.read_recording(tmp_path / "run.npz")
    np.testing.assert_array_equal(recording["q.lift"], run.q[:, 0])
    assert (recording.unit("tau.lift"), recording.unit("q.lift")) == ("N", "m")
    assert "model" not in recording.meta
