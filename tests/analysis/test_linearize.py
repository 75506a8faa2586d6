"""Linear models against differences of independent equations, closed forms and the nonlinear motion."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import lsim

import flexdyn as fd
from flexdyn.simulation.plant import build_plant
from tests.analysis.arms import DAMPER, MASS, ROTOR, SPRING, WEIGHT, two_mass
from tests.arms import EXACT, state, two_link
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
HANGING = TwoLink(stiffness=(30.0, 20.0), damping=(0.2, 0.1), rotor=(0.2, 0.1), gravity=9.81)


def differences(model: fd.FlexibleJointModel, x: Array, tau: Array) -> tuple[Array, Array]:
    """A and B by central differences of the plant's x', its dry friction sliding."""
    plant = build_plant(model)

    def rate(x: Array, tau: Array) -> Array:
        out = np.empty(len(x))
        plant.derivative(0.0, x, tau, 1e-4, out)
        return out

    h, g = 1e-5, 1e-3
    A = [(rate(x + e, tau) - rate(x - e, tau)) / (2.0 * h) for e in h * np.eye(len(x))]
    B = [(rate(x, tau + e) - rate(x, tau - e)) / (2.0 * g) for e in g * np.eye(model.n)]
    return np.array(A).T, np.array(B).T


@pytest.mark.parametrize("name", ["panda", "scara", "scara_two_link", "ur5"])
def test_shipped_arms_against_differences(name: str) -> None:
    """Every slope of a moving arm, friction sliding on its branch, is that of the difference quotient."""
    model = fd.load_model(name)
    random = np.random.default_rng(7)
    half = model.n + int(model.elastic.sum())
    q = random.uniform(-1.0, 1.0, model.n)
    theta = q[model.elastic] + random.uniform(-0.01, 0.01, int(model.elastic.sum()))
    speeds = random.uniform(0.1, 0.4, half) * random.choice([-1.0, 1.0], half)
    x, tau = np.concatenate([q, theta, speeds]), random.uniform(-0.1, 0.1, model.n)
    linear = fd.linearize(model, x, tau)
    A, B = differences(model, x, tau)
    np.testing.assert_allclose(linear.A, A, rtol=1e-6, atol=1e-9 * np.abs(A).max())
    np.testing.assert_allclose(linear.B, B, rtol=1e-8, atol=1e-10 * np.abs(B).max())
    rate = np.empty(len(x))
    build_plant(model).derivative(0.0, x, tau, 1e-4, rate)
    np.testing.assert_allclose(linear.rate0, rate, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("stiffness", [(30.0, 20.0), (math.inf, 20.0), (30.0, math.inf), (math.inf, math.inf)])
def test_two_links_against_differences_of_the_closed_form(stiffness: tuple[float, float]) -> None:
    """The paper's equations with gravity, mixtures of rigid and elastic joints, by differences of the oracle."""
    arm = TwoLink(stiffness=stiffness, damping=(0.2, 0.1), rotor=(0.2, 0.1), gravity=9.81)
    e = len(arm.elastic)
    q = np.array([0.4, -0.7])
    x = np.concatenate([q, q[list(arm.elastic)] + 0.05, [0.3, -0.2], np.full(e, 0.1)])
    tau, h = np.array([1.0, -0.5]), 1e-6

    def rate(x: Array, tau: Array) -> Array:
        return np.array(arm.derivative(x.tolist(), tau.tolist()))

    A = np.array([rate(x + d, tau) - rate(x - d, tau) for d in h * np.eye(len(x))]).T / (2.0 * h)
    B = np.array([rate(x, tau + d) - rate(x, tau - d) for d in h * np.eye(2)]).T / (2.0 * h)
    linear = fd.linearize(two_link(arm), x, tau)
    np.testing.assert_allclose(linear.A, A, atol=1e-6)
    np.testing.assert_allclose(linear.B, B, atol=1e-6)
    np.testing.assert_allclose(linear.rate0, rate(x, tau), atol=1e-10)


