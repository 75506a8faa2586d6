"""A link that is a point mass, as a payload often is: its moments about its centre are zero."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexdyn as fd

ARM = """<robot name="arm"><link name="base"/>
  <link name="bob"><inertial><origin xyz="0.1234567 0.3 -0.777" rpy="0.3 0 0"/><mass value="168.78"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="bob"/>
    <origin xyz="0 0 1" rpy="0.7 0 0"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.mark.parametrize("factor", [0.9, 0.97, 1.01, 1.03, 1.1])
def test_its_mass_and_place_can_be_scaled(tmp_path: Path, factor: float) -> None:
    """What rounding leaves of zero moments is no reason to refuse; M is that of the point."""
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")
    robot = fd.load_robot(tmp_path / "arm.urdf")
    scaled = robot.with_link_scaled("bob", mass=factor, com=factor).with_link_scaled("bob", mass=factor)
    M = fd.LinkSide(fd.FlexibleJointModel(scaled)).mass_matrix([0.3])[0, 0]
    assert pytest.approx(168.78 * factor**2 * factor**2 * (0.1234567**2 + 0.3**2)) == M
