"""The robots that ship with flexdyn: every file reads, is physical, and says where each of its numbers comes from."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from ruamel.yaml import YAML

Array = NDArray[np.float64]

ROBOTS = Path(__file__).parents[2] / "robots"
NAMES = ("scara_two_link", "scara", "panda", "ur5")
EXAMPLES = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
EXAMPLE_URDF = {"panda": "panda_description/urdf/panda.urdf", "ur5": "ur_description/urdf/ur5_robot.urdf"}
MIMICS = {"panda_finger_joint2": "panda_finger_joint1"}
PARAMETERS = {
    "viscous_friction": {"joint", "side", "coefficient"},
    "coulomb_friction": {"joint", "side", "level"},
    "stribeck_friction": {"joint", "side", "excess", "velocity", "exponent"},
    "transmission_damping": {"joint", "coefficient"},
    "torque_speed_limit": {"joint", "side", "stall_torque", "no_load_speed"},
    "torque_offset": {"joint", "offset"},
    "payload": {"mass", "frame"},
}
# Hz, of all elastic modes: the paper's arm is soft on purpose; the SCARA's screw and belted wrist are its stiffest.
BANDS = {"scara_two_link": (0.3, 3.0), "scara": (2.0, 250.0), "panda": (2.0, 200.0), "ur5": (2.0, 200.0)}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def read(name: str) -> dict[str, Any]:
    """The model file as plain data, read by YAML 1.2 rules."""
    data: dict[str, Any] = YAML(typ="safe").load((ROBOTS / name / "model.yaml").read_text(encoding="utf-8"))
    return data


def robot(name: str) -> Any:
    """Pinocchio's model of it, reduced to the joints that the model file describes, with payloads attached."""
    data = read(name)
    path = ROBOTS / name / "robot.urdf" if name not in EXAMPLE_URDF else EXAMPLES / EXAMPLE_URDF[name]
    model = pin.buildModelFromUrdf(str(path))
    others = [model.getJointId(joint) for joint in list(model.names)[1:] if joint not in data["joints"]]
    model = pin.buildReducedModel(model, others, pin.neutral(model))
    for effect in data["effects"]:
        if effect["effect"] == "payload":
            frame = model.frames[model.getFrameId(effect["frame"])]
            point = pin.Inertia(effect["mass"], np.zeros(3), np.zeros((3, 3)))
            model.appendBodyToJoint(frame.parentJoint, point, frame.placement)
    return model


