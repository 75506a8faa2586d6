"""Every mistake in a URDF or an argument: one line that names file, place and remedy, and nothing on stderr."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from flexdyn.errors import InputError
from flexdyn.robot import load_robot

LINKS = '<link name="base"/><link name="upper"/><link name="fore"/>'
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def moving(extra: str = LIMIT, kind: str = "revolute", ends: tuple[str, str] = ("base", "upper")) -> str:
    """The joint 'shoulder'."""
    ties = f'<parent link="{ends[0]}"/><child link="{ends[1]}"/>'
    return f'<joint name="shoulder" type="{kind}">{ties}{extra}</joint>'


ELBOW = '<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>' + LIMIT + "</joint>"
MASS = '<link name="upper"><inertial><mass value="{}"/><inertia ixx="{}" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>{}</inertial></link>'  # noqa: E501


def with_upper(upper: str) -> str:
    """A robot whose link 'upper' is given."""
    return LINKS.replace('<link name="upper"/>', upper) + moving() + ELBOW


def mimic(*pairs: tuple[str, str]) -> str:
    """A robot of two joints, some of which mimic."""
    text = LINKS + moving() + ELBOW
    for follower, leader in pairs:
        at = text.index("</joint>", text.index(f'name="{follower}"'))
        text = text[:at] + f'<mimic joint="{leader}"/>' + text[at:]
    return text


FILES = {
    "no link": (f"{moving()}", ["no link"]),
    "nothing moves": ('<link name="base"/>', ["no joint that moves"]),
    "nothing but fixed": (
        '<link name="base"/><link name="upper"/>' + moving("", "fixed"),
        ["no joint that moves", "revolute"],
    ),
    "link twice": (LINKS + '<link name="fore"/>' + moving() + ELBOW, ["link 'fore'", "twice", "rename"]),
    "joint twice": (LINKS + moving() + ELBOW.replace('"elbow"', '"shoulder"'), ["joint 'shoulder'", "twice"]),
    "unnamed link": ('<link name=" "/>' + LINKS + moving() + ELBOW, ["link", "no name"]),
    "unnamed joint": (LINKS + moving().replace("shoulder", "") + ELBOW, ["joint", "no name"]),
    "joint without child": (
        LINKS + moving().replace('<child link="upper"/>', "") + ELBOW,
        ["joint 'shoulder'/child", "no child link"],
    ),
    "world": (
        LINKS + moving(ends=("world", "upper")) + ELBOW,
        ["joint 'shoulder'/parent", "'world'", 'add <link name="world"/>'],
    ),
    "misspelt link": (LINKS + moving(ends=("bsae", "upper")) + ELBOW, ["'bsae'", "did you mean 'base'"]),
    "two parents": (
        LINKS + moving() + ELBOW + moving(ends=("base", "fore")).replace("shoulder", "third"),
        ["link 'fore'", "two parents", "'elbow'", "'third'"],
    ),
    "two roots": (LINKS + moving(), ["2 root links", "'base', 'fore'", "fixed"]),
    "loop": (
        LINKS + moving(ends=("fore", "upper")) + ELBOW,
        ["loop", "upper -> fore -> upper", "cut"],
    ),
    "joined to itself": (LINKS + moving(ends=("upper", "upper")) + ELBOW, ["joint 'shoulder'", "to itself"]),
    "unknown kind": (
        LINKS + moving(kind="revolut") + ELBOW,
        ["shoulder'/type", "'revolut'", "did you mean 'revolute'"],
    ),
    "floating": (LINKS + moving(kind="floating") + ELBOW, ["shoulder", "floating", "fixed-base"]),
    "planar": (LINKS + moving(kind="planar") + ELBOW, ["shoulder", "planar", "fixed-base"]),
    "zero axis": (LINKS + moving('<axis xyz="0 0 0"/>' + LIMIT) + ELBOW, ["shoulder'/axis", "zero", "'0 0 0'"]),
    "commas": (LINKS + moving('<axis xyz="1,0,0"/>' + LIMIT) + ELBOW, ["shoulder'/axis", "'1,0,0'", '"0 0 1"']),
    "two of three": (LINKS + moving('<origin xyz="1 2"/>' + LIMIT) + ELBOW, ["shoulder'/origin/xyz", "3 numbers"]),
    "not a number": (LINKS + moving('<origin rpy="0 nan 0"/>' + LIMIT) + ELBOW, ["shoulder'/origin/rpy", "NaN"]),
    "infinite": (LINKS + moving('<origin xyz="0 1e400 0"/>' + LIMIT) + ELBOW, ["shoulder'/origin/xyz", "finite"]),
    "crossed limits": (
        LINKS + moving(LIMIT.replace('"-1"', '"2"')) + ELBOW,
        ["shoulder'/limit", "lower is above upper", "exchange"],
    ),
    "NaN limit": (LINKS + moving(LIMIT.replace('"-1"', '"nan"')) + ELBOW, ["shoulder'/limit/lower", "NaN"]),
    "negative velocity": (
        LINKS + moving(LIMIT.replace('velocity="1"', 'velocity="-1"')) + ELBOW,
        ["shoulder'/limit/velocity", "negative"],
    ),
    "negative damping": (
        LINKS + moving(LIMIT + '<dynamics damping="-0.1"/>') + ELBOW,
        ["shoulder'/dynamics/damping", "negative", "-0.1"],
    ),
    "negative friction": (
        LINKS + moving(LIMIT + '<dynamics friction="-2"/>') + ELBOW,
        ["shoulder'/dynamics/friction", "negative"],
    ),
    "negative mass": (with_upper(MASS.format(-1, 1, "")), ["link 'upper'/inertial/mass", "negative", "-1.0"]),
    "no mass": (
        with_upper('<link name="upper"><inertial/></link>'),
        ["link 'upper'/inertial", "<mass>"],
    ),
    "no inertia": (
        with_upper('<link name="upper"><inertial><mass value="1"/></inertial></link>'),
        ["link 'upper'/inertial", "<inertia>"],
    ),
    "negative moment": (with_upper(MASS.format(1, -0.5, "")), ["upper'/inertial/inertia", "-0.5", "semi-definite"]),
    "missing moment": (
        with_upper(MASS.format(1, 1, "").replace('ixy="0"', "")),
        ["upper'/inertial/inertia/ixy", "has no ixy"],
    ),
    "tiny body, negative moment": (
        with_upper(MASS.format(0, -1e-7, "").replace('iyy="1"', 'iyy="1e-7"').replace('izz="1"', 'izz="1e-7"')),
        ["joint 'shoulder'", "semi-definite"],
    ),
    "mimics itself": (mimic(("elbow", "elbow")), ["joint 'elbow'/mimic", "itself"]),
    "mimics nobody": (mimic(("elbow", "sholder")), ["elbow'/mimic", "'sholder'", "did you mean 'shoulder'"]),
    "mimic loop": (mimic(("elbow", "shoulder"), ("shoulder", "elbow")), ["mimics form a loop", "shoulder", "elbow"]),
    "mimic without leader": (mimic(("elbow", "")), ["elbow'/mimic", "names no joint"]),
    "named as the base": (LINKS + moving().replace("shoulder", "universe") + ELBOW, ["universe", "rename"]),
    "too many links": (
        "".join(f'<link name="l{k}"/>' for k in range(1001)),
        ["1001 links", "not a scene"],
    ),
    "visual": (
        with_upper('<link name="upper"><visual><geometry><box size="1 1"/></geometry></visual></link>'),
        ["link 'upper'/visual/box/size", "3 numbers"],
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_a_faulty_urdf_is_answered_by_one_line(
    case: str, write: Callable[..., Path], capfd: pytest.CaptureFixture[str]
) -> None:
    """File, place and remedy in one line; Pinocchio's reader, which prints, is never reached."""
    inside, words = FILES[case]
    path = write(inside)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    said = str(caught.value)
    assert said.count("\n") == 0
    assert said.startswith(f"{path}: ")
    assert caught.value.remedy
    assert [word for word in words if word not in said] == [], said
    assert capfd.readouterr() == ("", "")


