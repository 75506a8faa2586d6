"""The link side is the paper's: Pinocchio's M, Coriolis and accelerations against eq. 12-19 in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.model.uncertain_parameters import file_numbers
from tests.arms import coupled, two_link
from tests.diagnose.truths import slider_model
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
COUNT = 1000


@pytest.fixture(scope="module")
def states() -> tuple[Array, Array, Array]:
    """Random positions, velocities and torques."""
    rng = np.random.default_rng(7)
    return rng.uniform(-7, 7, (COUNT, 2)), rng.normal(0, 3, (COUNT, 2)), rng.normal(0, 2, (COUNT, 2))


def worst(got: Array, expected: Array) -> float:
    """Largest error relative to the size of the row that it stands in."""
    size = np.linalg.norm(expected.reshape(COUNT, -1), axis=1)
    return float((np.linalg.norm((got - expected).reshape(COUNT, -1), axis=1) / size).max())


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_equations_of_the_paper(states: tuple[Array, Array, Array], gravity: float) -> None:
    """M, h and a equal eq. 12, 13 and 16-19 to 1e-11 at 1,000 random states, with gravity in the plane too."""
    q, v, tau = states
    arm = TwoLink(gravity=gravity)
    links = fd.LinkSide(two_link(arm))
    M = np.array([[[d11, d12], [d12, d22]] for d11, d22, d12, _ in (arm.inertias(row[1]) for row in q)])
    h = np.array([arm.bias(*row) for row in zip(q, v, strict=True)])
    a = np.array([arm.accelerations(*row) for row in zip(q, v, tau, strict=True)])
    assert worst(links.mass_matrix(q), M) < 1e-11
    assert worst(links.bias(q, v), h) < 1e-11
    assert worst(links.acceleration(q, v, tau), a) < 1e-11
    assert worst(links.inverse_dynamics(q, v, a), tau) < 1e-10


def test_rigid_joints_carry_their_rotors(states: tuple[Array, Array, Array]) -> None:
    """The J of a rigid joint, and of no other, stands on the diagonal of M."""
    q, v, tau = states
    arm = TwoLink(stiffness=(5.5, math.inf), rotor=(0.2, 0.3))
    links = fd.LinkSide(two_link(arm))
    expected = np.array([arm.accelerations(*row) for row in zip(q, v, tau, strict=True)])
    assert worst(links.acceleration(q, v, tau), expected) < 1e-11
    assert worst(links.inverse_dynamics(q, v, expected), tau) < 1e-10
    bare = fd.LinkSide(two_link(TwoLink())).mass_matrix(q)
    np.testing.assert_allclose(links.mass_matrix(q) - bare, np.broadcast_to(np.diag([0, 0.3]), bare.shape), atol=1e-14)


def test_payload_is_a_mass_at_the_tip(states: tuple[Array, Array, Array]) -> None:
    """Two payloads add, and act as m_L of eq. 16-19 does."""
    q, v, tau = states
    payloads = [fd.effects.Payload(mass=0.3), fd.effects.Payload(mass=0.4, frame="tool")]
    arm = TwoLink(gravity=9.81, tip_mass=0.8)
    links = fd.LinkSide(two_link(arm, payloads))
    expected = np.array([arm.accelerations(*row) for row in zip(q, v, tau, strict=True)])
    assert worst(links.acceleration(q, v, tau), expected) < 1e-11


def test_mimic_joints_are_projected(
    states: tuple[Array, Array, Array], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """M = D11 + 2 c D12 + c^2 D22 and h = h1 + c h2 where q2 = c q1 + d."""
    c, d = -1.5, 0.4
    arm = TwoLink(gravity=9.81, tip_mass=0.0)
    robot = coupled(tmp_path_factory.mktemp("arm"), c, d)
    model = fd.FlexibleJointModel(robot, gravity=[0, -9.81, 0])
    q, v, tau = (column[:, :1] for column in states)
    M, h = np.empty((COUNT, 1, 1)), np.empty((COUNT, 1))
    for i in range(COUNT):
        d11, d22, d12, _ = arm.inertias(c * q[i, 0] + d)
        M[i] = d11 + 2 * c * d12 + c * c * d22
        h1, h2 = arm.bias([q[i, 0], c * q[i, 0] + d], [v[i, 0], c * v[i, 0]])
        h[i] = h1 + c * h2
    links = fd.LinkSide(model)
    assert worst(links.mass_matrix(q), M) < 1e-11
    assert worst(links.bias(q, v), h) < 1e-11
    assert worst(links.acceleration(q, v, tau), (tau - h) / M[:, 0]) < 1e-11
    assert worst(links.inverse_dynamics(q, v, tau), M[:, 0] * tau + h) < 1e-11


@pytest.mark.parametrize("name", ["scara_two_link", "scara", "panda", "ur5"])
def test_kinetic_energy_is_half_v_M_v(name: str) -> None:
    """The energy of the links is 1/2 v' M v, and every torque of inertia is M a."""
    model = fd.load_model(name)
    links, rng = fd.LinkSide(model), np.random.default_rng(1)
    q, v, a = rng.normal(0, 1, (3, 50, model.n))
    M = links.mass_matrix(q)
    kinetic, _ = links.energy(q, v)
    np.testing.assert_allclose(kinetic, 0.5 * np.einsum("si,sij,sj->s", v, M, v), rtol=1e-11)
    tau = np.einsum("sij,sj->si", M, a) + links.bias(q, v)
    np.testing.assert_allclose(links.acceleration(q, v, tau), a, atol=1e-8)
    assert (np.linalg.eigvalsh(M) > 0).all()


