"""The driver: first states, grids of samples, what is written at jumps, replayed recordings, failures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import EXACT, repickled, slider, state, two_link, unlisted
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
HEAVY = TwoLink(stiffness=(80.0, 50.0), damping=(0.5, 0.3), gravity=9.81)


@pytest.fixture(scope="module")
def model() -> fd.FlexibleJointModel:
    """A smooth elastic two-link arm."""
    return two_link(ARM, initial={"q": {"elbow": 1.0}, "v": {"elbow": 0.2}})


def test_the_first_state(model: fd.FlexibleJointModel) -> None:
    """Arguments stand over the model's own; theta starts at q and omega at v unless they are given."""
    plain = fd.simulate(model, None, 0.1)
    np.testing.assert_array_equal(state(plain)[0], [0, 1, 0, 1, 0, 0.2, 0, 0.2])
    by_name = fd.simulate(model, None, 0.1, q0={"shoulder": 0.5}, omega0={"elbow": 0.3})
    np.testing.assert_array_equal(state(by_name)[0], [0.5, 1, 0.5, 1, 0, 0.2, 0, 0.3])
    by_list = fd.simulate(model, None, 0.1, q0=[1, 2], v0=[3, 4], theta0=[5, 6], omega0=[7, 8])
    np.testing.assert_array_equal(state(by_list)[0], [1, 2, 5, 6, 3, 4, 7, 8])


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"q0": [1.0]}, "q0: 2 finite numbers are needed"),
        ({"q0": [1.0, math.nan]}, "q0: 2 finite numbers are needed"),
        ({"v0": "fast"}, "v0: numbers are needed"),
        ({"q0": "equilibrium"}, "q0: numbers are needed"),
        ({"theta0": "balanced"}, "theta0: numbers are needed"),
        ({"q0": {"elbow": "bent"}}, "q0.elbow: a finite number is needed"),
        ({"q0": [10**400, 0]}, "q0: numbers are needed"),
        ({"q0": {"elbow": 10**400}}, "q0.elbow: a finite number is needed"),
        ({"duration": None}, "duration: the duration is missing"),
        ({"duration": 0}, "duration: a time above 0 s is needed"),
        ({"duration": -1.0}, "duration: a time above 0 s is needed"),
        ({"duration": math.inf}, "duration: a time above 0 s is needed"),
        ({"duration": 10**400}, "duration: a time above 0 s is needed"),
        ({"duration": "5 s"}, "duration: a time above 0 s is needed"),
        ({"duration": True}, "duration: a time above 0 s is needed"),
        ({"rate": 0}, "rate: a rate above 0 Hz is needed"),
        ({"rate": 1e12}, "rate: more than "),
        ({"times": []}, "times: times must lie between 0 and the duration, 1 s"),
        ({"times": [0.5, 1.5]}, "times: times must lie between 0 and the duration"),
        ({"times": [-0.5, 0.5]}, "times: times must lie between 0 and the duration"),
        ({"times": [0.5, 0.5]}, "times: times must increase"),
        ({"times": [0.0, math.nan]}, "times: times must lie between"),
        ({"times": ["a"]}, "times: times are numbers"),
        ({"times": 0.5}, "times: times must lie between"),
        ({"model": "panda"}, "model: a FlexibleJointModel is needed, got 'panda'; use fd.load_model(...)"),
    ],
)
def test_an_argument_without_sense(model: fd.FlexibleJointModel, settings: dict[str, Any], words: str) -> None:
    """One line that names the argument."""
    given: dict[str, Any] = {"model": model, "duration": 1.0} | settings
    with pytest.raises(fd.InputError) as caught:
        fd.simulate(**given)
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value)


def test_rotors_of_rigid_joints_are_their_links() -> None:
    """A first theta away from q on a rigid joint is refused; one that agrees is not."""
    rigid = two_link(TwoLink(stiffness=(30.0, math.inf)))
    with pytest.raises(fd.InputError, match=r"^theta0\.elbow: the joint is rigid: theta is q, got 0\.3"):
        fd.simulate(rigid, None, 0.1, theta0=[0.1, 0.3])
    with pytest.raises(fd.InputError, match=r"^omega0\.elbow: the joint is rigid: omega is v"):
        fd.simulate(rigid, None, 0.1, omega0={"elbow": 0.3})
    run = fd.simulate(rigid, None, 0.1, q0=[0.0, 0.3], theta0=[0.1, 0.3])
    np.testing.assert_array_equal(run.theta[0], [0.1, 0.3])


def test_loaded_springs_hold_the_arm_at_rest() -> None:
    """theta0="equilibrium" with the holding torque G(q): nothing moves for ten seconds."""
    model = two_link(HEAVY)
    q0 = [-1.2, -0.4]
    run = fd.simulate(model, list(HEAVY.weight(*q0)), 10.0, EXACT, q0=q0, theta0="equilibrium")
    assert np.abs(run.q - q0).max() < 1e-9
    assert np.abs(run.v).max() < 1e-9
    np.testing.assert_allclose(run.tau_s, np.broadcast_to(HEAVY.weight(*q0), run.tau_s.shape), atol=1e-8)


