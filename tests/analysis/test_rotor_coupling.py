"""Linear analysis of arms whose rotors ride on their parent links."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh, expm

import flexdyn as fd
from flexdyn.simulation.plant import build_plant
from tests.analysis.arms import gravity_slope
from tests.arms import EXACT, state
from tests.oracles.riding_arms import RIGID, Planar, planar, riding_model, skew, too_light
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
POSE = (-1.3, 0.5)


def matrices(arm: Planar) -> tuple[Array, Array]:
    """H and K of s = [q1, q2, theta1, theta2] at the pose (4, 4), by hand; a rigid joint's theta folded onto its q."""
    spring = np.diag([K if math.isfinite(K) else 0.0 for K in arm.links.stiffness])
    stiffness = np.kron([[1.0, -1.0], [-1.0, 1.0]], spring)
    stiffness[:2, :2] += gravity_slope(arm.links, POSE)
    fold = np.vstack([np.eye(2, 2 + len(arm.links.elastic)) for _ in range(2)])
    for slot, j in enumerate(arm.links.elastic):
        fold[2 + j] = np.eye(2 + len(arm.links.elastic))[2 + slot]
    return fold.T @ arm.inertia(POSE[1]) @ fold, fold.T @ stiffness @ fold


MIXTURES = [(30.0, 20.0), (RIGID, 20.0), (30.0, RIGID), (RIGID, RIGID)]
FREE, HELD = [(each, "free") for each in MIXTURES], [(each, "held") for each in MIXTURES[:3]]


@pytest.mark.parametrize(("stiffness", "rotors"), FREE + HELD)
def test_eigenfrequencies_of_the_hand_written_matrices(stiffness: tuple[float, float], rotors: Any) -> None:
    """Frequencies and shapes with rotor 2 riding on link 1; held rotors ride without spinning."""
    arm = planar(stiffness=stiffness)
    H, K = matrices(arm)
    kept = np.array(arm.links.elastic) if rotors == "held" else np.arange(len(H))
    squared, vectors = eigh(K[np.ix_(kept, kept)], H[np.ix_(kept, kept)])
    found = fd.modes(arm.model(), POSE, rotors=rotors)
    np.testing.assert_allclose(found.frequencies, np.sqrt(np.maximum(squared, 0.0)) / (2.0 * math.pi), rtol=1e-9)
    if rotors == "free":
        shapes = np.hstack([found.link_shapes, found.rotor_shapes[:, list(arm.links.elastic)]])
        expected = (vectors / vectors[np.abs(vectors).argmax(axis=0), range(len(H))]).T
        np.testing.assert_allclose(shapes, expected, atol=1e-6)
        for row, place in enumerate([2 + arm.links.elastic.index(j) if j in arm.links.elastic else j for j in (0, 1)]):
            free = [i for i in range(len(H)) if i != place]
            zeros = eigh(K[np.ix_(free, free)], H[np.ix_(free, free)], eigvals_only=True)
            np.testing.assert_allclose(found.anti_resonances[row], np.sqrt(zeros) / (2.0 * math.pi), rtol=1e-9)


def test_rigid_body_modes_stay_exactly_zero() -> None:
    """Without gravity nothing holds the arm: two modes at 0 Hz, with coupling as without."""
    kinds = [fd.modes(planar(gravity=0.0).model(coupling=each), POSE).kinds for each in ("full", "reduced")]
    assert kinds == [("rigid-body", "rigid-body", "vibration", "vibration")] * 2


def test_a_high_gear_ratio_has_the_reduced_frequencies() -> None:
    """The first-order change of a frequency with S falls like 1/N."""
    gaps = []
    for ratio in (100.0, 1000.0):
        arm = planar(ratio)
        full, reduced = (fd.modes(arm.model(coupling=each), POSE).frequencies for each in ("full", "reduced"))
        gaps.append(np.abs(full - reduced) / reduced)
    assert gaps[0].max() > 1e-4
    np.testing.assert_allclose(gaps[0].max() / gaps[1].max(), 10.0, rtol=0.05)


@pytest.mark.parametrize("stiffness", [(60.0, 40.0, 30.0), (RIGID, 40.0, RIGID), (RIGID,) * 3])
def test_linearize_against_differences(tmp_path: Path, stiffness: tuple[float, float, float]) -> None:
    """A, B and rate0 of a spinning spatial arm: those of Lagrange's equations, and of the core's own x'."""
    arm = skew(stiffness)
    model, e = riding_model(arm, tmp_path), len(arm.elastic)
    x = np.array([0.3, -0.5, 0.8, *[0.35, -0.45, 0.75][:e], 1.0, -0.5, 0.8, *[2.0, -1.0, 3.0][:e]])
    tau, h = np.array([1.0, -2.0, 0.5]), 1e-5

    def core(x: Array, tau: Array) -> Array:
        out = np.empty(len(x))
        build_plant(model).derivative(0.0, x, tau, 0.0, out)
        return out

    linear = fd.linearize(model, x, tau)
    for rate in (core, lambda x, tau: arm.derivative(x, tau.tolist())):
        A = np.array([rate(x + d, tau) - rate(x - d, tau) for d in h * np.eye(len(x))]).T / (2.0 * h)
        B = np.array([rate(x, tau + d) - rate(x, tau - d) for d in np.eye(3)]).T / 2.0
        np.testing.assert_allclose(linear.A, A, atol=1e-8 * np.abs(A).max())
        np.testing.assert_allclose(linear.B, B, atol=1e-10 * np.abs(B).max())
        np.testing.assert_allclose(linear.rate0, rate(x, tau), atol=1e-8)


