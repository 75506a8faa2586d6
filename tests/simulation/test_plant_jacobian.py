"""The plant's Jacobian against central differences of its derivative."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn import effects as fx
from flexdyn.simulation.plant import build_plant
from tests.effects.arms import catalogue_examples, model_of
from tests.effects.reference import Arm

Array = NDArray[np.float64]
ARM = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.2), gravity=9.81)
SPRINGS = {"elastic": (300.0, 200.0), "first_rigid": (math.inf, 200.0), "second_rigid": (300.0, math.inf)}
SPRINGS["rigid"] = (math.inf, math.inf)
SMOOTHING = 0.1
IN_PLANT = [e for e in catalogue_examples() if e.stage != "sensor"]


def slopes(model: fd.FlexibleJointModel, x: Array, tau: Array, smoothing: float = SMOOTHING) -> Array:
    """A = dx'/dx from the core."""
    plant = build_plant(model)
    out = np.empty((len(x), len(x)))
    plant.jacobian(0.2, x, tau, smoothing, out)
    return out


def differences(model: fd.FlexibleJointModel, x: Array, tau: Array, h: float = 1e-5) -> Array:
    """The same by central differences of order 4 of x'."""
    plant = build_plant(model)
    out = np.empty((len(x), len(x)))

    def rate(k: int, shift: float) -> Array:
        dx, point = np.empty(len(x)), x.copy()
        point[k] += shift
        plant.derivative(0.2, point, tau, SMOOTHING, dx)
        return dx

    for k in range(len(x)):
        step = h if k < 4 * model.n else 1e-2 * h  # what bristles and loops hold is small
        near, far = rate(k, step) - rate(k, -step), rate(k, 2 * step) - rate(k, -2 * step)
        out[:, k] = (8.0 * near - far) / (12.0 * step)
    return out


def point_of(model: fd.FlexibleJointModel, seed: int, twist: float = 0.03) -> tuple[Array, Array]:
    """A state away from every corner, and torques."""
    rng = np.random.default_rng(seed)
    n, e = model.n, int(model.elastic.sum())
    q = rng.uniform(0.4, 0.9, n)
    v = rng.uniform(0.3, 0.6, n)
    theta = q[model.elastic] + twist * rng.uniform(1.0, 2.0, e)
    omega = v[model.elastic] + rng.uniform(0.1, 0.3, e)
    z = rng.uniform(2e-4, 4e-4, build_plant(model).internal_states)
    return np.concatenate([q, theta, v, omega, z]), rng.uniform(0.1, 0.3, n)


def compare(model: fd.FlexibleJointModel, x: Array, tau: Array, tolerance: float = 1e-6) -> None:
    """Entry by entry, relative to the largest of the row."""
    exact, found = differences(model, x, tau), slopes(model, x, tau)
    scale = np.maximum(np.abs(exact).max(axis=1, keepdims=True), 1e-3)
    worst = np.abs(found - exact) / scale
    i, k = np.unravel_index(np.argmax(worst), worst.shape)
    assert worst[i, k] < tolerance, f"row {i}, column {k}: {found[i, k]} instead of {exact[i, k]}"


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", fd.shipped_models())
def test_shipped_arms(name: str, seed: int) -> None:
    """All of them, at several states, with the effects that they have."""
    model = fd.load_model(name)
    compare(model, *point_of(model, seed, twist=1e-3))


def on_every_side(effect: Any) -> list[Any]:
    """The effect on each side that the contract's table gives it."""
    if not isinstance(effect, fx.JointEffect):
        return [effect]
    place = {"other": "elbow"} if isinstance(effect, fx.JointCoupling) else {}
    numbers = {field.name: getattr(effect, field.name) for field in effect.parameters()}
    return [type(effect)(effect.joint, side=side, **place, **numbers) for side in type(effect).sides]


def needs_spring(effect: Any) -> bool:
    """Whether the effect can be on an elastic joint alone."""
    return getattr(effect, "side", "") == "transmission" or effect.takes_load


CASES = [
    pytest.param(each, springs, id=f"{each.name}-{getattr(each, 'side', 'arm')}-{name}")
    for effect in IN_PLANT
    for each in on_every_side(effect)
    for name, springs in SPRINGS.items()
    if math.isfinite(springs[0]) != (each.name == "joint_elasticity") or not needs_spring(each)
]


@pytest.mark.parametrize(("effect", "springs"), CASES)
def test_every_effect(effect: Any, springs: tuple[float, float]) -> None:
    """Each effect alone on every side that it may have, with elastic and rigid joints, internal states included."""
    damping = tuple(d if math.isfinite(K) else 0.0 for d, K in zip((0.5, 0.3), springs, strict=True))
    model = model_of(Arm(springs, damping, (0.1, 0.2), gravity=9.81), [effect])
    compare(model, *point_of(model, 4))


