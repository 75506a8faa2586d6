"""flexdyn new: what it writes loads back as the plain model of the robot."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexdyn as fd
from flexdyn.cli.new import quoted
from flexdyn.io.yaml import parse_yaml
from flexdyn.model.model_file import model_to_dict
from tests.arms import SLIDER
from tests.cli.conftest import Runner

NASTY = [
    "null",
    "yes",
    ".inf",
    "1e5",
    "a: b",
    "- a",
    "#",
    "'",
    '"\\U',
    "",
    "*",
    "0x10",
    "é",
    "a\u2028\x85\n\t",
    "😀",
    "~",
]


@pytest.mark.parametrize("robot", ["panda", "ur5", "double_pendulum", "allegro_right_hand", "scara", "baxter"])
def test_the_file_loads_back_as_the_plain_model(flexdyn: Runner, robot: str) -> None:
    """A rigid joint for every joint of the URDF and not one number changed."""
    assert flexdyn("new", robot, "-o", "arm.yaml").code == 0
    model = fd.load_model("arm.yaml")
    assert model == fd.FlexibleJointModel(fd.load_robot(robot), name="arm")
    text = Path("arm.yaml").read_text(encoding="utf-8")
    assert all(f"\n  {joint}:  # " in text for joint in model.joint_names)


@pytest.mark.parametrize("rigid", [False, True])
def test_every_example_effect_can_be_uncommented(flexdyn: Runner, rigid: bool) -> None:
    """Without their # the effects load, each with its own parameters; joint_elasticity on a joint that is rigid."""
    flexdyn("new", "double_pendulum", "-o", "arm.yaml")
    lines = Path("arm.yaml").read_text(encoding="utf-8").splitlines()
    for_rigid = "{effect: joint_elasticity"
    text = "\n".join(line.replace("# - {", "- {") if (for_rigid in line) == rigid else line for line in lines)
    text = text.replace("rotor_inertia: 0.0", "rotor_inertia: 1.0e-3")
    text = text if rigid else text.replace("stiffness: .inf", "stiffness: 100.0")
    Path("arm.yaml").write_text(text, encoding="utf-8")
    model = fd.load_model("arm.yaml")
    names = {effect.name for effect in model.effects}
    assert names == ({"joint_elasticity"} if rigid else set(fd.effects.catalogue()) - {"joint_elasticity"})
    assert model.elastic[0]
    assert not any(effect.is_neutral for effect in model.effects)


@pytest.mark.parametrize("robot", ["panda", "ur5", "scara", "double_pendulum"])
def test_the_motion_can_be_uncommented(flexdyn: Runner, robot: str) -> None:
    """One file then simulates: the first joint goes where the points say, within its limits and stably."""
    flexdyn("new", robot, "-o", "arm.yaml")
    lines = Path("arm.yaml").read_text(encoding="utf-8").splitlines()
    begin = lines.index("# command:")
    lines[begin : begin + 5] = [line[2:] for line in lines[begin : begin + 5]]
    Path("arm.yaml").write_text("\n".join(lines), encoding="utf-8")
    outcome = flexdyn("simulate", "arm.yaml", "-o", "run.npz")
    assert outcome.code == 0
    assert "the command is the model file's own" in outcome.err
    run, model = fd.read_recording("run.npz"), fd.load_model("arm.yaml")
    joint = model.joint_names[0]
    low, high = model.robot.lower[0], model.robot.upper[0]
    assert model.command is not None
    goal = model.command["pd"]["reference"][joint][1]
    assert run.duration == 2.0
    assert low - 1e-3 <= run[f"q.{joint}"].min() <= run[f"q.{joint}"].max() <= high + 1e-3
    assert abs(run[f"q.{joint}"][1000] - goal) < 0.2
    assert abs(run.signal("v", model.joint_names)).max() < 10.0


