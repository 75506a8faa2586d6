"""Many runs over native threads: the same bits as one by one, and one that fails stands alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.effects import CoulombFriction
from flexdyn.simulation.solvers import DormandPrince, Rosenbrock, RungeKutta4, Solver, TimeStepping
from tests.arms import BENT, two_link
from tests.oracles.two_link import TwoLink
from tests.simulation.test_users_laws import MyFriction, Nonsense

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.1, 0.05))
SOLVERS: tuple[Solver, ...] = (
    DormandPrince(),
    DormandPrince(smoothing=0.05),
    Rosenbrock(),
    RungeKutta4(step=1e-3, smoothing=0.05),
    TimeStepping(),
)
SIGNALS = ("t", "q", "theta", "v", "omega", "tau", "tau_applied", "tau_s", "z")


def arm(level: float = 0.1) -> fd.FlexibleJointModel:
    """A two-link arm whose elbow sticks and slips."""
    return two_link(ARM, [CoulombFriction("elbow", side="motor", level=level)])


def same(one: fd.Run | fd.FlexdynError, other: fd.Run) -> None:
    """Bit for bit, counts and notes included."""
    assert isinstance(one, fd.Run), one
    for name in SIGNALS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (dict(one.stats), one.notes, one.solver) == (dict(other.stats), other.notes, other.solver)


def same_samples(one: fd.Samples | None, other: fd.Samples | None) -> None:
    """The same torques over time, or none in both."""
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        np.testing.assert_array_equal(one.t, other.t)
        np.testing.assert_array_equal(one.values, other.values)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
def test_each_run_is_the_one_it_is_alone(solver: Solver, threads: int) -> None:
    """The same bits as `simulate`, in the order of the lists, however many threads, for every kind of command."""
    reference = fd.Samples([0.0, 0.2], [[0.0, 1.5], [0.2, 1.7]], "linear")
    commands: list[Any] = [
        [0.3, 0.1],
        None,
        fd.Samples([0.0, 0.1, 0.2], [[0.1, 0.2], [-0.1, 0.3], [0.0, 0.0]]),
        fd.PD(reference, 10.0, 0.5),
        fd.Controller(lambda t, x: 5.0 * (0.1 - x.theta) - 0.2 * x.omega, rate=500),
    ]
    model = arm()
    runs = fd.simulate_many(model, commands, 0.2, solver, threads=threads, **BENT)
    assert len(runs) == len(commands)
    for run, command in zip(runs, commands, strict=True):
        alone = fd.simulate(model, command, 0.2, solver, **BENT)
        same(run, alone)
        assert isinstance(run, fd.Run)
        assert run.model is model
        same_samples(run.inputs.samples, alone.inputs.samples)


def test_lists_and_what_is_shared() -> None:
    """Lists of models, commands, solvers, starts and wrenches, entry by entry; numbers in a list are one value."""
    models = [arm(level) for level in (0.0, 0.1, 0.2)]
    solvers: list[Any] = [DormandPrince(), "auto", TimeStepping()]
    commands = [[0.1, 0.0], np.array([0.0, 0.2]), None]
    starts: list[Any] = [[0.0, 1.0], {"elbow": 0.5}, None]
    wrenches: list[Any] = [None, fd.FrameWrench("tool", [1.0, 0, 0, 0, 0, 0]), ()]
    lists = zip(models, commands, solvers, starts, wrenches, strict=True)
    runs = fd.simulate_many(
        models, commands, 0.1, solvers, q0=starts, external=wrenches, v0=[0.4, -0.3], rate=250.0, theta0="equilibrium"
    )
    for run, (model, command, solver, q0, wrench) in zip(runs, lists, strict=True):
        shared: dict[str, Any] = {"v0": [0.4, -0.3], "rate": 250.0, "theta0": "equilibrium"}
        same(run, fd.simulate(model, command, 0.1, solver, q0=q0, external=wrench, **shared))


def test_times_are_shared() -> None:
    """One grid of times holds for all runs."""
    times = [0.0, 0.03, 0.1]
    runs = fd.simulate_many([arm(), arm(0.2)], [0.1, 0.1], 0.1, times=times)
    for run in runs:
        assert isinstance(run, fd.Run)
        np.testing.assert_array_equal(run.t, times)


def raising(t: float, x: fd.State) -> list[float]:
    """A controller that divides by zero after 20 ms."""
    return [1.0 / (t < 0.02), 0.0]


@pytest.mark.parametrize("threads", [1, 2])
def test_a_failed_run_stands_in_its_place(threads: int) -> None:
    """Each failure is an error where its run would be, and says why; those between finish as they do alone."""
    good = arm()
    coarse = RungeKutta4(step=5e-2, smoothing=0.05)
    stiff = two_link(TwoLink(stiffness=(1e6, 1e6)))
    models: list[Any] = [good, stiff, good, "no model", good, good, good, good]
    runs: list[Any] = fd.simulate_many(
        models,
        [None, None, fd.Controller(raising), None, [1.0, 2.0, 3.0], None, fd.Controller(lambda t, x: [0.0]), None],
        1.0,
        [DormandPrince(), coarse, *[DormandPrince()] * 3, RungeKutta4(step=1e-3), *[DormandPrince()] * 2],
        threads=threads,
        **BENT,
    )
    alone = fd.simulate(good, None, 1.0, DormandPrince(), **BENT)
    same(runs[0], alone)
    same(runs[7], alone)
    diverged, broken, no_model, too_many, refused, short = runs[1:7]
    assert isinstance(diverged, fd.SimulationError)
    assert diverged.data["t"] < 1.0
    assert "take a smaller step" in str(diverged)
    assert isinstance(broken, fd.SimulationError)
    assert isinstance(broken.data["cause"], ZeroDivisionError)
    for error in (no_model, too_many, refused, short):
        assert isinstance(error, fd.InputError)
    for error in runs[1:7]:
        assert "\n" not in str(error)
    assert "FlexibleJointModel" in str(no_model)
    assert "command" in str(too_many)
    assert "smoothing" in str(refused)
    assert "2 finite torques" in str(short)


@pytest.mark.parametrize("solver", ["auto", DormandPrince()], ids=str)
def test_laws_in_python_run_on_every_thread(solver: Any) -> None:
    """The same bits as alone; one that cannot be computed stands in its place, also where ``auto`` looks at it."""
    mine = two_link(ARM, [MyFriction("shoulder", side="link", coefficient=0.3)])
    nonsense = two_link(ARM, [Nonsense("shoulder", side="link")])
    runs: list[Any] = fd.simulate_many([mine, nonsense, mine], None, 0.1, solver, threads=2, **BENT)
    alone = fd.simulate(mine, None, 0.1, solver, **BENT)
    same(runs[0], alone)
    same(runs[2], alone)
    assert isinstance(runs[1], fd.SimulationError)
    assert isinstance(runs[1].data["cause"], ValueError)
    assert runs[1].data["t"] == 0.0


def test_all_may_fail() -> None:
    """Nothing but errors is an answer, too."""
    runs = fd.simulate_many([arm(), arm()], None, 1.0, RungeKutta4(step=1e-3))
    assert all(isinstance(run, fd.InputError) for run in runs)


@pytest.mark.parametrize(
    "given",
    [
        {"models": [0, 0], "commands": [None, None, None]},
        {"models": [0, 0], "q0": [[0.0, 0.0]]},
        {"models": 0, "commands": [0.1, 0.2]},
        {"models": 0},
        {"models": []},
    ],
    ids=["commands", "starts", "numbers_alone", "no_list", "empty"],
)
def test_lists_that_do_not_fit_are_refused(given: dict[str, Any]) -> None:
    """Different lengths, no list at all: one line that names the lists."""
    model = arm()
    models = [model for _ in given["models"]] if isinstance(given["models"], list) else model
    others = {key: value for key, value in given.items() if key != "models"}
    with pytest.raises(fd.InputError, match="how many runs is not clear") as refused:
        fd.simulate_many(models, duration=0.1, **others)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "two"])
def test_a_number_of_threads_is_needed(threads: Any) -> None:
    """A count of threads is a whole number of 1 or more."""
    with pytest.raises(fd.InputError, match="threads"):
        fd.simulate_many([arm()], None, 0.1, threads=threads)


@pytest.mark.parametrize("duration", [None, 0.0, "long"])
def test_a_duration_that_is_none_fails_every_run(duration: Any) -> None:
    """What is wrong for each run is reported in each place."""
    runs = fd.simulate_many([arm(), arm()], None, duration)
    assert [type(run) for run in runs] == [fd.InputError] * 2
    assert all("duration" in str(run) for run in runs)


def test_runs_outlive_the_call() -> None:
    """What comes back is locked and whole, and gives its energy ledger."""
    runs = fd.simulate_many([arm()] * 3, [0.1, 0.2], 0.2, **BENT)
    for run in runs:
        assert isinstance(run, fd.Run)
        assert not run.q.flags.writeable
        assert run.energy.closes