LAWS = [
    fd.effects.QuadraticDrag("shoulder", side="link", coefficient=0.3),
    fd.effects.WarmUpFriction("elbow", side="motor", coefficient=0.4, time_constant=3.0),
    fd.effects.AsymmetricFriction("elbow", side="link", level_positive=0.3, level_negative=0.2),
    fd.effects.PositionDependentFriction("elbow", side="motor", amplitude=0.3, harmonic=4.0, phase=0.2),
    fd.effects.LoadDependentFriction("shoulder", coefficient=0.2),
    fd.effects.JointCoupling("elbow", other="shoulder", coefficient=0.4),
    fd.effects.PreslidingFriction("elbow", side="link", level=0.5, stiffness=40.0, damping=0.3),
    fd.effects.SpringHysteresis("shoulder", stiffness=9.0, width=0.05),
    fd.effects.HardeningSpring("shoulder", cubic=700.0),
    fd.effects.Backlash("elbow", half_gap=0.02),
    fd.effects.KinematicError("elbow", amplitude=0.02, harmonic=5.0, phase=0.3),
    fd.effects.TorqueRipple("shoulder", amplitude=0.2, harmonic=6.0, phase=0.0),
    fd.effects.ParallelSpring("shoulder", stiffness=8.0, rest=0.1),
    fd.effects.PositionTorque("elbow", cos_1=0.1, sin_1=0.2, cos_2=0.3, sin_2=0.4),
    fd.effects.EndStop("elbow", lower=-0.5, upper=0.6, stiffness=90.0, damping=2.0),
    fd.effects.Payload(mass=0.4),
]


@pytest.mark.parametrize("effects", [*([law] for law in LAWS), LAWS], ids=[*(law.name for law in LAWS), "all"])
def test_every_law_against_differences(effects: list[fd.effects.Effect]) -> None:
    """Every law alone, and all of them on one arm, in motion."""
    model = two_link(HANGING, effects)
    x = np.concatenate([[0.4, -0.7, 0.47, -0.6, 0.3, -0.2, 0.5, 0.4], np.full(8, 0.003)])
    x, tau = x[: build_plant(model).state_size], np.array([1.0, -0.5])
    linear = fd.linearize(model, x, tau)
    A, B = differences(model, x, tau)
    np.testing.assert_allclose(linear.A, A, rtol=1e-6, atol=1e-8 * np.abs(A).max())
    np.testing.assert_allclose(linear.B, B, rtol=1e-8, atol=1e-10 * np.abs(B).max())
    plain = fd.linearize(two_link(HANGING), x[:8], tau)
    assert np.abs(linear.A[:8, :8] - plain.A).max() > 1e-3 or np.abs(linear.rate0[:8] - plain.rate0).max() > 1e-3


def test_free_response_differs_by_the_square_of_the_amplitude() -> None:
    """About a pose held by its motors, expm(A t) dx is the nonlinear motion but for a quadratic error."""
    model = two_link(HANGING)
    q = np.array([0.3, 0.8])
    linear = fd.linearize(model, q)
    assert np.abs(linear.rate0).max() < 1e-11
    direction = np.array([1.0, -1.0, 0.5, 1.0, 0.0, 0.0, 1.0, -1.0])
    errors = []
    for amplitude in (1e-3, 5e-4, 2.5e-4):
        x = linear.x0 + amplitude * direction
        start: dict[str, Any] = {"q0": x[:2], "theta0": x[2:4], "v0": x[4:6], "omega0": x[6:]}
        run = fd.simulate(model, linear.tau0, 0.5, EXACT, rate=50, **start)
        expected = [linear.x0 + expm(linear.A * t) @ (amplitude * direction) for t in run.t]
        errors.append(np.abs(state(run) - np.array(expected)).max() / amplitude)
    assert errors[0] < 0.05
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.05)