def test_a_joint_alone_is_coupled_to_none(flexdyn: Runner) -> None:
    """Every effect but the one that needs a second joint, and all of them load."""
    Path("lift.urdf").write_text(SLIDER, encoding="utf-8")
    flexdyn("new", "lift.urdf", "-o", "lift.yaml")
    text = Path("lift.yaml").read_text(encoding="utf-8").replace("stiffness: .inf", "stiffness: 100.0")
    text = text.replace("rotor_inertia: 0.0", "rotor_inertia: 1.0e-3")
    lines = [line for line in text.splitlines() if "joint_elasticity," not in line]
    Path("lift.yaml").write_text("\n".join(lines).replace("# - {", "- {"), encoding="utf-8")
    names = {effect.name for effect in fd.load_model("lift.yaml").effects}
    assert names == set(fd.effects.catalogue()) - {"joint_elasticity", "joint_coupling"}


def test_the_suggested_stiffness_is_ten_hertz(flexdyn: Runner) -> None:
    """K of the comment, put in, gives a locked-rotor frequency of 10 Hz within its two printed figures."""
    flexdyn("new", "ur5", "-o", "arm.yaml")
    lines = Path("arm.yaml").read_text(encoding="utf-8").splitlines()
    given = [line.replace(".inf", line.rpartition(" ")[2]) if "10 Hz" in line else line for line in lines]
    text = "\n".join(given).replace("rotor_inertia: 0.0", "rotor_inertia: 1.0e-5")
    Path("arm.yaml").write_text(text, encoding="utf-8")
    joints = flexdyn("info", "arm.yaml", "--json").json["joints"]
    assert len(joints) == 6
    for joint in joints:
        assert joint["locked_rotor_frequency"] == pytest.approx(10.0, rel=0.03)


def test_the_urdf_is_named_relative_to_the_file(flexdyn: Runner, tmp_path: Path) -> None:
    """The folder can be moved as a whole, whatever letters its paths are made of."""
    folder = tmp_path / 'it\'s: a "lab" #1, é'
    (folder / "models").mkdir(parents=True)
    urdf = folder / "lift {1}.urdf"
    urdf.write_text(SLIDER, encoding="utf-8")
    assert flexdyn("new", urdf, "-o", folder / "models" / "lift.yaml").code == 0
    moved = folder.rename(tmp_path / "moved")
    model = fd.load_model(moved / "models" / "lift.yaml")
    plain = fd.FlexibleJointModel(fd.load_robot(moved / "lift {1}.urdf"), name="lift")
    assert model_to_dict(model) == model_to_dict(plain)
    text = (moved / "models" / "lift.yaml").read_text(encoding="utf-8")
    assert "  lift:  # prismatic, -100 to 100 m; M_ii = 2.5 kg at q = 0" in text
    assert "stiffness: .inf  # N/m;" in text


def test_an_existing_file_is_kept_unless_forced(flexdyn: Runner) -> None:
    """--force overwrites, nothing else does."""
    Path("arm.yaml").write_text("mine", encoding="utf-8")
    assert flexdyn("new", "double_pendulum", "-o", "arm.yaml").code == 2
    assert Path("arm.yaml").read_text(encoding="utf-8") == "mine"
    assert flexdyn("new", "double_pendulum", "-o", "arm.yaml", "--force").code == 0
    assert fd.load_model("arm.yaml").n == 2


@pytest.mark.parametrize("text", NASTY, ids=ascii)
def test_a_quoted_text_reads_back(text: str) -> None:
    """As key and as value, with a comment behind it, on one line."""
    assert "\n" not in quoted(text)
    assert parse_yaml(f"{quoted(text)}: {quoted(text)}  # comment") == {text: text}


def test_missing_meshes_are_one_warning(flexdyn: Runner) -> None:
    """Meshes that are not there do not stop the model; one line on stderr says so, without Python's own source line."""
    mesh = '<visual><geometry><mesh filename="package://nobody/a.stl"/></geometry></visual>'
    Path("arm.urdf").write_text(SLIDER.replace('name="mass">', f'name="mass">{mesh}'), encoding="utf-8")
    outcome = flexdyn("new", "arm.urdf", "-o", "arm.yaml")
    assert outcome.code == 0
    assert outcome.err.startswith("flexdyn: warning: ")
    assert outcome.err.count("\n") == 1