def test_gravity_torque_is_the_slope_of_the_energy() -> None:
    """h(q, 0) = dU/dq, by central differences over the UR5."""
    model = fd.load_model("ur5")
    links, q, step = fd.LinkSide(model), np.array([0.3, -1.0, 0.8, 0.2, -0.5, 0.1]), 1e-6
    still = np.zeros(6)
    for j in range(6):
        up, down = (links.energy(q + sign * step * np.eye(6)[j], still)[1] for sign in (1, -1))
        assert (up - down) / (2 * step) == pytest.approx(links.bias(q, still)[j], abs=1e-7)


@pytest.mark.parametrize("name", ["ur5", "slider", "mimic"])
def test_slopes_of_the_inverse_dynamics_are_those_of_differences(name: str, tmp_path: Path) -> None:
    """By positions and speeds, central differences; of a joint that leads another, through both."""
    models = {"slider": slider_model, "mimic": lambda folder: fd.FlexibleJointModel(coupled(folder, -1.5, 0.4))}
    model = models[name](tmp_path) if name in models else fd.load_model(name)
    links, step = fd.LinkSide(model), 1e-6
    q, v, a = np.random.default_rng(5).normal(0, 1, (3, 20, model.n))
    by_q, by_v = links.inverse_derivatives(q, v, a)
    for j, more in enumerate(step * np.eye(model.n)):
        ahead, behind = (links.inverse_dynamics(q + sign * more, v, a) for sign in (1, -1))
        np.testing.assert_allclose(by_q[..., j], (ahead - behind) / (2 * step), atol=1e-6)
        faster, slower = (links.inverse_dynamics(q, v + sign * more, a) for sign in (1, -1))
        np.testing.assert_allclose(by_v[..., j], (faster - slower) / (2 * step), atol=1e-6)
    with pytest.raises(ValueError, match="derivatives are"):
        links._links.inverse_derivatives(q, v, a, by_q[0], by_v)


def test_wrong_number_of_columns_is_refused() -> None:
    """A state of another arm is an error, not a reading past its end."""
    links = fd.LinkSide(fd.load_model("scara_two_link"))
    with pytest.raises(fd.InputError, match="2 columns are needed"):
        links.mass_matrix(np.zeros((5, 3)))
    with pytest.raises(fd.InputError, match="2 columns are needed"):
        links.bias(0.0, 0.0)


@pytest.mark.parametrize("name", ["scara", "panda", "ur5", "slider"])
def test_other_inertias_need_more_as_pinocchio_says(name: str, tmp_path: Path) -> None:
    """Heavier links, others' centres, a payload and a rotor, all in one pass: M' a + h' less M a + h, one by one."""
    model = slider_model(tmp_path) if name == "slider" else fd.load_model(name)
    rotors = {joint: fd.Joint(rotor_inertia=0.1) for joint in model.joint_names}
    given = model.replace(joints=rotors)
    errors = [number.error(1.1) for number in file_numbers(given) if number.joint is None]
    others = [given.replace(effects=[each]) for each in (*errors, fd.effects.Payload(mass=0.4))]
    others += [given.replace(joints={**rotors, model.joint_names[-1]: fd.Joint(rotor_inertia=0.3)})]
    links, rng = fd.LinkSide(given), np.random.default_rng(3)
    q, v, a = rng.normal(0, 1, (3, 20, model.n))
    sides = [fd.LinkSide(each) for each in others]
    expected = np.stack([each.inverse_dynamics(q, v, a) - links.inverse_dynamics(q, v, a) for each in sides], axis=1)
    assert (np.abs(expected).max(axis=(0, 2)) > 1e-6).sum() >= 3
    assert np.abs(expected[:, -2:]).max(axis=(0, 2)).min() > 1e-2
    np.testing.assert_allclose(links.extra_torques(sides, q, v, a), expected, atol=1e-10)


def test_a_mimic_joints_inertia_is_projected(tmp_path: Path) -> None:
    """What the tip of a coupled arm carries loads the joint that leads through both."""
    model = fd.FlexibleJointModel(coupled(tmp_path, -1.5, 0.4), gravity=[0, -9.81, 0])
    links, other = (fd.LinkSide(model.replace(effects=more)) for more in ([], [fd.effects.Payload(mass=0.4)]))
    q, v, a = np.random.default_rng(4).normal(0, 1, (3, 20, 1))
    expected = other.inverse_dynamics(q, v, a) - links.inverse_dynamics(q, v, a)
    assert np.abs(expected).min() > 1e-3
    np.testing.assert_allclose(links.extra_torques([other], q, v, a)[:, 0], expected, atol=1e-12)
