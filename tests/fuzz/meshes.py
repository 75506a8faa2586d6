"""Small valid meshes of the kinds that robots have, and what shows them: a URDF that names one, drawn as a page."""

from __future__ import annotations

import struct
import warnings
from functools import cache
from pathlib import Path

import numpy as np

import flexdyn as fd
from flexdyn.errors import InputError
from flexdyn.robot.meshes import MeshWarning

CORNERS = np.array([[x, y, z] for x in (0.0, 0.2) for y in (0.0, 0.1) for z in (0.0, 0.3)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6]])
URDF = """\
<robot name="arm"><link name="base"/>
<link name="upper"><inertial><mass value="2.0"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>
</inertial><visual><geometry><mesh filename="input{suffix}"/></geometry></visual></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="10" velocity="3"/></joint></robot>
"""
"""An arm whose link is drawn by a mesh beside it."""


def stl(folder: Path) -> list[bytes]:
    """An open box in bytes, and as text."""
    normal = np.zeros(3)
    rows = [struct.pack("<12fH", *normal, *CORNERS[face].ravel(), 0) for face in FACES]
    text = ["solid box"]
    for face in FACES:
        corners = "".join(f"   vertex {x} {y} {z}\n" for x, y, z in CORNERS[face])
        text.append(f" facet normal 0 0 0\n  outer loop\n{corners}  endloop\n endfacet")
    return [
        b"box".ljust(80) + struct.pack("<I", len(FACES)) + b"".join(rows),
        "\n".join([*text, "endsolid box\n"]).encode(),
    ]


def obj(folder: Path) -> list[bytes]:
    """An open box with its material in a file beside it, normals and a group; and one of four-cornered faces."""
    (folder / "box.mtl").write_text("newmtl grey\nKd 0.5 0.5 0.5\n")
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    faces = "".join(f"f {a}//1 {b}//1 {c}//1\n" for a, b, c in FACES + 1)
    first = f"mtllib box.mtl\no box\n{corners}vn 0 0 1\ng side\nusemtl grey\ns off\n{faces}"
    return [first.encode(), f"{corners}f 1 2 4 3\nf 5 7 8 6\nf -8 -4 -3 -7\nl 1 2\n".encode()]


def dae(folder: Path) -> list[bytes]:
    """An open box in centimetres with Z upwards, an effect, and a node that is turned."""
    places = " ".join(f"{100 * number:g}" for number in CORNERS.ravel())
    faces = " ".join(str(number) for number in FACES.ravel())
    return [DAE.format(places=places, faces=faces, count=len(FACES), numbers=CORNERS.size).encode()]


DAE = """\
<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="grey-effect"><profile_COMMON><technique sid="common"><phong>
<diffuse><color>0.5 0.5 0.5 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="grey"><instance_effect url="#grey-effect"/></material></library_materials>
<library_geometries><geometry id="box"><mesh>
<source id="places"><float_array id="numbers" count="{numbers}">{places}</float_array><technique_common>
<accessor source="#numbers" count="8" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="corners"><input semantic="POSITION" source="#places"/></vertices>
<triangles material="grey" count="{count}"><input semantic="VERTEX" source="#corners" offset="0"/>
<p>{faces}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="node"><rotate>0 0 1 90</rotate>
<instance_geometry url="#box"><bind_material><technique_common><instance_material symbol="grey" target="#grey"/>
</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>
"""


@cache
def _run(folder: Path, suffix: str) -> fd.Run:
    """A short motion of the arm."""
    (folder / "input.urdf").write_text(URDF.format(suffix=suffix))
    model = fd.FlexibleJointModel(fd.load_robot(folder / "input.urdf"))
    return fd.simulate(model, None, 0.01, rate=100.0)


def shown(folder: Path, data: bytes, *, suffix: str) -> None:
    """Draw the arm as a page; a mesh that is left out of it counts as refused."""
    (folder / f"input{suffix}").write_bytes(data)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fd.play(_run(folder, suffix), html=folder / "page.html").close()
    for each in told:
        if issubclass(each.category, MeshWarning):
            raise InputError(str(each.message))
        warnings.warn(each.message, stacklevel=1)
