"""Which numbers of a model file may be wrong."""

from __future__ import annotations

from pathlib import Path

import flexdyn as fd
from flexdyn.model.uncertain_parameters import file_numbers

LINK = """
<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="2"/>
  <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>
"""
JOINT = """
<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0.3 0 0"/>
  <axis xyz="0 0 1"/><limit effort="1" velocity="1" lower="-1" upper="1"/></joint>
"""


def test_numbers_that_do_nothing_are_none(tmp_path: Path) -> None:
    """A point mass at the origin of its link has neither a centre of mass to be moved nor an inertia."""
    links = LINK.format(name="arm", x=0.2, i=0.01) + LINK.format(name="tool", x=0.0, i=0.0)
    joints = JOINT.format(name="shoulder", kind="revolute", parent="base", child="arm")
    joints += JOINT.format(name="flange", kind="fixed", parent="arm", child="tool")
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm"><link name="base"/>{links}{joints}</robot>')
    model = fd.FlexibleJointModel(fd.load_robot(tmp_path / "arm.urdf"))
    of_links = {(number.of, number.parameter) for number in file_numbers(model) if number.joint is None}
    assert of_links == {("arm", "link_mass"), ("arm", "link_com"), ("arm", "link_inertia"), ("tool", "link_mass")}
