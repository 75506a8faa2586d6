"""Base parameters: counts and sums that are known in closed form or from the literature, and standard deviations."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexdyn as fd

LENGTH, G = 0.7, 9.81
ARM = f"""<robot name="arm"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0.3 0.1 0"/><mass value="4"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial></link>
  <joint name="one" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="two" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="{LENGTH} 0 0"/><axis xyz="0 0 1"/></joint></robot>"""


def planar(tmp_path: Path, *, gravity: bool, **joints: fd.Joint) -> fd.FlexibleJointModel:
    """A planar arm of two links, upright or lying; no rotors unless given."""
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")
    pull = (0.0, -G, 0.0) if gravity else (0.0, 0.0, -G)
    return fd.FlexibleJointModel(fd.load_robot(tmp_path / "arm.urdf"), joints=joints, gravity=pull)


def samples(n: int, count: int = 60) -> dict[str, Any]:
    """Positions, velocities and accelerations that excite everything."""
    q, v, a = np.random.default_rng(0).uniform(-2.0, 2.0, (3, count, n))
    return {"q": q, "v": v, "a": a}


def inertial(found: fd.BaseParameters) -> list[dict[str, float]]:
    """The sums of bodies' numbers, those of rotors alone left out."""
    return [dict(each.terms) for each in found.combinations if not next(iter(each.terms)).endswith(".J")]


def test_an_upright_two_link_arm_has_six_and_they_are_the_closed_form(tmp_path: Path) -> None:
    """Izz1 + l^2 m2 (+ J1), mx1 + l m2, my1, mx2, my2, Izz2: the sums of the textbook's equations."""
    found = inertial(fd.base_parameters(planar(tmp_path, gravity=True), **samples(2)))
    wanted = [
        {"one.mx": 1.0, "two.m": LENGTH},
        {"one.my": 1.0},
        {"one.Izz": 1.0, "two.m": LENGTH**2, "one.J": 1.0},
        {"two.mx": 1.0},
        {"two.my": 1.0},
        {"two.Izz": 1.0},
    ]
    assert [list(each) for each in found] == [list(each) for each in wanted]
    for each, terms in zip(found, wanted, strict=True):
        assert list(each.values()) == pytest.approx(list(terms.values()), abs=1e-9)


def test_a_pendulum_has_three(tmp_path: Path) -> None:
    """Its first moments and Izz + J, for ``tau = (Izz + J) a + G (mx cos q - my sin q)``."""
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")
    pendulum = fd.load_robot(tmp_path / "arm.urdf", lock={"two": 0.0})
    found = fd.base_parameters(fd.FlexibleJointModel(pendulum, gravity=(0.0, -G, 0.0)), **samples(1))
    assert [list(each) for each in inertial(found)] == [["one.mx"], ["one.my"], ["one.Izz", "one.J"]]


def test_a_lying_two_link_arm_has_four_and_its_second_rotor(tmp_path: Path) -> None:
    """Without gravity first moments of the first link do nothing; J2 is told apart from Izz2 by the coupling."""
    found = fd.base_parameters(planar(tmp_path, gravity=False), **samples(2))
    assert [next(iter(each.terms)) for each in found.combinations] == [
        "one.Izz",
        "two.mx",
        "two.my",
        "two.Izz",
        "two.J",
    ]
    assert {"one.m", "one.mx", "one.my", "two.mz"} <= set(found.silent)
    assert found.alone == ("two.mx", "two.my", "two.Izz", "two.J")
    assert found.combined == ("one.Izz", "two.m", "one.J")


def test_values_are_those_of_the_model(tmp_path: Path) -> None:
    """Izz about the joint by Steiner, with the second link's mass and the rotor."""
    model = planar(tmp_path, gravity=False, one=fd.Joint(gear_ratio=10.0, rotor_inertia=0.02))
    first = fd.base_parameters(model, **samples(2)).combinations[0]
    assert first.value == pytest.approx(0.3 + 4.0 * (0.3**2 + 0.1**2) + LENGTH**2 * 3.0 + 2.0)


def test_six_joints_have_the_thirty_six_of_the_literature() -> None:
    """UR5 and PUMA have 36 inertial base parameters each (Mayeda, Yoshida and Osuka, 1990), and rotors of 3 to 6."""
    found = fd.base_parameters(fd.load_model("ur5"), **samples(6))
    assert len(inertial(found)) == 36
    assert found.rank == 40


def test_torques_are_those_of_inverse_dynamics() -> None:
    """W p is M a + h + J a: the columns and the model's own values make the arm's torques."""
    from flexdyn.analysis.regressor import regressor

    model, at = fd.load_model("ur5").resolved(), samples(6, 5)
    whole = regressor(model, at["q"], at["v"], at["a"], at["v"], at["a"])
    values = whole.values * ~np.char.endswith(np.array(whole.names), "coulomb")
    values *= ~np.char.endswith(np.array(whole.names), "viscous")
    links = fd.LinkSide(model)
    M, h = links.mass_matrix(at["q"]), links.bias(at["q"], at["v"])
    wanted = np.einsum("tij,tj->ti", M, at["a"]) + h + model.rotor_inertia * at["a"]
    assert (whole.columns @ values).reshape(-1, 6) == pytest.approx(wanted, abs=1e-9)


