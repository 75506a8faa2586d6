"""A gear that loses one share where its motor drives and another where its load does: rest, self-locking, motion."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import CoulombFriction, DirectionalGearLoss, Effect, LoadDependentFriction
from tests.effects.arms import model_of, states
from tests.effects.dry_reference import integrate
from tests.effects.reference import Arm
from tests.effects.test_sticking import contact_of

Array = NDArray[np.float64]
EXACT = fd.solvers.DormandPrince(rtol=1e-10, atol=1e-12)
PENDULUM = Arm((400.0,), (1.0,), (0.5,), gravity=9.81)
LEFT, RIGHT = np.pi - 0.6, 0.6
"""Poses whose weights turn the joint either way."""


def weight(q: float) -> float:
    """What the transmission carries at rest [N m]."""
    return float(PENDULUM.bias([q], [0.0])[0])


def loaded(loss: Effect, q: float, tau: float, *more: Effect, solver: Any = EXACT, duration: float = 2.0) -> fd.Run:
    """Released with the spring wound so that it carries the link."""
    model = model_of(PENDULUM, [loss, *more])
    theta = q + weight(q) / PENDULUM.stiffness[0]
    return fd.simulate(model, [tau], duration, solver, rate=200, q0=[q], theta0=[theta])


@pytest.mark.parametrize("q", [LEFT, RIGHT], ids=["negative_load", "positive_load"])
@pytest.mark.parametrize("driven", [0.3, 1.0, 1.4])
def test_the_range_of_torques_that_hold(q: float, driven: float) -> None:
    """``(1 - driven) |load|`` to ``(1 + driving) |load|`` in the load's direction, to a millionth on either side."""
    loss, load = DirectionalGearLoss("shoulder", driving=0.2, driven=driven), weight(q)
    for bound, outwards in ((1.2 * load, np.sign(load)), ((1.0 - driven) * load, -np.sign(load))):
        inside, outside = (bound + sign * 1e-6 * abs(load) * outwards for sign in (-1.0, 1.0))
        held = loaded(loss, q, inside)
        assert (held.omega == 0.0).all()
        assert (held.theta == held.theta[0]).all()
        moved = loaded(loss, q, outside, duration=0.2)
        assert np.sign(moved.omega[-1, 0]) == outwards
    lower, upper = fd.holding_torques(model_of(PENDULUM, [loss]), [q])
    ends = sorted((1.2 * load, (1.0 - driven) * load))
    np.testing.assert_allclose([lower[0], upper[0]], ends, rtol=1e-9, atol=1e-9 * abs(load))


@pytest.mark.parametrize("solver", [EXACT, fd.solvers.Rosenbrock(), fd.solvers.TimeStepping(step=1e-3)])
@pytest.mark.parametrize("q", [LEFT, RIGHT])
def test_a_self_locking_gear_holds_any_load_without_its_motor(q: float, solver: Any) -> None:
    """To the last bit, while one that is just not self-locking lets it fall."""
    locked = loaded(DirectionalGearLoss("shoulder", driving=0.1, driven=1.001), q, 0.0, solver=solver)
    assert (locked.omega == 0.0).all()
    assert (locked.theta == locked.theta[0]).all()
    falls = loaded(DirectionalGearLoss("shoulder", driving=0.1, driven=0.9), q, 0.0, solver=solver)
    assert (falls.omega[-1] * np.sign(weight(q)) < -0.1).all()


@pytest.mark.parametrize(
    "tau",
    [
        pytest.param(-8.0, id="let_down", marks=pytest.mark.slow),
        pytest.param(0.0, id="motor_off"),
        pytest.param(0.7, id="too_weak", marks=pytest.mark.slow),
        pytest.param(9.0, id="lifted"),
    ],
)
@pytest.mark.parametrize("v0", [-2.0, 0.0])
def test_self_locking_in_motion(tau: float, v0: float) -> None:
    """Against SciPy, events located by it: set in motion by its load, the rotor is braked to rest and stays there."""
    loss = DirectionalGearLoss("shoulder", driving=0.1, driven=1.3)
    arm = dataclasses.replace(PENDULUM, effects=(loss,))
    times = np.linspace(0.0, 1.5, 76)
    theta = RIGHT + weight(RIGHT) / arm.stiffness[0]
    start: dict[str, Any] = {"q0": [RIGHT], "theta0": [theta], "v0": [v0], "omega0": [v0]}
    run = fd.simulate(model_of(arm), [tau], times[-1], EXACT, times=times, **start)
    expected, _ = integrate(contact_of(arm, "motor", tau), [RIGHT, theta, v0, v0], times, max_step=5e-3)
    np.testing.assert_allclose(states(run), expected, atol=1e-7)
    if tau == 0.0:
        assert run.omega[-1, 0] == 0.0