def test_scipy_takes_it() -> None:
    """The response of scipy.signal to the model made for it is the step of torque that the arm itself answers with."""
    model = two_link(HANGING)
    linear = fd.linearize(model, [-math.pi / 2, 0.2])
    step = np.array([1e-4, -2e-4])
    t = np.linspace(0.0, 1.0, 201)
    _, y, _ = lsim(linear.to_scipy(), np.tile(step, (len(t), 1)), t)
    theta0: dict[str, Any] = {"theta0": linear.x0[2:4], "q0": linear.x0[:2]}
    run = fd.simulate(model, linear.tau0 + step, 1.0, EXACT, rate=200, **theta0)
    expected = np.hstack([run.q, run.theta]) - linear.x0[:4]
    assert np.abs(expected).max() > 1e-5
    np.testing.assert_allclose(y, expected, atol=1e-4 * np.abs(expected).max())


def test_sliding_friction_has_the_slope_of_its_branch(tmp_path: Path) -> None:
    """Stribeck friction falls with speed: its slope is a negative damping, Coulomb friction's none."""
    effects = [
        {"effect": "coulomb_friction", "side": "motor", "level": 3.0},
        {"effect": "stribeck_friction", "side": "motor", "excess": 2.0, "velocity": 0.1},
        {"effect": "coulomb_friction", "side": "link", "level": 1.0},
    ]
    model = two_mass(tmp_path, effects)
    speed = -0.07
    sliding = fd.linearize(model, [0.3, 0.3, 0.0, speed], [0.0])
    slope = -2.0 / 0.1 * math.exp(speed / 0.1)
    assert sliding.A[3, 3] == pytest.approx((-DAMPER - slope) / ROTOR, rel=1e-8)
    assert sliding.A[2, 2] == pytest.approx(-DAMPER / MASS, rel=1e-8)  # the link rests: its friction is left out
    assert sliding.rate0[3] == pytest.approx((3.0 + 2.0 * math.exp(speed / 0.1) - DAMPER * speed) / ROTOR)
    resting = fd.linearize(model, [0.3], [0.0])
    assert resting.A[3, 3] == pytest.approx(-DAMPER / ROTOR, rel=1e-8)