def test_the_line_is_told(write: Callable[..., Path]) -> None:
    """Where the element stands in the file is in the text and in the data."""
    path = write("\n" + LINKS + "\n\n" + moving('\n<axis xyz="0 0 0"/>') + ELBOW)
    with pytest.raises(InputError, match=r"\(line 6\)") as caught:
        load_robot(path)
    assert caught.value.line == 6
    assert caught.value.file == path


BOMB = (
    "<!DOCTYPE robot ["
    + '<!ENTITY a "ha">'
    + "".join(f'<!ENTITY {chr(98 + k)} "{f"&{chr(97 + k)};" * 10}">' for k in range(12))
)
CONTENTS = {
    "empty": (b"", ["empty"]),
    "blank": (b" \n\t", ["empty"]),
    "binary": (b"\x7fELF\x00\x01\x02", ["binary"]),
    "utf-16": ("<robot/>".encode("utf-16"), ["UTF-16", "UTF-8"]),
    "latin": (b'<robot name="\xe9"/>', ["not UTF-8", "line 1"]),
    "yaml": (b"flexdyn: 1\n", ["not an XML file"]),
    "cut short": (b'<robot name="a">\n<link name="b">', ["not well-formed XML", "line 2"]),
    "two roots": (b"<robot/>\n<robot/>", ["not well-formed XML", "line 2"]),
    "undefined entity": (b'<robot name="a">&x;</robot>', ["not well-formed XML"]),
    "entity bomb": ((BOMB + "]><robot>&m;</robot>").encode(), ["DOCTYPE"]),
    "entity in an attribute": ((BOMB + ']><robot name="&m;"/>').encode(), ["DOCTYPE"]),
    "hidden doctype": (b'<?xml version="1.0"?><!-- a --> <!DOCTYPE robot SYSTEM "/etc/passwd"><robot/>', ["DOCTYPE"]),
    "sdf": (b"<sdf version='1.7'/>", ["SDF", "<robot"]),
    "mujoco": (b"<mujoco/>", ["MuJoCo"]),
    "other": (b"<html/>", ["<html>", "<robot"]),
    "xacro": (
        b'<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">\n<xacro:include filename="b"/></robot>',
        ["xacro", "line 2", "xacro arm.urdf >"],
    ),
    "xacro, undeclared": (b'<robot name="a"><xacro:property name="b" value="1"/></robot>', ["xacro"]),
    "xacro value": (b'<robot name="a"><link name="${prefix}base"/></robot>', ["xacro", "${prefix}base"]),
    "deep": (b"<robot>" + b"<a>" * 100_000, ["not well-formed XML"]),
}


