"""A differential wrist with everything on its motors, against equations derived symbolically.

Lagrange's equations of pitch p (about y) and roll r (about z of the first link), the second link's centre of mass at
(c, 0, e) of its frame; made with SymPy from kinetic and potential energy, simplified, and copied as printed. The
motors' angles are ``N_i (A q)_i`` with a negative gear ratio among the N; what stands on their side acts in
``theta = A q + deflection`` alone.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexdyn as fd
from tests.arms import EXACT
from tests.physics.test_axes import WRIST

Array = NDArray[np.float64]
G, M1, M2, H1, C, E = 9.81, 1.5, 0.8, 0.05, 0.06, 0.25
AY, BX, BY, BZ = 0.02, 0.006, 0.007, 0.004
A = np.array([[1.0, 1.0], [1.0, -1.5]])
NAMES, GEARS, ROTORS = ("left", "right"), np.array([-40.0, 60.0]), np.array([1.5e-4, 1e-4])
J = GEARS**2 * ROTORS
K, D = np.array([80.0, 60.0]), np.array([0.3, 0.2])
LEVEL, VISCOUS = np.array([0.3, 0.2]), np.array([0.15, 0.1])
RIPPLE, HARMONIC, PHASE = np.array([0.4, 0.3]), np.array([12.0, 9.0]), np.array([0.5, -0.2])
TAU, START = np.array([2.0, -1.8]), np.array([0.6, -0.5])


def links(q: Array, v: Array) -> tuple[Array, Array]:
    """M and h of the two joints, as SymPy printed them."""
    (p, r), (dp, dr) = q, v
    sin, cos = math.sin, math.cos
    first = AY + BX * sin(r) ** 2 + BY * cos(r) ** 2 + H1**2 * M1 + M2 * (C**2 * cos(r) ** 2 + E**2)
    both = -C * M2 * E * sin(r)
    M = np.array([[first, both], [both, BZ + C**2 * M2]])
    turning = -2 * BX * dp * sin(r) + 2 * BY * dp * sin(r) + C * M2 * (2 * C * dp * sin(r) + E * dr)
    weight = G * (H1 * M1 * sin(p) + M2 * (C * cos(p) * cos(r) + E * sin(p)))
    spin = -BX * dp**2 * cos(r) + BY * dp**2 * cos(r) + C**2 * dp**2 * M2 * cos(r) + C * G * M2 * sin(p)
    return M, np.array([-dr * turning * cos(r) - weight, spin * sin(r)])


def on_motors(theta: Array, omega: Array) -> Array:
    """What torque, ripple and friction leave of the torque on each motor."""
    return np.asarray(TAU + RIPPLE * np.sin(HARMONIC * theta + PHASE) - VISCOUS * omega - LEVEL * np.sign(omega))


def elastic(t: float, x: Array) -> Array:
    """X' of x = [q, theta, v, omega]."""
    q, theta, v, omega = np.split(x, 4)
    M, h = links(q, v)
    spring = K * (theta - A @ q) + D * (omega - A @ v)
    return np.concatenate([v, omega, np.linalg.solve(M, A.T @ spring - h), (on_motors(theta, omega) - spring) / J])


def rigid(t: float, x: Array) -> Array:
    """X' of x = [q, v]: rotors turn with the joints, friction and ripple act on both through A."""
    q, v = np.split(x, 2)
    M, h = links(q, v)
    return np.concatenate([v, np.linalg.solve(M + A.T @ np.diag(J) @ A, A.T @ on_motors(A @ q, A @ v) - h)])


def wrist(folder: Path, spring: bool) -> fd.FlexibleJointModel:
    """The same in flexdyn: every number on its motor."""
    (folder / "wrist.urdf").write_text(WRIST, encoding="utf-8")
    axes = {name: dict(zip(("pitch", "roll"), row, strict=True)) for name, row in zip(NAMES, A.tolist(), strict=True)}
    joints: dict[str, Any] = {}
    effects: list[fd.effects.Effect] = []
    for i, name in enumerate(NAMES):
        joints[name] = {"gear_ratio": float(GEARS[i]), "rotor_inertia": float(ROTORS[i])}
        if spring:
            joints[name] |= {"stiffness": float(K[i]), "damping": float(D[i])}
        amplitude, harmonic, phase = float(RIPPLE[i]), float(HARMONIC[i]), float(PHASE[i])
        effects += [
            fd.effects.TorqueRipple(name, amplitude=amplitude, harmonic=harmonic, phase=phase),
            fd.effects.ViscousFriction(name, side="motor", coefficient=float(VISCOUS[i])),
            fd.effects.CoulombFriction(name, side="motor", level=float(LEVEL[i])),
        ]
    return fd.FlexibleJointModel(fd.load_robot(folder / "wrist.urdf").with_axes(axes), joints, effects)


@pytest.mark.parametrize("equations", [elastic, rigid], ids=["elastic", "rigid"])
@pytest.mark.parametrize(
    ("solver", "close"),
    [
        (EXACT, 1e-8),
        (fd.solvers.Rosenbrock(rtol=1e-9, atol=1e-11), 1e-7),
        (fd.solvers.TimeStepping(step=5e-5), 2e-3),
    ],
    ids=lambda each: type(each).__name__,
)
def test_everything_on_the_motors(tmp_path: Path, equations: Any, solver: Any, close: float) -> None:
    """Rotor inertia, dry and viscous friction, ripple and elasticity, one gear that turns the other way."""
    spring = equations is elastic
    q, v = np.linalg.solve(A, START), np.linalg.solve(A, 2.0 * START)
    first = np.concatenate([q, START, v, 2.0 * START] if spring else [q, v])
    times = np.linspace(0.0, 0.4, 41)
    found = solve_ivp(equations, (0.0, 0.4), first, "DOP853", rtol=1e-11, atol=1e-12, t_eval=times)
    omega = found.y[6:].T if spring else found.y[2:].T @ A.T
    assert (np.sign(omega) == np.sign(START)).all(), "the oracle's friction does not turn round"
    run = fd.simulate(wrist(tmp_path, spring), TAU, 0.4, solver=solver, times=times, q0=START, v0=2.0 * START)
    np.testing.assert_allclose(run.model.robot.expand(run.q), found.y[:2].T, atol=close)
    assert np.ptp(run.q, axis=0).min() > 0.2
    assert run.energy.closes


def test_links_are_pinocchios(tmp_path: Path) -> None:
    """The printed M and h at a few states, in the joints."""
    side = fd.LinkSide(fd.FlexibleJointModel(_plain(tmp_path)))
    rng = np.random.default_rng(2)
    for q, v in rng.normal(size=(5, 2, 2)):
        M, h = links(q, v)
        np.testing.assert_allclose(side.mass_matrix(q), M, rtol=1e-10)
        np.testing.assert_allclose(side.bias(q, v), h, rtol=1e-9)


def _plain(folder: Path) -> fd.Robot:
    (folder / "wrist.urdf").write_text(WRIST, encoding="utf-8")
    return fd.load_robot(folder / "wrist.urdf")
