"""Prismatic, rigid beside elastic, mimic and endlessly turning joints in motion, against closed forms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import BENT, EXACT, coupled, slider, state, two_link
from tests.oracles.integrate import trajectory
from tests.oracles.two_link import TwoLink

STOPS = np.linspace(0.0, 5.0, 11)


def test_a_prismatic_joint_under_gravity(tmp_path: Path) -> None:
    """Two masses on a spring in free fall with a constant force: solved in closed form.

    With J the reflected rotor mass: (m + J) Y'' = F - m g for the centre of mass, and
    delta'' = F/J + g - (K/J + K/m) delta.
    """
    m, ratio, rotor, K, F, g = 2.5, 200.0, 5e-5, 800.0, 18.0, 9.81
    J = ratio**2 * rotor
    model = fd.FlexibleJointModel(
        slider(tmp_path), {"lift": {"gear_ratio": ratio, "rotor_inertia": rotor, "stiffness": K}}
    )
    run = fd.simulate(model, [F], 5.0, EXACT, q0=[0.3], v0=[0.5], theta0=[0.31], omega0=[0.1], rate=20)
    rate = math.sqrt(K / J + K / m)
    rest = (F / J + g) / rate**2
    delta = rest + (0.01 - rest) * np.cos(rate * run.t) + (0.1 - 0.5) / rate * np.sin(rate * run.t)
    centre = (m * 0.3 + J * 0.31) / (m + J) + (m * 0.5 + J * 0.1) / (m + J) * run.t
    centre = centre + 0.5 * (F - m * g) / (m + J) * run.t**2
    assert np.abs(run.deflection[:, 0] - delta).max() < 1e-8
    assert np.abs(run.q[:, 0] - (centre - J / (m + J) * delta)).max() < 1e-8
    np.testing.assert_allclose(run.tau_s[:, 0], K * delta, atol=1e-5)


def test_a_rigid_prismatic_joint_weighs_its_rotor(tmp_path: Path) -> None:
    """A = (F - m g)/(m + J): the reflected rotor is inertia and no weight."""
    model = fd.FlexibleJointModel(slider(tmp_path), {"lift": {"gear_ratio": 200.0, "rotor_inertia": 5e-5}})
    run = fd.simulate(model, [18.0], 2.0, rate=10)
    acceleration = (18.0 - 2.5 * 9.81) / 4.5
    np.testing.assert_allclose(run.q[:, 0], 0.5 * acceleration * run.t**2, atol=1e-9)
    np.testing.assert_allclose(run.tau_s[:, 0], 18.0 - 2.0 * acceleration, rtol=1e-12)


@pytest.mark.parametrize("elastic", [(True, False), (False, True), (False, False)])
def test_rigid_and_elastic_joints_in_one_arm(elastic: tuple[bool, bool]) -> None:
    """Any mixture of rigid and elastic joints moves as the closed-form equations say."""
    arm = TwoLink(
        stiffness=(30.0 if elastic[0] else math.inf, 20.0 if elastic[1] else math.inf),
        damping=(0.1, 0.05),
        rotor=(0.15, 0.05),
        gravity=9.81,
    )
    start = [-1.5, 0.4, *[0.1] * sum(elastic), 0.2, -0.1, *[0.3] * sum(elastic)]
    names = [name for name, bends in zip(("shoulder", "elbow"), elastic, strict=True) if bends]
    rotors: dict[str, Any] = {"theta0": dict.fromkeys(names, 0.1), "omega0": dict.fromkeys(names, 0.3)}
    run = fd.simulate(two_link(arm), [0.5, -0.3], 5.0, EXACT, times=STOPS, q0=start[0:2], v0=[0.2, -0.1], **rotors)
    expected = trajectory(lambda _, x: arm.derivative(x, [0.5, -0.3]), start, STOPS)
    assert np.abs(state(run) - expected).max() < 1e-8
    rigid = ~run.model.elastic
    np.testing.assert_array_equal(run.theta[:, rigid], run.q[:, rigid])
    np.testing.assert_array_equal(run.omega[:, rigid], run.v[:, rigid])


@pytest.mark.parametrize("stiffness", [math.inf, 25.0])
def test_a_mimic_joint_follows_its_leader(tmp_path: Path, stiffness: float) -> None:
    """Two links tied by q2 = c q1 + d, moved as one: Lagrange with one coordinate and the rotor behind a spring."""
    c, d, J, tau = -0.7, 0.4, 0.2, 0.6
    arm = TwoLink(tip_mass=0.0)
    model = fd.FlexibleJointModel(coupled(tmp_path, c, d), {"lead": {"rotor_inertia": J, "stiffness": stiffness}})
    run = fd.simulate(model, [tau], 5.0, EXACT, times=STOPS, q0=[0.2], v0=[1.1])

    def links(q: float, v: float, torque: float, more: float) -> float:
        d11, d22, d12, _ = arm.inertias(c * q + d)
        h1, h2 = arm.bias([q, c * q + d], [v, c * v])
        return (torque - h1 - c * h2) / (d11 + 2 * c * d12 + c * c * d22 + more)

    def f(_: float, x: Sequence[float]) -> list[float]:
        if math.isinf(stiffness):
            return [x[1], links(x[0], x[1], tau, J)]
        spring = stiffness * (x[1] - x[0])
        return [x[2], x[3], links(x[0], x[2], spring, 0.0), (tau - spring) / J]

    start = [0.2, 1.1] if math.isinf(stiffness) else [0.2, 0.2, 1.1, 1.1]
    assert np.abs(state(run) - trajectory(f, start, STOPS)).max() < 1e-8


def test_a_continuous_joint_turns_without_end() -> None:
    """Its angle is one unwrapped number, exact after eighteen turns."""
    arm = TwoLink(stiffness=(60.0, 40.0), damping=(0.3, 0.2))
    start = [0.0, math.pi / 2, 0.0, math.pi / 2, 40.0, -5.0, 40.0, -5.0]
    run = fd.simulate(two_link(arm), None, 5.0, EXACT, times=STOPS, v0=start[4:6], q0=BENT["q0"])
    expected = trajectory(lambda _, x: arm.derivative(x, [0.0, 0.0]), start, STOPS)
    assert run.q[-1, 0] > 36 * math.pi
    assert np.abs(state(run) - expected).max() < 1e-7


def test_an_arm_locked_at_an_angle_moves_as_the_rest_of_it() -> None:
    """With its elbow locked the arm is one body that turns about the shoulder: D11 a = tau."""
    robot = fd.load_robot("scara_two_link", lock={"elbow": 0.7})
    run = fd.simulate(fd.FlexibleJointModel(robot), [0.3], 2.0, rate=10)
    inertia = TwoLink().inertias(0.7)[0]
    np.testing.assert_allclose(run.q[:, 0], 0.5 * 0.3 / inertia * run.t**2, atol=1e-9)


def test_friction_of_the_urdf_slows_the_joint(tmp_path: Path) -> None:
    """<dynamics damping> is viscous friction of the link: v = v0 exp(-d t/M), unless it is ignored."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="wheel"><link name="base"/><link name="w"><inertial><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="2"/></inertial></link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="w"/><axis xyz="0 0 1"/>'
        '<dynamics damping="0.5"/></joint></robot>',
        encoding="utf-8",
    )
    robot = fd.load_robot(path)
    slowed = fd.simulate(fd.FlexibleJointModel(robot), None, 2.0, EXACT, v0=[3.0])
    np.testing.assert_allclose(slowed.v[:, 0], 3.0 * np.exp(-0.25 * slowed.t), rtol=1e-10)
    free = fd.simulate(fd.FlexibleJointModel(robot, urdf_dynamics="ignore"), None, 2.0, EXACT, v0=[3.0])
    np.testing.assert_array_equal(free.v, 3.0)
