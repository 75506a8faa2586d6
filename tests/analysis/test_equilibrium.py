"""Equilibria against closed forms and against where a damped simulation comes to rest."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.analysis.arms import WEIGHT, two_mass
from tests.arms import EXACT, two_link
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0), damping=(0.5, 0.5), gravity=9.81)
LAWS: dict[str, list[dict[str, Any]]] = {
    "hardening": [{"effect": "hardening_spring", "joint": "shoulder", "cubic": 900.0}],
    "backlash": [{"effect": "backlash", "joint": "shoulder", "half_gap": 0.02}],
    "kinematic error": [
        {"effect": "kinematic_error", "joint": "elbow", "amplitude": 0.05, "harmonic": 3.0, "phase": 0.4}
    ],
    "ripple and offset": [
        {"effect": "torque_ripple", "joint": "elbow", "amplitude": 0.3, "harmonic": 2.0, "phase": 0.4},
        {"effect": "torque_offset", "joint": "shoulder", "offset": 0.4},
        {"effect": "torque_constant_error", "joint": "shoulder", "gain": -0.2},
    ],
    "link springs": [
        {"effect": "parallel_spring", "joint": "shoulder", "stiffness": 6.0, "rest": 0.5},
        {"effect": "position_torque", "joint": "elbow", "cos_1": 0.6, "sin_1": 0.2, "cos_2": -0.3, "sin_2": 0.1},
        {"effect": "end_stop", "joint": "elbow", "lower": -1.0, "upper": 0.3, "stiffness": 200.0, "damping": 2.0},
    ],
}


@pytest.mark.parametrize("tau", [(0.0, 0.0), (2.0, 1.0), (-6.0, 0.5)])
def test_two_links_under_gravity(tau: tuple[float, float]) -> None:
    """At rest the motors carry the weight, G(q) = tau = K (theta - q), and the hanging side is the stable one."""
    found = fd.equilibrium(two_link(ARM), tau, q_guess=[-1.2, 0.2])
    np.testing.assert_allclose(ARM.weight(*found.q), tau, atol=1e-9)
    np.testing.assert_allclose((found.theta - found.q) * ARM.stiffness, tau, atol=1e-9)
    np.testing.assert_allclose(ARM.derivative(found.x.tolist(), tau), 0.0, atol=1e-8)
    assert found.stable
    assert found.stability == "stable"
    assert found.residual < 1e-9
    np.testing.assert_allclose(found.holding.lower, tau, atol=1e-9)
    np.testing.assert_allclose(found.holding.upper, tau, atol=1e-9)


@pytest.mark.parametrize("name", LAWS)
def test_where_a_damped_arm_comes_to_rest(name: str) -> None:
    """Let go with friction that is viscous alone, the arm ends where the equilibrium is."""
    oil = [
        {"effect": "viscous_friction", "joint": joint, "side": "link", "coefficient": 3.0}
        for joint in ("shoulder", "elbow")
    ]
    model = two_link(ARM, [*LAWS[name], *oil])
    tau = [1.5, 0.8]
    found = fd.equilibrium(model, tau, q_guess=[-1.2, 0.2])
    plain = fd.equilibrium(two_link(ARM), tau, q_guess=[-1.2, 0.2])
    assert max(np.abs(found.q - plain.q).max(), np.abs(found.theta - plain.theta).max()) > 1e-3  # the law matters
    start: dict[str, Any] = {"q0": found.q + np.array([0.05, -0.04]), "theta0": found.theta + np.array([0.05, -0.03])}
    run = fd.simulate(model, tau, 60.0, fd.solvers.DormandPrince(rtol=1e-9, atol=1e-11), rate=1, **start)
    np.testing.assert_allclose(run.q[-1], found.q, atol=1e-6)
    np.testing.assert_allclose(run.theta[-1], found.theta, atol=1e-6)


def test_upright_is_an_equilibrium_and_falls() -> None:
    """Newton finds the equilibrium that is near, also one that no simulation would come to."""
    found = fd.equilibrium(two_link(ARM), q_guess=[1.5, 0.05])
    np.testing.assert_allclose(found.q, [math.pi / 2, 0.0], atol=1e-9)
    assert found.stability == "unstable"
    assert not found.stable


def test_a_far_guess_ends_at_some_equilibrium() -> None:
    """From anywhere an arm under gravity has a place to hang."""
    model = fd.load_model("ur5")
    for q in np.random.default_rng(3).uniform(-3.0, 3.0, (4, 6)):
        found = fd.equilibrium(model, q_guess=q)
        assert found.residual < 1e-8


def test_a_mass_on_its_stop(tmp_path: Path) -> None:
    """A slider lies on its lower stop with all its weight; gravity alone, far from it, lets it fall there."""
    stop = {"effect": "end_stop", "lower": -0.2, "upper": 5.0, "stiffness": 4000.0, "damping": 10.0}
    found = fd.equilibrium(two_mass(tmp_path, [stop]), q_guess=[3.0])
    assert found.q == pytest.approx([-0.2 - WEIGHT / 4000.0], abs=1e-12)
    assert found.theta == pytest.approx(found.q)
    assert found.stable


def test_no_equilibrium_is_said_in_one_line(tmp_path: Path) -> None:
    """A torque that no pose balances, a weight that nothing carries."""
    with pytest.raises(
        fd.InputError, match=r"^no equilibrium: at the nearest, \S+ N m on \w+ is left unbalanced; take"
    ):
        fd.equilibrium(two_link(ARM), [100.0, 0.0])
    with pytest.raises(fd.InputError, match=r"^no equilibrium: at the nearest, -24\.5\d N on lift") as caught:
        fd.equilibrium(two_mass(tmp_path))
    assert "\n" not in str(caught.value)


def test_without_gravity_every_pose_will_do() -> None:
    """A horizontal arm stays where it is looked for, held by nothing: neutral."""
    found = fd.equilibrium(two_link(TwoLink()), q_guess=[0.4, 0.9])
    assert found.q.tolist() == [0.4, 0.9]
    assert found.stability == "neutral"


def test_friction_holds_where_nothing_else_would() -> None:
    """A horizontal arm under torques below its dry levels rests where it is; above them it has no equilibrium."""
    model = fd.load_model("scara_two_link")
    found = fd.equilibrium(model, [0.029, -0.029])
    assert found.stability == "held"
    assert found.stable
    np.testing.assert_allclose(found.q, [0.0, math.pi / 2])
    np.testing.assert_allclose((found.theta - found.q) * 5.5, [0.029, -0.029], atol=1e-12)
    np.testing.assert_allclose(found.friction_link, [0.029, -0.029], atol=1e-12)
    np.testing.assert_allclose(found.friction_motor, 0.0, atol=1e-12)
    run = fd.simulate(model, found.tau, 5.0, EXACT, q0=found.q, theta0=found.theta, rate=10)
    assert np.ptp(run.q, axis=0).tolist() == [0.0, 0.0]
    with pytest.raises(fd.InputError, match=r"^no equilibrium: "):
        fd.equilibrium(model, [0.031, 0.0])


def test_a_saturated_motor_gives_what_it_can(tmp_path: Path) -> None:
    """Asked for more than its stall torque, the motor holds the arm where the stall torque does."""
    limit = {"effect": "torque_speed_limit", "joint": "elbow", "stall_torque": 0.7, "no_load_speed": 4.0}
    found = fd.equilibrium(two_link(ARM, [limit]), [2.0, 3.0], q_guess=[-1.2, 0.2])
    np.testing.assert_allclose(ARM.weight(*found.q), [2.0, 0.7], atol=1e-9)
    assert found.holding.upper[1] == math.inf


def test_equilibria_are_locked_and_pickle() -> None:
    """One line to read, arrays that do not change."""
    found = pickle.loads(pickle.dumps(fd.equilibrium(two_link(ARM), q_guess=[-1.5, 0.0])))  # noqa: S301
    assert repr(found).startswith("<Equilibrium shoulder -1.5708, elbow ")
    assert repr(found).endswith("; stable>")
    with pytest.raises(ValueError, match="read-only"):
        found.q[0] = 1.0
