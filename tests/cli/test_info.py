"""flexdyn info: the numbers of robots and models."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import flexdyn as fd
from tests.arms import SLIDER
from tests.cli.conftest import Runner


def test_a_name_that_is_both_is_the_shipped_model(flexdyn: Runner) -> None:
    """The name panda is a robot and a model: the model is taken, and said to be."""
    found = flexdyn("info", "panda", "--json").json
    assert found["taken"] == "shipped model"
    assert all(joint["elastic"] for joint in found["joints"])
    assert "taken for a shipped model" in flexdyn("info", "panda").out


def test_inertias_are_pinocchios(flexdyn: Runner) -> None:
    """M at --q is the joint-space inertia of Pinocchio's own CRBA; the moving mass is the sum over its bodies."""
    robot = fd.load_robot("ur5")
    q = np.linspace(-1.0, 1.5, 6)
    found = flexdyn("info", fd.robot.names.find_robot("ur5")[0], "--json", "--q", ",".join(map(repr, q.tolist()))).json
    model = robot.pin_model
    M = pin.crba(model, model.createData(), q)
    M = np.triu(M) + np.triu(M, 1).T
    np.testing.assert_allclose(np.array(found["mass_matrix"]), M, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose([joint["inertia"] for joint in found["joints"]], np.diag(M), rtol=1e-12)
    assert found["moving_mass"] == pytest.approx(sum(body.mass for body in list(model.inertias)[1:]))
    assert found["taken"] == "URDF file"


def test_frequencies_of_a_mass_on_a_spring(flexdyn: Runner) -> None:
    """2.5 kg on 1000 N/m: sqrt(K/m)/2pi with the rotor held, sqrt(K (1/m + 1/J))/2pi with it free, J = 0.5 kg."""
    Path("lift.urdf").write_text(SLIDER, encoding="utf-8")
    Path("lift.yaml").write_text(
        "flexdyn: 1\nrobot: {urdf: lift.urdf}\n"
        "joints: {lift: {stiffness: 1000, rotor_inertia: 5.0e-3, gear_ratio: 10}}",
        encoding="utf-8",
    )
    (joint,) = flexdyn("info", "lift.yaml", "--json").json["joints"]
    assert joint["reflected_inertia"] == pytest.approx(0.5)
    assert joint["locked_rotor_frequency"] == pytest.approx(math.sqrt(1000 / 2.5) / (2 * math.pi))
    assert joint["free_frequency"] == pytest.approx(math.sqrt(1000 / 2.5 + 1000 / 0.5) / (2 * math.pi))
    out = flexdyn("info", "lift.yaml").out
    assert "-100 to 100 m" in out
    assert "1000 N" in out
    assert "3.183 Hz" in out


def test_infinite_numbers_are_null_in_json(flexdyn: Runner) -> None:
    """A rigid joint has no stiffness and no frequency that JSON could hold; an unlimited one no limits."""
    found = flexdyn("info", "double_pendulum_continuous", "--json").json
    assert len(found["joints"]) == 2
    for joint in found["joints"]:
        assert joint["type"] == "continuous"
        assert joint["stiffness"] is None
        assert joint["locked_rotor_frequency"] is None
        assert joint["upper"] is None
        assert not joint["elastic"]


def test_effects_of_the_urdf_are_marked(flexdyn: Runner) -> None:
    """<dynamics> counts as effects, but not as effects[i] of the file."""
    Path("arm.urdf").write_text(
        SLIDER.replace("<axis", '<dynamics damping="0.5" friction="0.2"/><axis'), encoding="utf-8"
    )
    Path("arm.yaml").write_text(
        "flexdyn: 1\nrobot: {urdf: arm.urdf}\neffects: [{effect: payload, mass: 1.5}, "
        "{effect: coulomb_friction, joint: lift, side: motor, level: 0}]",
        encoding="utf-8",
    )
    found = flexdyn("info", "arm.yaml", "--json").json
    rows = [(effect["from"], effect["effect"], effect["neutral"]) for effect in found["effects"]]
    assert rows == [
        ("effects[0]", "payload", False),
        ("effects[1]", "coulomb_friction", True),
        ("URDF", "viscous_friction", False),
        ("URDF", "coulomb_friction", False),
    ]
    assert found["effects"][2]["parameters"] == {"coefficient": {"value": 0.5, "unit": "N s/m"}}
    assert found["payload"] == 1.5
    assert found["joints"][0]["inertia"] == pytest.approx(2.5 + 1.5)
    assert "neutral: it changes nothing" in flexdyn("info", "arm.yaml").out


def test_branches_followers_and_locks_are_told(flexdyn: Runner) -> None:
    """A branched hand has no one tip; a gripper's second finger follows its first; a locked joint is named."""
    assert flexdyn("info", "allegro_right_hand", "--json").json["tip"] is None
    followers = flexdyn("info", "panda_collision", "--json").json["followers"]
    assert followers["panda_finger_joint2"] == ["panda_finger_joint1", 1.0, 0.0]
    assert "panda_finger_joint2" in flexdyn("info", "panda_collision").out
    assert "locked: panda_finger_joint1 at 0" in flexdyn("info", "panda").out


def test_positions_by_name_leave_the_others_at_the_models_own(flexdyn: Runner) -> None:
    """--q elbow=0.5 moves the elbow alone."""
    positions = [joint["q"] for joint in flexdyn("info", "scara", "--json", "--q", "joint3=-0.05").json["joints"]]
    assert positions == [0.0, math.pi / 2, -0.05, 0.0]


def test_modes_of_a_mass_on_a_spring(flexdyn: Runner) -> None:
    """2.5 kg and J = 0.5 kg on 1000 N/m and 4 N s/m: free, held and the motor's anti-resonance in closed form."""
    Path("lift.urdf").write_text(SLIDER, encoding="utf-8")
    Path("lift.yaml").write_text(
        "flexdyn: 1\nrobot: {urdf: lift.urdf}\n"
        "joints: {lift: {stiffness: 1000, damping: 4, rotor_inertia: 5.0e-3, gear_ratio: 10}}",
        encoding="utf-8",
    )
    found = flexdyn("info", "lift.yaml", "--modes", "--json", "--q", "0.2").json["modes"]
    assert found["q"] == {"lift": 0.2}
    rigid, vibrating = found["free"]
    assert (rigid["kind"], rigid["frequency"], rigid["damping_ratio"]) == ("rigid-body", 0.0, None)
    reduced = 1.0 / (1 / 2.5 + 1 / 0.5)
    assert vibrating["frequency"] == pytest.approx(math.sqrt(1000 / reduced) / math.tau)
    assert vibrating["damping_ratio"] == pytest.approx(4 / (2 * math.sqrt(1000 * reduced)))
    assert vibrating["dominant"] == {"joint": "lift", "part": "rotor"}  # the lighter of the two
    assert vibrating["link"]["lift"] == pytest.approx(-0.5 / 2.5)
    (held,) = found["held"]
    assert held["frequency"] == pytest.approx(math.sqrt(1000 / 2.5) / math.tau)
    assert held["dominant"] == {"joint": "lift", "part": "link"}
    assert found["anti_resonances"]["lift"] == pytest.approx([held["frequency"]])
    out = flexdyn("info", "lift.yaml", "--modes").out
    assert "7.797 Hz" in out
    assert "9.8 %" in out
    assert "lift rotor 1, lift link -0.2" in out
    assert "rigid-body" in out


def test_modes_are_those_of_the_python_interface(flexdyn: Runner) -> None:
    """Frequencies, ratios and shapes of the UR5 at --q, and the table names every mode and motor."""
    arguments = ("info", "ur5", "--modes", "--q", "elbow_joint=0.7")
    found = flexdyn(*arguments, "--json").json["modes"]
    expected = fd.modes(fd.load_model("ur5"), {"elbow_joint": 0.7})
    assert [row["frequency"] for row in found["free"]] == expected.frequencies.tolist()
    assert [row["kind"] for row in found["free"]] == list(expected.kinds)
    for row, link, rotor in zip(found["free"], expected.link_shapes, expected.rotor_shapes, strict=True):
        size = np.abs(link).max(), np.abs(rotor).max()
        part, shape = ("link", link) if size[0] >= size[1] else ("rotor", rotor)
        assert row["dominant"] == {"joint": expected.joint_names[int(np.argmax(np.abs(shape)))], "part": part}
    out = flexdyn(*arguments).out
    assert all(f"{frequency:.4g} Hz" in out for frequency in expected.frequencies)
    assert out.count("Hz, ") >= len(expected.joint_names)


def test_a_rigid_arm_has_no_modes_with_its_rotors_held(flexdyn: Runner) -> None:
    """A double pendulum of rigid joints swings; held, nothing is left to move, and that is null."""
    found = flexdyn("info", "double_pendulum", "--modes", "--json").json["modes"]
    assert len(found["free"]) == 2
    assert found["held"] is None
    out = flexdyn("info", "double_pendulum", "--modes").out
    assert "rotors held" not in out
    assert "rotor 1" not in out


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_frequencies_over_a_run_are_drawn(flexdyn: Runner, suffix: str) -> None:
    """--path and -o draw them over the q of a recording; lines of the SVG are the frequencies of Python's function."""
    flexdyn("simulate", "scara_two_link", "--duration", "0.5", "--v0", "0,3", "-o", "run.npz")
    outcome = flexdyn("info", "scara_two_link", "--modes", "--path", "run.npz", "-o", f"frequencies{suffix}")
    assert outcome.code == 0
    assert f"drawn in frequencies{suffix}" in outcome.out
    if suffix == ".svg":
        text = Path("frequencies.svg").read_text(encoding="utf-8")
        assert "eigenfrequency [Hz]" in text
        assert "400 poses of shoulder, elbow; rotors free" in text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-o", "f.png"), "flexdyn: --modes: it is missing; a picture of frequencies needs --modes --path RUN -o FILE"),
        (("--modes", "--path", "run.npz"), "flexdyn: --output: it is missing"),
        (("--modes", "-o", "f.png"), "flexdyn: --path: it is missing"),
        (("--modes", "--path", "run.npz", "-o", "f.gif"), "flexdyn: f.gif: --output: unknown suffix"),
        (("--modes", "--path", "none.npz", "-o", "f.png"), "flexdyn: none.npz: "),
        (("--modes", "--path", "run.npz", "-o", "f.png"), "flexdyn: run.npz: q.panda_joint1: no such channel"),
    ],
)
def test_a_picture_that_cannot_be_drawn(flexdyn: Runner, options: tuple[str, ...], words: str) -> None:
    """One line that names what is missing or does not fit, and no picture."""
    fd.write_recording(fd.Recording([0.0, 1.0], {"q.elbow": [0.0, 1.0]}), "run.npz")
    outcome = flexdyn("info", "panda", *options)
    assert outcome.code == 2
    assert outcome.err.startswith(words)
    assert outcome.err.count("\n") == 1
    assert [path.name for path in Path().iterdir()] == ["run.npz"]


def test_motors_under_voltage_are_told(flexdyn: Runner, tmp_path: Path) -> None:
    """Their numbers with units, those that are there, in the table and as JSON."""
    motor = {"torque_constant": 0.05, "resistance": 1.2, "supply": 24.0, "inductance": 2e-4}
    arm = fd.load_model("scara_two_link").replace(joints={"elbow": {"actuator": {"dc_motor": motor}}})
    fd.save_model(arm, tmp_path / "arm.yaml")
    shown = flexdyn("info", tmp_path / "arm.yaml")
    assert "Motors under voltage" in shown.out
    assert all(word in shown.out for word in ("0.05 N m/A", "1.2 ohm", "24 V", "0.0002 H"))
    document = flexdyn("info", tmp_path / "arm.yaml", "--json").json
    assert [joint["actuator"] for joint in document["joints"]] == [None, {"dc_motor": motor}]
    assert "Motors under voltage" not in flexdyn("info", "ur5").out