def configuration(model: Any, q: dict[str, float]) -> Array:
    """Angles by joint name as Pinocchio's vector, where a continuous joint is (cos, sin)."""
    vector: Array = pin.neutral(model)
    for name, value in q.items():
        joint = model.joints[model.getJointId(name)]
        vector[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
    return vector


def mass_matrix(model: Any, q: Array) -> Array:
    """M(q), both triangles."""
    upper = np.triu(pin.crba(model, model.createData(), q))
    return np.asarray(upper + np.triu(upper, 1).T)


def joint_numbers(name: str, key: str) -> Array:
    """One number per joint, in the order of the robot."""
    joints = read(name)["joints"]
    return np.array([joints[joint][key] for joint in list(robot(name).names)[1:]])


def numbers_in(data: Any) -> set[float]:
    """All numbers in nested data."""
    if isinstance(data, dict):
        return set().union(*(numbers_in(value) for value in data.values()))
    if isinstance(data, list):
        return set().union(*(numbers_in(value) for value in data))
    return {float(data)} if isinstance(data, (int, float)) else set()


@pytest.mark.parametrize("name", NAMES)
def test_file_uses_known_effects_on_known_joints_and_frames(name: str) -> None:
    """Every effect names its parameters, all numbers, and a joint or frame that exists."""
    data = read(name)
    model = robot(name)
    assert data["flexdyn"] == 1
    for effect in data["effects"]:
        kind = effect.pop("effect")
        assert set(effect) == PARAMETERS[kind]
        values = {key: value for key, value in effect.items() if key not in ("joint", "side", "frame")}
        assert all(isinstance(value, float) and np.isfinite(value) and value > 0 for value in values.values())
        assert effect["joint"] in data["joints"] if "joint" in effect else model.existFrame(effect["frame"])


@pytest.mark.parametrize("name", NAMES)
def test_every_joint_is_described_or_locked(name: str) -> None:
    """The file names each joint of the URDF exactly once: elastic, locked, or following a locked one."""
    data = read(name)
    path = ROBOTS / name / "robot.urdf" if name not in EXAMPLE_URDF else EXAMPLES / EXAMPLE_URDF[name]
    locked = set(data["robot"].get("lock", {}))
    following = {joint for joint, leader in MIMICS.items() if leader in locked}
    assert set(list(pin.buildModelFromUrdf(str(path)).names)[1:]) == set(data["joints"]) | locked | following
    assert set(data["initial"]["q"]) <= set(data["joints"])
    for joint in data["joints"].values():
        assert set(joint) == {"gear_ratio", "rotor_inertia", "stiffness", "damping"}
        assert all(isinstance(value, float) for value in joint.values())
        assert min(joint["gear_ratio"], joint["rotor_inertia"], joint["stiffness"]) > 0


@pytest.mark.parametrize("name", NAMES)
def test_every_number_says_where_it_comes_from(name: str) -> None:
    """A line with a number has the paper, a source that the README lists, or a stated choice beside it."""
    readme = (ROBOTS / name / "README.md").read_text(encoding="utf-8")
    for line in (ROBOTS / name / "model.yaml").read_text(encoding="utf-8").splitlines():
        value, _, comment = line.partition("#")
        if not re.search(r"[:\[,]\s*[-+]?[.\d]", value) or value.startswith("flexdyn:"):
            continue
        sources = re.findall(r"\[(\w+)\]", comment)
        assert sources or re.search(r"\b(paper,|chosen: \w)", comment), line
        assert all(f"- [{source}] " in readme for source in sources), line


@pytest.mark.parametrize("name", NAMES)
def test_readme_lists_every_number(name: str) -> None:
    """No number of the model file is missing in the README's table, so that the two cannot drift apart."""
    data = read(name)
    del data["flexdyn"]
    rows = [line for line in (ROBOTS / name / "README.md").read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    listed = {float(number) for row in rows for number in NUMBER.findall(row.split("|")[2])}
    assert numbers_in(data) - {0.0} <= listed


@pytest.mark.parametrize("name", ["scara_two_link", "scara"])
def test_bodies_are_physical(name: str) -> None:
    """Every body can be made of positive mass: its pseudo-inertia has no negative eigenvalue."""
    for inertia in list(robot(name).inertias)[1:]:
        eigenvalues = np.linalg.eigvalsh(inertia.toPseudoInertia().toMatrix())
        assert inertia.mass > 0
        assert eigenvalues.min() > -1e-12 * eigenvalues.max()


def test_two_link_arm_is_the_paper_s() -> None:
    """Pinocchio's M and Coriolis terms equal eq. 16-19 and 12-13 with Table I at random states; no gravity acts."""
    model = robot("scara_two_link")
    length, mass, tool = 1.05, 0.405 * 1.05, 0.1
    centre, inertia = length / 2, mass * length**2 / 12
    rng = np.random.default_rng(0)
    for q1, angle, v1, v2 in rng.uniform(-4.0, 4.0, (200, 4)):
        cosine = np.cos(angle)
        d11 = mass * centre**2 + inertia + mass * (length**2 + centre**2 + 2 * length * centre * cosine) + inertia
        d11 += tool * (2 * length**2 + 2 * length**2 * cosine)
        d22 = mass * centre**2 + inertia + tool * length**2
        d12 = mass * length * centre * cosine + mass * centre**2 + inertia + tool * length**2 * (1 + cosine)
        c = (mass * length * centre + tool * length**2) * np.sin(angle)
        q = configuration(model, {"shoulder": q1, "elbow": angle})
        np.testing.assert_allclose(mass_matrix(model, q), [[d11, d12], [d12, d22]], rtol=1e-12, atol=1e-14)
        bias = pin.nonLinearEffects(model, model.createData(), q, np.array([v1, v2]))
        np.testing.assert_allclose(bias, [-c * v2**2 - 2 * c * v1 * v2, c * v1**2], rtol=1e-11, atol=1e-12)


def test_two_link_actuator_is_the_line_of_table_1() -> None:
    """Table I's 0.18 N m s/rad is the slope of stall torque over no-load speed."""
    limits = [effect for effect in read("scara_two_link")["effects"] if effect["effect"] == "torque_speed_limit"]
    assert [limit["stall_torque"] / limit["no_load_speed"] for limit in limits] == pytest.approx([0.18, 0.18])


def test_gravity_loads_the_scara_s_vertical_axis_alone() -> None:
    """Two vertical axes and a turning tool carry no weight; the slide carries all that hangs on it."""
    model = robot("scara")
    q = configuration(model, read("scara")["initial"]["q"])
    weight = 9.81 * (0.3 + 0.986 + 0.6 + 2.0)
    np.testing.assert_allclose(
        pin.computeGeneralizedGravity(model, model.createData(), q), [0, 0, weight, 0], atol=1e-12
    )


@pytest.mark.parametrize("name", NAMES)
def test_joint_modes_lie_where_such_robots_have_them(name: str) -> None:
    """With links and rotors free there are n rigid motions at 0 Hz and n elastic modes in a plausible band."""
    model = robot(name)
    M = mass_matrix(model, configuration(model, read(name)["initial"]["q"]))
    J = joint_numbers(name, "rotor_inertia") * joint_numbers(name, "gear_ratio") ** 2
    K = np.diag(joint_numbers(name, "stiffness"))
    n = model.nv
    full = np.block([[M, np.zeros((n, n))], [np.zeros((n, n)), np.diag(J)]])
    root = np.linalg.inv(np.linalg.cholesky(full))
    squares = np.linalg.eigvalsh(root @ np.block([[K, -K], [-K, K]]) @ root.T)
    low, high = BANDS[name]
    assert np.abs(squares[:n]).max() < 1e-9 * squares[-1]
    frequencies = np.sqrt(squares[n:]) / (2 * np.pi)
    assert low < frequencies.min() <= frequencies.max() < high


@pytest.mark.parametrize("name", ["scara", "ur5"])
def test_chosen_damping_is_five_percent_of_critical(name: str) -> None:
    """Damping that the file calls 5 % of critical is that, rotor held, at the first pose, to two figures."""
    model = robot(name)
    inertia = np.diag(mass_matrix(model, configuration(model, read(name)["initial"]["q"])))
    critical = 2 * np.sqrt(joint_numbers(name, "stiffness") * inertia)
    np.testing.assert_allclose(joint_numbers(name, "damping") / critical, 0.05, rtol=0.03)