@pytest.mark.parametrize(
    "solver",
    [
        EXACT,
        fd.solvers.Rosenbrock(rtol=1e-7, atol=1e-9),
        fd.solvers.TimeStepping(step=1e-3),
        fd.solvers.RungeKutta4(step=1e-4, smoothing=1e-2),
    ],
    ids=lambda solver: type(solver).__name__,
)
def test_equal_shares_are_load_dependent_friction(solver: Any) -> None:
    """Bit for bit, in every solver, in a motion that stops and breaks away."""
    runs = [
        fd.simulate(model_of(PENDULUM, [loss]), [3.0], 4.0, solver, rate=200, q0=[-0.9])
        for loss in (
            DirectionalGearLoss("shoulder", driving=0.17, driven=0.17),
            LoadDependentFriction("shoulder", coefficient=0.17),
        )
    ]
    np.testing.assert_array_equal(states(runs[0]), states(runs[1]))
    assert dict(runs[0].stats) == dict(runs[1].stats)
    assert np.ptp(runs[0].q) > 0.3


def test_time_stepping_and_rosenbrock_converge_to_the_exact_motion() -> None:
    """The first in proportion to its step, the second to its tolerance; through several stops."""
    effects = [
        DirectionalGearLoss("shoulder", driving=0.1, driven=0.35),
        CoulombFriction("shoulder", side="motor", level=0.1),
    ]
    command = fd.Samples(np.linspace(0.0, 4.0, 401), 4.0 * np.sin(2.0 * np.linspace(0.0, 4.0, 401))[:, None])

    def q_of(solver: Any) -> Array:
        return fd.simulate(model_of(PENDULUM, effects), command, 4.0, solver, rate=100, q0=[-1.2]).q

    exact = q_of(EXACT)
    errors = [np.abs(q_of(fd.solvers.TimeStepping(step=h)) - exact).max() for h in (4e-4, 2e-4, 1e-4)]
    assert errors[2] < 5e-3
    assert 1.7 < errors[0] / errors[1] < 2.3
    assert 1.7 < errors[1] / errors[2] < 2.3
    assert np.abs(q_of(fd.solvers.Rosenbrock(rtol=1e-8, atol=1e-10)) - exact).max() < 1e-5


def test_efficiencies_of_lifting_and_letting_down() -> None:
    """Of what goes through the gear a share `driving` is lost on the way up, and a share `driven` on the way down."""
    loss = DirectionalGearLoss("shoulder", driving=0.2, driven=0.5)
    for tau, way in ((1.6 * weight(RIGHT), 1.0), (-1.0, -1.0)):
        model = model_of(PENDULUM, [loss])
        theta = RIGHT + weight(RIGHT) / PENDULUM.stiffness[0]
        run = fd.simulate(model, [tau], 0.5, EXACT, rate=4000, q0=[RIGHT], theta0=[theta])
        carried = run.tau_s[:, 0] * run.omega[:, 0]
        power = np.where(carried > 0.0, 0.2, -0.5) * carried
        lost = run.energy.dissipated["directional_gear_loss.shoulder.motor"]
        assert lost[-1] == pytest.approx(float(np.trapezoid(power, run.t)), rel=1e-5)
        assert way * float(np.trapezoid(carried, run.t)) > 1.0
        assert np.abs(run.energy.residual).max() < 1e-8


def test_a_gear_without_load_has_no_loss() -> None:
    """In a plane without weight the rotor starts under the smallest torque."""
    weightless = dataclasses.replace(PENDULUM, gravity=0.0)
    model = model_of(weightless, [DirectionalGearLoss("shoulder", driving=0.5, driven=2.0)])
    run = fd.simulate(model, [1e-6], 1.0, EXACT, rate=100)
    assert run.omega[1, 0] > 0.0


def test_many_runs_are_the_single_ones() -> None:
    """Native threads give the same bits."""
    losses = [DirectionalGearLoss("shoulder", driving=a, driven=b) for a, b in ((0.1, 0.4), (0.3, 1.2), (0.0, 0.2))]
    models = [model_of(PENDULUM, [loss]) for loss in losses]
    many = fd.simulate_many(models, [3.0], duration=1.0, solver=EXACT, rate=100, q0=[-0.9])
    for model, run in zip(models, many, strict=True):
        one = fd.simulate(model, [3.0], 1.0, EXACT, rate=100, q0=[-0.9])
        assert isinstance(run, fd.Run)
        np.testing.assert_array_equal(states(run), states(one))