def test_free_response_is_the_motion() -> None:
    """About a pose held by its motors the linear response differs from the motion by the square of the amplitude."""
    model = planar().model()
    linear = fd.linearize(model, POSE)
    assert np.abs(linear.rate0).max() < 1e-10
    direction, errors = np.array([1.0, -1.0, 0.5, 1.0, 0.0, 0.0, 1.0, -1.0]), []
    for amplitude in (1e-3, 5e-4):
        x = linear.x0 + amplitude * direction
        start: dict[str, Any] = {"q0": x[:2], "theta0": x[2:4], "v0": x[4:6], "omega0": x[6:]}
        run = fd.simulate(model, linear.tau0, 0.5, EXACT, rate=50, **start)
        expected = np.array([linear.x0 + expm(linear.A * t) @ (amplitude * direction) for t in run.t])
        errors.append(np.abs(state(run) - expected).max() / amplitude)
    assert errors[0] < 0.1
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)


def test_the_response_to_a_torque_by_hand() -> None:
    """G(s) = (s^2 H + K)^-1: torque on rotor 1 shakes rotor 2 through link 1, and the other way round alike."""
    arm = planar()
    H, K = matrices(arm)
    hertz = np.array([0.3, 2.0, 9.0])
    found = fd.frequency_response(arm.model(), hertz, x=POSE)
    for f, response in zip(hertz, found, strict=True):
        expected = np.linalg.inv(K - (2.0 * math.pi * f) ** 2 * H)
        np.testing.assert_allclose(response, expected[:, 2:], rtol=1e-6, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(("joint", "side"), [("shoulder", "link"), ("elbow", "motor"), ("shoulder", "motor")])
def test_what_friction_holds_among_coupled_others(joint: str, side: str) -> None:
    """With a link or a rotor stuck, the others move as the exact sticking of the simulation has it."""
    arm = planar(gravity=0.0)
    model = arm.model([{"effect": "coulomb_friction", "joint": joint, "side": side, "level": 5.0}])
    q, step = np.array([0.3, 0.8]), np.array([1e-5, 2e-5])
    linear = fd.linearize(model, q, stuck="held")
    assert linear.held == (f"{'q' if side == 'link' else 'theta'}.{joint}",)
    run = fd.simulate(model, step, 0.3, EXACT, rate=100, q0=q, theta0=q)
    size = len(linear.A)
    A = np.block([[linear.A, linear.B @ step[:, None]], [np.zeros((1, size + 1))]])
    moved = np.array([(expm(A * t) @ np.eye(size + 1)[-1])[:size] for t in run.t])
    column = {name: i for i, name in enumerate(fd.linearize(model, q).state_names)}
    kept = [column[name] for name in linear.state_names]
    expected = state(run)[:, kept] - np.concatenate([q, q, np.zeros(4)])[kept]
    np.testing.assert_allclose(moved, expected, atol=1e-5 * np.abs(expected).max())
    assert np.abs(expected).max() > 1e-6


def test_rest_asks_for_the_same_torques() -> None:
    """Inertia holds nothing: holding torques, their intervals and equilibria are those of the reduced model."""
    arm = planar()
    dry = [{"effect": "coulomb_friction", "joint": "elbow", "side": "motor", "level": 0.4}]
    full, reduced = (fd.holding_torques(arm.model(dry, each), POSE) for each in ("full", "reduced"))
    np.testing.assert_array_equal(full.lower, reduced.lower)
    np.testing.assert_array_equal(full.upper, reduced.upper)
    tau = TwoLink(gravity=9.81).weight(*POSE)
    found = fd.equilibrium(arm.model(), tau, q_guess=[-1.2, 0.4])
    np.testing.assert_allclose(found.q, POSE, atol=1e-8)


def test_links_lighter_than_their_rotors_at_the_pose_are_refused(tmp_path: Path) -> None:
    """At right angles rotor 3 turns nothing of link 1; where their axes are parallel it outweighs it."""
    model = riding_model(too_light(), tmp_path)
    assert np.isfinite(fd.modes(model, [0.0, 0.0, 0.0]).frequencies).all()
    for analyse in (fd.modes, fd.linearize):
        with pytest.raises(
            fd.InputError, match=r"^robot\.rotor_coupling: the inertia of the links is smaller than .* at this pose;"
        ):
            analyse(model, [0.0, 1.5, 0.0])
