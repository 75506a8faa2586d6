"""What is no URDF, and arguments that cannot be meant: one clear line, whatever the file holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flexdyn.errors import InputError
from flexdyn.robot import load_robot

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
        stream.truncate(5_000_001)
    with pytest.raises(InputError, match="larger than 5 MB"):
        load_robot(huge)
    with pytest.raises(InputError, match="not a regular file"):
        load_robot("/dev/zero")
    # Python 3.14 takes so long a name for that of a missing file.
    with pytest.raises(InputError, match=r"cannot be read|no such file"):
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
    with pytest.raises(InputError, match=r"path of a URDF, the name of a robot or a pin\.Model"):
        load_robot(3)
    with pytest.raises(InputError, match="URDF text"):
        load_robot("<robot/>")
    with pytest.raises(InputError, match="package_dirs: no such folder"):
        load_robot(arm, package_dirs=[tmp_path / "none"])


@pytest.mark.parametrize("kept", [True, False])
def test_what_only_pinocchio_refuses_is_one_line_too(arm: Path, kept: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Should its reader ever refuse a file that passed every check, its last word or yourdfpy's is the line."""
    import yourdfpy

    def refuse(text: str) -> None:
        raise ValueError("In function f\nno valid URDF")

    monkeypatch.setattr(pin, "buildModelFromXML", refuse)
    if not kept:
        monkeypatch.setattr(yourdfpy.URDF, "validate", lambda self: self._errors.append("bad limb") or False)
    with pytest.raises(InputError, match="no valid URDF" if kept else "bad limb") as caught:
        load_robot(arm)
    assert "\n" not in str(caught.value)


ODD = [
    "",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "1e-320",
    "-1",
    "0",
    "0 0 0",
    "1e15 0 0",
    "base",
    "turn",
    "far",
    "x y",
    "&amp;",
]


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=st.lists(st.tuples(st.integers(0, 10**6), st.sampled_from(ODD)), min_size=1, max_size=3))
def test_any_attribute_may_hold_anything(changes: list[tuple[int, str]], zoo: Path, tmp_path: Path) -> None:
    """Odd values anywhere in a URDF give a robot of finite inertia or one clear line, never anything else."""
    pieces = zoo.read_text().split('"')
    for place, value in changes:
        pieces[1 + 2 * (place % (len(pieces) // 2))] = value
    path = tmp_path / "odd.urdf"
    path.write_text('"'.join(pieces))
    said = None
    try:
        robot = load_robot(path)
    except InputError as error:
        said = str(error)
    if said is None:
        model = robot.pin_model
        assert np.isfinite(pin.crba(model, model.createData(), robot.expand(np.zeros(robot.n)))).all()
    else:
        assert said.startswith(f"{path}: ")
        assert "\n" not in said
