"""Every mistake in a URDF: one line that names file, place and remedy, and nothing on stderr."""

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
        ["shoulder'/type", "did you mean 'revolute'"],
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