def test_a_rotor_that_friction_holds(tmp_path: Path) -> None:
    """Held by its motor's friction a mass swings on its spring alone, whatever the motor asks for."""
    model = two_mass(tmp_path, [{"effect": "coulomb_friction", "side": "motor", "level": 3.0}])
    linear = fd.linearize(model, [0.3], stuck="held", outputs=("q", "theta", "v"))
    assert linear.held == ("theta.lift",)
    assert linear.state_names == ("q.lift", "v.lift")
    np.testing.assert_allclose(linear.A, [[0.0, 1.0], [-SPRING / MASS, -DAMPER / MASS]], rtol=1e-8)
    assert not linear.B.any()
    np.testing.assert_array_equal(linear.C, [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    with pytest.raises(fd.InputError, match=r"^stuck: dry friction does not hold theta\.lift at rest, got 'held'; use"):
        fd.linearize(model, [0.3], [WEIGHT + 3.1], stuck="held")


def test_a_link_that_friction_holds_among_others() -> None:
    """With the shoulder's link stuck the others move as the exact sticking of the simulation has it."""
    arm = TwoLink(stiffness=(30.0, math.inf), damping=(0.2, 0.0), rotor=(0.2, 0.1))
    model = two_link(arm, [{"effect": "coulomb_friction", "joint": "shoulder", "side": "link", "level": 5.0}])
    q = np.array([0.3, 0.8])
    linear = fd.linearize(model, q, stuck="held")
    assert linear.state_names == ("q.elbow", "theta.shoulder", "v.elbow", "omega.shoulder")
    step = np.array([1e-3, 2e-3])
    run = fd.simulate(model, step, 0.3, EXACT, rate=100, q0=q, theta0=q)
    assert np.ptp(run.q[:, 0]) == 0.0
    A = np.block([[linear.A, linear.B @ step[:, None]], [np.zeros((1, 5))]])
    moved = np.array([(expm(A * t) @ [0.0, 0.0, 0.0, 0.0, 1.0])[:4] for t in run.t])
    expected = np.column_stack([run.q[:, 1] - q[1], run.theta[:, 0] - q[0], run.v[:, 1], run.omega[:, 0]])
    np.testing.assert_allclose(moved, expected, atol=1e-5 * np.abs(expected).max())
    assert np.abs(expected).max(axis=0).min() > 1e-5


def test_inputs_outputs_and_actuators(tmp_path: Path) -> None:
    """Chosen inputs and channels by name; a wrong torque constant scales B, a motor at its limit has none left."""
    model = fd.load_model("scara_two_link")
    linear = fd.linearize(model, inputs=["elbow"], outputs=["deflection", "omega.elbow"])
    assert linear.input_names == ("tau.elbow",)
    assert linear.output_names == ("deflection.shoulder", "deflection.elbow", "omega.elbow")
    expected = np.zeros((3, 8))
    expected[0, [2, 0]] = expected[1, [3, 1]] = 1.0, -1.0
    expected[2, 7] = 1.0
    np.testing.assert_array_equal(linear.C, expected)
    assert linear.B[:, 0] == pytest.approx(np.eye(8)[7] / 0.1)
    assert linear.D.shape == (3, 1)
    strong = two_mass(tmp_path, [{"effect": "torque_constant_error", "gain": 0.1}])
    linear = fd.linearize(strong, [0.3])
    assert linear.B[3, 0] == pytest.approx(1.1 / ROTOR)
    assert linear.tau0 == pytest.approx([WEIGHT / 1.1])
    weak = two_mass(tmp_path, [{"effect": "torque_speed_limit", "stall_torque": 20.0, "no_load_speed": 4.0}])
    linear = fd.linearize(weak, [0.3], [30.0])
    assert not linear.B.any()
    assert linear.A[3, 3] == pytest.approx((-DAMPER - 20.0 / 4.0) / ROTOR, rel=1e-8)
    with pytest.raises(fd.InputError, match=r"^q: the motor of lift is too weak to hold the pose"):
        fd.linearize(weak, [0.3])


def test_internal_states(tmp_path: Path) -> None:
    """At rest a bristle follows its coordinate, z' = u, and pulls with its stiffness."""
    bristle = {"effect": "presliding_friction", "side": "motor", "level": 2.0, "stiffness": 90.0, "damping": 0.5}
    linear = fd.linearize(two_mass(tmp_path, [bristle]), [0.3])
    assert linear.state_names[-1] == "z[0]"
    np.testing.assert_allclose(linear.A[4], [0.0, 0.0, 0.0, 1.0, 0.0], atol=1e-9)
    assert linear.A[3, 4] == pytest.approx(-90.0 / ROTOR, rel=1e-8)
    assert linear.A[3, 3] == pytest.approx((-DAMPER - 0.5) / ROTOR, rel=1e-8)


def test_immutable_and_portable() -> None:
    """Arrays are locked, also after pickling; poles are A's eigenvalues; a joint's name misspelt is named."""
    model = fd.load_model("ur5")
    linear = pickle.loads(pickle.dumps(fd.linearize(model)))  # noqa: S301
    with pytest.raises(ValueError, match="read-only"):
        linear.A[0, 0] = 1.0
    assert repr(linear) == "<LinearModel 24 states, 6 inputs, 12 outputs>"
    assert linear.poles.sum() == pytest.approx(np.trace(linear.A))
    with pytest.raises(fd.InputError, match="joint: no such joint, got 'elbow'; did you mean 'elbow_joint'"):
        fd.linearize(model, inputs=["elbow"])
    with pytest.raises(fd.InputError, match=r"outputs: no such signal, got 'teta'; did you mean 'theta'"):
        fd.linearize(model, outputs=["teta"])
    with pytest.raises(fd.InputError, match=r"^x: 24 finite numbers are needed"):
        fd.linearize(model, np.zeros(5))
    with pytest.raises(fd.InputError, match=r"^stuck: no such choice, got 'yes'; it is free or held"):
        fd.linearize(model, stuck="yes")  # type: ignore[arg-type]