def test_standard_deviations_are_those_of_repeated_estimates(tmp_path: Path) -> None:
    """Drawn torque noise, least squares on a hand-made regressor: the spread of mx2 is the one that is promised."""
    model, at, draw = planar(tmp_path, gravity=False), samples(2), np.random.default_rng(1)
    found = fd.base_parameters(model, **at, noise=0.5)
    (q2, (v1, v2), (a1, a2)) = at["q"][:, 1], at["v"].T, at["a"].T
    c, s = LENGTH * np.cos(q2), LENGTH * np.sin(q2)
    zero = np.zeros_like(a1)
    one = np.stack(
        [
            a1,
            c * (2 * a1 + a2) - s * (2 * v1 * v2 + v2**2),
            -s * (2 * a1 + a2) - c * (2 * v1 * v2 + v2**2),
            a1 + a2,
            zero,
        ],
        1,
    )
    two = np.stack([zero, c * a1 + s * v1**2, -s * a1 + c * v1**2, a1 + a2, a2], 1)
    W = np.concatenate([one, two])
    noise = 0.5 * draw.standard_normal((len(W), 4000))
    spread = np.linalg.lstsq(W, noise, rcond=None)[0].std(axis=1)
    assert [each.std for each in found.combinations] == pytest.approx(spread, rel=0.05)


def test_numbers_of_the_file_have_verdicts(tmp_path: Path) -> None:
    """A lying arm: the first link's mass and inertia act in one sum; the second's inertia is told by a quiet sensor."""
    model = planar(tmp_path, gravity=False, two=fd.Joint(gear_ratio=10.0, rotor_inertia=0.02))
    quiet = {(each.of, each.parameter): each for each in fd.base_parameters(model, **samples(2), noise=1e-3).numbers}
    assert quiet["two", "rotor_inertia"].verdict == "told"
    assert quiet["upper", "link_mass"].verdict == quiet["upper", "link_inertia"].verdict == "combined"
    assert np.isinf(quiet["upper", "link_mass"].std)
    loud = fd.base_parameters(model, **samples(2), noise=1e3).numbers
    assert {each.verdict for each in loud} == {"combined", "weak"}


def test_a_recording_is_differentiated_and_a_poor_motion_is_seen() -> None:
    """One joint that swings while the other hardly moves: worse conditioned than both swinging."""
    model, t = fd.load_model("scara_two_link"), np.arange(0.0, 4.0, 0.004)

    def motion(second: float) -> fd.Recording:
        noise = 1e-6 * np.random.default_rng(2).standard_normal((2, len(t)))
        q = np.stack([0.8 * np.sin(3.0 * t), second * np.sin(5.0 * t + 0.3)]) + noise
        return fd.Recording(t, {f"q.{joint}": each for joint, each in zip(model.joint_names, q, strict=True)})

    rich, poor = fd.base_parameters(model, motion(0.8)), fd.base_parameters(model, motion(0.02))
    assert rich.rank == poor.rank == 5
    assert poor.condition > 5.0 * rich.condition
    assert pickle.loads(pickle.dumps(rich)) == rich  # noqa: S301 - our own bytes
    assert str(rich).startswith("5 combinations from")


def test_friction_is_unknown_where_it_is_asked_for() -> None:
    """Three numbers a joint more, and none of them in a sum with an inertia."""
    model = fd.load_model("scara_two_link")
    found = fd.base_parameters(model, **samples(2), friction=True)
    assert found.rank == 5 + 6
    assert {"shoulder.viscous", "elbow.coulomb", "elbow.offset"} <= set(found.alone)


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ({}, "motion"),
        ({"q": np.zeros((3, 2))}, "motion"),
        ({"q": np.zeros((3, 2)), "v": np.zeros((3, 2)), "a": np.zeros((2, 2))}, "a"),
        ({"q": np.full((3, 2), np.nan), "v": np.zeros((3, 2)), "a": np.zeros((3, 2))}, "q"),
        (samples(2) | {"noise": 0.0}, "noise"),
        (samples(2) | {"noise": [1.0, 1.0, 1.0]}, "noise"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(arguments: dict[str, Any], key: str) -> None:
    """No motion, half a motion, ragged or NaN samples, a noise that is none."""
    with pytest.raises(fd.InputError) as error:
        fd.base_parameters(fd.load_model("scara_two_link"), **arguments)
    assert error.value.key == key


def test_a_joint_without_position_is_named() -> None:
    """A recording must have q or theta of every joint."""
    model, t = fd.load_model("scara_two_link"), np.arange(0.0, 1.0, 0.004)
    with pytest.raises(fd.InputError, match="elbow"):
        fd.base_parameters(model, fd.Recording(t, {"q.shoulder": np.sin(t)}))