@pytest.mark.parametrize("case", CONTENTS)
def test_what_is_no_urdf_is_answered_by_one_line(case: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Nothing is expanded, fetched or guessed."""
    content, words = CONTENTS[case]
    path = tmp_path / "arm.urdf"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_robot(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert len(said) < 600
    assert [word for word in words if word not in said] == [], said
    assert capfd.readouterr() == ("", "")


def test_folders_missing_and_huge_files(tmp_path: Path, arm: Path) -> None:
    """A folder names the URDF in it, a missing file the near miss, a huge file its bound."""
    with pytest.raises(InputError, match=r"a folder; give the URDF file in it: arm\.urdf"):
        load_robot(tmp_path)
    with pytest.raises(InputError, match=r"no such file; did you mean 'arm\.urdf'\?"):
        load_robot(tmp_path / "amr.urdf")
    huge = tmp_path / "huge.urdf"
    with huge.open("wb") as stream:
        stream.truncate(20_000_001)
    with pytest.raises(InputError, match="larger than 20 MB"):
        load_robot(huge)
    with pytest.raises(InputError, match="not a regular file"):
        load_robot("/dev/zero")
    with pytest.raises(InputError, match="cannot be read"):
        load_robot("/" + "x" * 5000 + ".urdf")


@pytest.mark.parametrize(
    ("lock", "words"),
    [
        ({"sholder": 0.0}, ["lock.sholder", "did you mean 'shoulder'"]),
        ({"mount": 0.0}, ["lock.mount", "fixed already"]),
        ({"elbow": float("nan")}, ["lock.elbow", "finite"]),
        ({"elbow": "0"}, ["lock.elbow", "'0'"]),
        ({"elbow": True}, ["lock.elbow", "True"]),
        ({"shoulder": 0.0, "elbow": 0.0}, ["no joint that moves", "lock fewer"]),
        (["elbow"], ["lock", "{joint7: 0.0}"]),
    ],
)
def test_a_wrong_lock_names_the_argument(arm: Path, lock: dict[str, float], words: list[str]) -> None:
    """The joint, what was given and what would be right; the URDF is not to blame."""
    with pytest.raises(InputError) as caught:
        load_robot(arm, lock=lock)
    said = str(caught.value)
    assert [word for word in words if word not in said] == [], said
    assert caught.value.file is None


def test_a_follower_cannot_be_locked_alone(zoo: Path) -> None:
    """Its leader can."""
    with pytest.raises(InputError, match=r"lock\.far.*lock its leader 'side'"):
        load_robot(zoo, lock={"far": 0.0})


def test_other_arguments(arm: Path, tmp_path: Path) -> None:
    """Neither a number nor text of a URDF nor a missing folder is taken for something else."""
    with pytest.raises(InputError, match="path of a URDF, the name of a robot or a pin.Model"):
        load_robot(3)
    with pytest.raises(InputError, match="URDF text"):
        load_robot("<robot/>")
    with pytest.raises(InputError, match="package_dirs: no such folder"):
        load_robot(arm, package_dirs=[tmp_path / "none"])


@pytest.mark.parametrize("kept", [True, False])
def test_what_only_pinocchio_refuses_is_one_line_too(arm: Path, kept: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Should its reader ever refuse a file that passed every check, its last word or yourdfpy's is the line."""
    import pinocchio
    import yourdfpy

    def refuse(text: str) -> None:
        raise ValueError("In function f\nno valid URDF")

    monkeypatch.setattr(pinocchio, "buildModelFromXML", refuse)
    if not kept:
        monkeypatch.setattr(yourdfpy.URDF, "validate", lambda self: self._errors.append("bad limb") or False)
    with pytest.raises(InputError, match="no valid URDF" if kept else "bad limb") as caught:
        load_robot(arm)
    assert "\n" not in str(caught.value)