@pytest.mark.parametrize(
    ("duration", "rate", "count"),
    [(1.0, 1000.0, 1001), (0.3, 10.0, 4), (1.0004, 1000.0, 1001), (0.0004, 1000.0, 2), (0.7, 3.0, 3), (2.0, 0.1, 2)],
)
def test_the_grid_of_samples(model: fd.FlexibleJointModel, duration: float, rate: float, count: int) -> None:
    """Uniform, both ends included, whether or not the duration is a multiple of the period."""
    run = fd.simulate(model, None, duration, rate=rate)
    assert len(run.t) == count
    assert run.t[0] == 0.0
    assert run.t[-1] == pytest.approx(duration, rel=1e-12)
    np.testing.assert_allclose(np.diff(run.t), duration / (count - 1), rtol=1e-9)


def test_sampled_at_times(model: fd.FlexibleJointModel) -> None:
    """The same states as on a grid, at exactly the times asked for."""
    run = fd.simulate(model, [0.1, 0.1], 1.0, rate=100)
    some = fd.simulate(model, [0.1, 0.1], 1.0, times=[0.13, 0.5, 0.77])
    np.testing.assert_array_equal(some.t, [0.13, 0.5, 0.77])
    np.testing.assert_array_equal(some.q, run.q[[13, 50, 77]])


@pytest.mark.parametrize("solver", [fd.solvers.DormandPrince(), fd.solvers.RungeKutta4(step=7e-4)])
def test_torque_is_right_continuous(model: fd.FlexibleJointModel, solver: fd.solvers.Solver) -> None:
    """A sample on a jump has the torque after it; the last sample has the command's last; then there is none."""
    command = fd.Samples([0.0, 0.1, 0.2], [[1.0, -1.0], [2.0, -2.0], [3.0, -3.0]])
    run = fd.simulate(model, command, 0.3, solver, rate=100)
    np.testing.assert_array_equal(run.tau[:, 0], [1.0] * 10 + [2.0] * 10 + [0.0] * 11)
    np.testing.assert_array_equal(run.tau_applied, run.tau)
    ends = fd.simulate(model, command, None, solver, rate=100)
    assert ends.t[-1] == pytest.approx(0.2)
    np.testing.assert_array_equal(ends.tau[-1], [3.0, -3.0])
    np.testing.assert_array_equal(ends.q, run.q[:21])


def test_a_command_may_start_late(model: fd.FlexibleJointModel) -> None:
    """The run starts at the command's first sample, wherever its clock stood."""
    values = np.random.default_rng(0).normal(size=(5, 2))
    runs = [fd.simulate(model, fd.Samples(start + 0.25 * np.arange(5), values)) for start in (0.0, 64.0)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_torque_that_does_not_change(model: fd.FlexibleJointModel) -> None:
    """N numbers, one number for all, or a mapping by joint last as long as the run."""
    runs = [fd.simulate(model, c, 0.5) for c in ([0.2, 0.2], 0.2, {"shoulder": 0.2, "elbow": 0.2})]
    for run in runs:
        assert (run.tau == 0.2).all()
        np.testing.assert_array_equal(run.q, runs[0].q)


def test_progress_and_its_exceptions(model: fd.FlexibleJointModel) -> None:
    """Progress hears rising times, and what it raises stops a run that would last for days."""
    times: list[float] = []

    def watch(t: float) -> None:
        times.append(t)
        if len(times) == 3:
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        fd.simulate(model, None, 1e9, fd.solvers.RungeKutta4(step=1e-4), rate=1e-6, progress=watch)
    assert 0 < times[0] < times[1] < times[2] < 1e9


@pytest.mark.parametrize("solver", [fd.solvers.RungeKutta4(step=0.01), fd.solvers.DormandPrince()])
def test_a_motion_that_cannot_go_on(tmp_path: Path, solver: fd.solvers.Solver) -> None:
    """A SimulationError with time, state and reason, that pickles; never a run with NaN in it."""
    model = two_link(TwoLink(stiffness=(1e7, 1e7)))
    command: Any = [0.1, 0.1]
    if isinstance(solver, fd.solvers.DormandPrince):
        model = fd.FlexibleJointModel(slider(tmp_path), effects=[Explosive("lift")])
        command = None
    with pytest.raises(fd.SimulationError, match=r"stopped at t = ") as caught:
        fd.simulate(model, command, 5.0, solver, v0=np.ones(model.n))
    error = repickled(caught.value)
    assert 0.0 <= error.t < 5.0
    assert len(error.state) == 2 * (model.n + model.elastic.sum())
    assert error.reason
    assert error.solver == solver
    assert np.isfinite(error.state).all()


@unlisted
class Explosive(fd.effects.JointEffect):
    """Negative drag with the square of the speed: infinite speed in finite time."""

    sides = ("link",)
    stage = "friction"

    def torque(self, x: Any, u: Any, *, t: Any = 0.0, tau: Any = 0.0) -> Any:
        """Minus 5 u |u|."""
        return -5.0 * u * abs(u) if abs(u) < 1e150 else math.nan
