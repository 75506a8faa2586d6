"""Every mistake in a model file is one line that names file, key and remedy; never a traceback, whatever it holds."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import flexdyn as fd

VALID = """
flexdyn: 1
robot:
  urdf: scara_two_link
  package_dirs: []
  gravity: [0.0, 0.0, -9.81]
  lock: {}
  urdf_dynamics: use
  rotor_coupling: reduced
joints:
  "*": {gear_ratio: 100.0}
  shoulder: {rotor_inertia: 1.0e-4, stiffness: 4000.0, damping: 4.0}
initial: {q: {elbow: 1.5708}}
tolerance: 0.03
effects:
  - {effect: viscous_friction, joint: shoulder, side: motor, coefficient: 3.0}
  - {effect: torque_speed_limit, joint: elbow, stall_torque: 3.0, no_load_speed: 2.0}
  - {effect: payload, mass: 1.0, frame: tool}
"""


def line_for(file: Path) -> str:
    """The one line that loading the file answers with."""
    with pytest.raises(fd.InputError) as caught:
        fd.load_model(file)
    line = str(caught.value)
    assert line.startswith(f"{file}: ")
    assert line.isprintable()
    assert len(line) < 1000
    return line.removeprefix(f"{file}: ")


MISTAKES = [
    ("flexdyn: 1", "flexdyn: 2", "flexdyn: no such format, got 2; this version reads format 1"),
    ("flexdyn: 1", "flexdyn: true", "flexdyn: no such format, got True"),
    ("flexdyn: 1", "flexdyn: '1'", "flexdyn: no such format, got '1'"),
    ("flexdyn: 1", "", "flexdyn: the key is missing"),
    ("flexdyn: 1", "flexdyn: 1\nflexdyn: 1", "not valid YAML in line 3 (found duplicate key"),
    ("flexdyn: 1", "flexdyn: 1\njoint: {}", "joint: no such key; did you mean 'joints'?"),
    ("  urdf: scara_two_link\n", "", "robot.urdf: the key is missing"),
    ("urdf: scara_two_link", "urdf: scara_two_lnk", "robot.urdf: neither a file nor a known robot"),
    (
        "urdf: scara_two_link",
        "urdf: arm.urdf",
        "robot.urdf: there is no such file, got 'arm.urdf'; it is looked for in",
    ),
    ("urdf: scara_two_link", "urdf: 3", "robot.urdf: the path or name of a URDF is needed, got 3"),
    ("urdf: scara_two_link", "urdf: ''", "robot.urdf: the path or name of a URDF is needed"),
    ("urdf: scara_two_link", "urd: scara_two_link", "robot.urd: no such key; did you mean 'urdf'?"),
    ("package_dirs: []", "package_dirs: [nowhere]", "robot.package_dirs[0]: no such folder"),
    ("package_dirs: []", "package_dirs: here", "robot.package_dirs: a list of folders is needed, got 'here'"),
    ("-9.81]", "-9.81, 0.0]", "robot.gravity: three numbers are needed"),
    ("[0.0, 0.0, -9.81]", "9.81", "robot.gravity: three numbers are needed, got 9.81; write [0.0, 0.0, -9.81]"),
    ("-9.81]", "down]", "robot.gravity: three numbers are needed"),
    ("lock: {}", "lock: {elbw: 0.0}", "robot.lock.elbw: no such joint; did you mean 'elbow'?"),
    ("lock: {}", "lock: {elbow: .nan}", "robot.lock.elbow: not a finite number"),
    ("lock: {}", "lock: [elbow]", "robot.lock: a mapping JOINT: position is needed"),
    ("urdf_dynamics: use", "urdf_dynamics: usa", "robot.urdf_dynamics: no such choice, got 'usa'; it is use or ignore"),
    ("rotor_coupling: reduced", "rotor_coupling: half", "robot.rotor_coupling: no such choice, got 'half'"),
    ("  shoulder: {", "  sholder: {", "joints.sholder: the robot has no such joint; did you mean 'shoulder'?"),
    ("stiffness: 4000.0", "stifness: 4000.0", "joints.shoulder.stifness: a joint has no such key; did you mean 'stiff"),
    ("stiffness: 4000.0", "stiffness: -4000.0", "joints.shoulder.stiffness: it must be above 0, got -4000.0; use .inf"),
    ("stiffness: 4000.0", "stiffness: 0", "joints.shoulder.stiffness: it must be above 0"),
    ("stiffness: 4000.0", "stiffness: .nan", "joints.shoulder.stiffness: a number is needed, got nan"),
    ("stiffness: 4000.0", "stiffness: yes", "joints.shoulder.stiffness: a number is needed, got 'yes'"),
    ("stiffness: 4000.0", "stiffness: 4000 N m", "joints.shoulder.stiffness: a number is needed"),
    ("stiffness: 4000.0", "stiffness: null", "joints.shoulder.stiffness: a number is needed"),
    ("rotor_inertia: 1.0e-4, ", "", "joints.shoulder.rotor_inertia: an elastic joint needs it above 0; give the rotor"),
    (
        "rotor_inertia: 1.0e-4",
        "rotor_inertia: -1e-4",
        "joints.shoulder.rotor_inertia: it must be finite and at least 0",
    ),
    ("rotor_inertia: 1.0e-4", "rotor_inertia: .inf", "joints.shoulder.rotor_inertia: it must be finite"),
    ("damping: 4.0", "damping: -4", "joints.shoulder.damping: it must be finite and at least 0, got -4.0"),
    ("gear_ratio: 100.0", "gear_ratio: 0", "joints.*.gear_ratio: it must be finite and not 0"),
    ("initial: {q:", "initial: {p:", "initial.p: no such signal"),
    ("{elbow: 1.5708}", "{elbw: 1.5708}", "initial.q.elbw: the robot has no such joint; did you mean 'elbow'?"),
    ("{elbow: 1.5708}", "{elbow: bent}", "initial.q.elbow: a finite number is needed, got 'bent'"),
    ("{elbow: 1.5708}", "[1.0]", "initial.q: a mapping by joint is needed"),
    ("initial: {q: {elbow: 1.5708}}", "initial: []", "initial: a mapping is needed, got []"),
    ("tolerance: 0.03", "tolerance: -0.03", "tolerance: a number of at least 0 is needed, got -0.03; 0.05 means 5 %"),
    ("tolerance: 0.03", "tolerance: 3 %", "tolerance: a number of at least 0 is needed"),
    ("effect: payload", "effect: paylod", "effects[2].effect: no such effect, got 'paylod'; did you mean 'payload'?"),
    ("effect: payload, ", "", "effects[2].effect: its name is missing; write effect: NAME"),
    ("mass: 1.0", "mas: 1.0", "effects[2].mas: payload has no such parameter; did you mean 'mass'?"),
    ("mass: 1.0, ", "", "effects[2].mass: payload needs it; give it in kg"),
    ("mass: 1.0", "mass: -1.0", "effects[2].payload.mass: it must be at least 0 [kg], got -1.0"),
    ("frame: tool", "frame: tol", "effects[2].frame: no such frame, got 'tol'; did you mean 'tool'?"),
    ("frame: tool", "frame: []", "effects[2].frame: no such frame, got []"),
    (
        "side: motor",
        "side: rotor",
        "effects[0].viscous_friction.side: no such side for this effect, got 'rotor'; it is",
    ),
    (", side: motor", "", "effects[0].viscous_friction.side: the side must be said; it is link or motor"),
    ("joint: shoulder, side", "joint: shouldr, side", "effects[0].joint: no such joint, got 'shouldr'; did you mean"),
    ("effects:\n", "effects:\n  - 3\n", "effects[0]: an effect is a mapping, got 3; write {effect: NAME, joint"),
    (
        "effects:\n",
        "effects:\n  - {effect: transmission_damping, joint: elbow, coefficient: 1}\n",
        "effects[0].joint: transmission_damping needs an elastic joint, got 'elbow'; give joints.elbow a finite stiff",
    ),
    ("flexdyn: 1", "flexdyn: [1", "not valid YAML in line"),
    ("flexdyn: 1", "flexdyn: *one", "not valid YAML in line 2 (found undefined alias 'one')"),
    ("flexdyn: 1", "flexdyn: !!python/object:os.system 1", "not valid YAML in line 2 (could not determine a constr"),
    ("flexdyn: 1", "flexdyn: !!int ''", "not valid YAML (IndexError)"),
    ("flexdyn: 1", "flexdyn: !!bool x", "not valid YAML (KeyError)"),
    ("flexdyn: 1", "flexdyn: \x07", "not valid YAML (unacceptable character"),
    ("flexdyn: 1", "flexdyn: " + "[" * 1500, "lists and mappings nest deeper than 32"),
    ("flexdyn: 1", "flexdyn: " + "9" * 5000, "not valid YAML"),
    ("flexdyn: 1", "flexdyn: 0x" + "9" * 5000, "flexdyn: no such format"),
    ("flexdyn: 1", "flexdyn: 1\n--- 2", "not valid YAML in line"),
    ("flexdyn: 1", "flexdyn: 1\n? [a, b]\n: 2", "('a', 'b'): no such key"),
    ("flexdyn: 1", "flexdyn: 1\n" + "k" * 900 + ": 2", "kkkk"),
]


@pytest.mark.parametrize(("right", "wrong", "words"), MISTAKES, ids=[words[:40] for *_, words in MISTAKES])
def test_a_mistake_is_one_line(tmp_path: Path, right: str, wrong: str, words: str) -> None:
    """With the place, the value and what would be right."""
    assert VALID.count(right) == 1
    file = tmp_path / "model.yaml"
    file.write_text(VALID.replace(right, wrong), encoding="utf-8")
    assert line_for(file).startswith(words)


@pytest.mark.parametrize("key", ["robot", "joints", "effects", "initial"])
@pytest.mark.parametrize("value", ["3", "text", "[1, 2]", "{a: b}", "true", "0", "''", "false", "[]"])
def test_a_wrong_type_is_refused_also_where_it_is_empty(tmp_path: Path, key: str, value: str) -> None:
    """A list for a mapping, a mapping for a list, zero or nothing in quotes: each says what is needed."""
    if (key, value) == ("effects", "[]"):
        return
    file = tmp_path / "model.yaml"
    content = {"flexdyn": "1", "robot": "{urdf: scara_two_link}"} | {key: value}
    file.write_text("".join(f"{name}: {text}\n" for name, text in content.items()))
    assert line_for(file).startswith(key)


def test_the_valid_file_is_valid(tmp_path: Path) -> None:
    """So that every mistake above is the one that it says."""
    (tmp_path / "model.yaml").write_text(VALID)
    assert len(fd.load_model(tmp_path / "model.yaml").effects) == 3


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        (b"", "a mapping of keys is needed"),
        (b"- 1\n", "a mapping of keys is needed, got [1]"),
        (b"flexdyn: \xff\xfe", "it is not a text file in UTF-8"),
        (b"\x00\x01\x02" * 100, "not valid YAML"),
        (b"#" * 500_001, "the file is larger than 500000 bytes"),
        (b"a: " + b"[" * 33 + b"]" * 33, "lists and mappings nest deeper than 32"),
        (b"a: " + b"[" * 50_000, "lists and mappings nest deeper than 32"),
    ],
)
def test_a_file_that_is_no_model(tmp_path: Path, raw: bytes, words: str) -> None:
    """Empty, a list, binary, or too large to be read at all."""
    (tmp_path / "model.yaml").write_bytes(raw)
    assert line_for(tmp_path / "model.yaml").startswith(words)


@pytest.mark.parametrize("kind", ["value", "key", "merge", "loop"])
def test_alias_bombs_are_defused(tmp_path: Path, kind: str) -> None:
    """A few lines that would unfold to billions of entries are refused before they do."""
    lines = ["a0: &a0 {x: 1}" if kind == "merge" else "a0: &a0 [x, x]"]
    for k in range(1, 40):
        last = f"*a{k - 1}"
        lines.append(f"a{k}: &a{k} {{<<: [{last}, {last}]}}" if kind == "merge" else f"a{k}: &a{k} [{last}, {last}]")
    if kind == "key":
        lines.append("? *a39\n: 1")
    if kind == "loop":
        lines = ["flexdyn: 1", "robot: &r {urdf: *r}"]
    (tmp_path / "model.yaml").write_text("\n".join(lines))
    assert line_for(tmp_path / "model.yaml") == "its aliases unfold to more than 100000 entries"


@pytest.mark.parametrize("path", ["nowhere.yaml", "no/where", "scara_two_lnk", "x" * 5000, "", "a\0b", "."])
def test_a_file_that_is_not_there(path: str) -> None:
    """A path or a name: what was meant is guessed from its looks."""
    with pytest.raises(fd.InputError) as caught:
        fd.load_model(path)
    assert str(caught.value).isprintable()
    if path == "scara_two_lnk":
        assert "did you mean 'scara_two_link'?" in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """A folder and a pipe are no model files, and do not make flexdyn wait."""
    with pytest.raises(fd.InputError, match=r"it is not a file; give the path of a model\.yaml"):
        fd.load_model(tmp_path)
    os.mkfifo(tmp_path / "model.yaml")
    with pytest.raises(fd.InputError, match="it is not a file"):
        fd.load_model(tmp_path / "model.yaml")


def test_a_broken_urdf_is_named_as_the_file(tmp_path: Path) -> None:
    """The line names the URDF, where the mistake is, and not the model file."""
    (tmp_path / "arm.urdf").write_text("<robot name='x'><link name='a'/>")
    (tmp_path / "model.yaml").write_text("flexdyn: 1\nrobot: {urdf: arm.urdf}\n")
    with pytest.raises(fd.InputError) as caught:
        fd.load_model(tmp_path / "model.yaml")
    assert str(caught.value).startswith(f"{tmp_path / 'arm.urdf'}: ")