@pytest.mark.parametrize("springs", SPRINGS.values(), ids=SPRINGS)
@pytest.mark.parametrize(("joint", "other"), [("shoulder", "elbow"), ("elbow", "shoulder")])
def test_couplings(joint: str, other: str, springs: tuple[float, float]) -> None:
    """The slope of a coupling belongs to the other joint's rotor, or to its link where it is rigid."""
    arm = Arm(springs, (0.0, 0.0), (0.1, 0.2))
    model = model_of(arm, [fx.JointCoupling(joint, coefficient=0.7, other=other)])
    compare(model, *point_of(model, 5))


def test_everything_together() -> None:
    """The whole catalogue on one joint, two memories on the other."""
    more = [
        fx.PreslidingFriction("elbow", side="motor", level=2.0, stiffness=800.0, damping=0.3),
        fx.SpringHysteresis("elbow", stiffness=500.0, width=0.003),
        fx.EndStop("elbow", lower=-0.3, upper=0.3, stiffness=100.0, damping=2.0),
        fx.JointCoupling("elbow", coefficient=0.2, other="shoulder"),
    ]
    model = model_of(ARM, [*(e for e in IN_PLANT if e.name != "joint_elasticity"), *more])
    compare(model, *point_of(model, 6))


def test_with_full_rotor_coupling() -> None:
    """Rotors that ride on the links."""
    for effects in ([], [fx.PreslidingFriction("elbow", side="motor", level=2.0, stiffness=800.0)]):
        model = model_of(ARM, effects, rotor_coupling="full")
        compare(model, *point_of(model, 7), tolerance=1e-5)


@pytest.mark.parametrize("side", ["link", "motor"])
def test_what_sticks_does_not_respond(side: Any) -> None:
    """The row of a stuck velocity is zero, to the last bit; the others feel that it is held."""
    model = model_of(ARM, [fx.CoulombFriction("shoulder", side=side, level=1e3)])
    x, tau = point_of(model, 8)
    row = 4 if side == "link" else 6
    x[row] = 0.0
    A = slopes(model, x, tau, smoothing=0.0)
    assert not A[row].any()
    free = slopes(model_of(ARM), x, tau, smoothing=0.0)
    if side == "motor":
        np.testing.assert_allclose(np.delete(A, row, axis=0), np.delete(free, row, axis=0), atol=1e-9)
        return
    # The elbow moves alone: M22 a2 = tau_s2 - h2.
    stiffness = 200.0 / float(ARM.mass_matrix(x[:2].tolist())[1, 1])
    assert A[5, 3] == pytest.approx(stiffness, rel=1e-8)
    assert abs(free[5, 3] / A[5, 3] - 1.0) > 0.1


def test_all_stuck() -> None:
    """Links and rotors held at once: every acceleration row is zero, positions still follow velocities."""
    model = model_of(
        ARM, [fx.CoulombFriction(j, side=s, level=1e3) for j in ("shoulder", "elbow") for s in ("link", "motor")]
    )
    x, tau = point_of(model, 9)
    x[4:8] = 0.0
    A = slopes(model, x, tau, smoothing=0.0)
    assert not A[4:].any()
    np.testing.assert_array_equal(A[:4, 4:], np.eye(4))
    assert not A[:4, :4].any()


def test_along_a_motion() -> None:
    """State by state the same Jacobians; what torques do is of the row they were asked at, with every contact free."""
    model = model_of(ARM, [fx.CoulombFriction("shoulder", side="motor", level=1e3)])
    plant = build_plant(model)
    points = [point_of(model, seed) for seed in range(5)]
    x, tau = (np.array(each) for each in zip(*points, strict=True))
    x[1, 6] = x[4, 6] = 0.0  # sticks
    A, B = np.empty((5, 8, 8)), np.empty((5, 8, 2))
    plant.slopes_along(x, tau, 2, A, B)
    for k in range(5):
        np.testing.assert_array_equal(A[k], slopes(model, x[k], tau[k], smoothing=0.0))
    assert not A[1, 6].any()
    inertia = np.array([0.1, 0.2])
    for k in range(5):  # rotors alone feel torques at once
        np.testing.assert_allclose(B[k, 6:], np.diag(1.0 / inertia), rtol=1e-6)
        assert not B[k, :6].any()
    with pytest.raises(ValueError, match="every is a number of rows"):
        plant.slopes_along(x, tau, 0, A, B)
