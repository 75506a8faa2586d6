"""A link of a URDF file: its inertia, checked, and its shapes: boxes, cylinders, spheres and meshes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.robot.values import attribute_number, fail, name_of, numbers, pose_of

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
SHAPE_GREY = (0.7, 0.7, 0.7, 1.0)
SIZES = {
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
    "mesh": (("scale", 3),),
}
"""The attributes with the size of each shape, and how many numbers they have."""


@dataclass(frozen=True)
class Visual:
    """One shape on a link.

    Attributes:
        shape: "box", "cylinder", "sphere", "mesh", or another name from the file.
        size: box edges, or radius and length, or radius [m]; the scale of a mesh [1].
        mesh: the address of the mesh as the file writes it, else empty.
        xyz: position in the link frame [m].
        rpy: roll, pitch, yaw in the link frame [rad].
        color: red, green, blue, opacity in 0..1.
    """

    shape: str
    size: tuple[float, ...]
    mesh: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    color: tuple[float, ...]


def read_colors(root: Any) -> dict[str, tuple[float, ...]]:
    """Colours by material name, from anywhere in the file (a visual may use a material that another one defines)."""
    colors: dict[str, tuple[float, ...]] = {}
    for material in root.iter("material"):
        color = material.find("color")
        if color is not None and material.get("name"):
            colors.setdefault(material.get("name"), _rgba(color))
    return colors


def read_visuals(link: Any, key: str, colors: dict[str, tuple[float, ...]]) -> tuple[Visual, ...]:
    """The shapes of a link element.

    Args:
        link: the element ``<link>``.
        key: its path in the file, for errors.
        colors: colours by material name.

    Returns:
        One Visual for each ``<visual>`` with a geometry.

    Raises:
        InputError: a pose or size that is not made of numbers.
    """
    found = []
    for element in link.findall("visual"):
        shape = element.find("geometry/*")
        if shape is None:
            continue
        xyz, rpy = pose_of(element, key)
        mesh = str(shape.get("filename") or "").strip() if shape.tag == "mesh" else ""
        found.append(Visual(str(shape.tag), _shape_size(shape, key), mesh, xyz, rpy, _color(element, colors)))
    return tuple(found)


def _shape_size(shape: Any, key: str) -> tuple[float, ...]:
    default = (1.0, 1.0, 1.0) if shape.tag == "mesh" else None
    given = SIZES.get(shape.tag, ())
    read = (numbers(shape, name, f"{key}/{shape.tag}/{name}", count, default) for name, count in given)
    return tuple(value for values in read for value in values)


def _color(visual: Any, colors: dict[str, tuple[float, ...]]) -> tuple[float, ...]:
    own = visual.find("material/color")
    if own is not None:
        return _rgba(own)
    material = visual.find("material")
    return SHAPE_GREY if material is None else colors.get(material.get("name") or "", SHAPE_GREY)


def _rgba(color: Any) -> tuple[float, ...]:
    return tuple(min(max(value, 0.0), 1.0) for value in numbers(color, "rgba", "material/color/rgba", 4, SHAPE_GREY))


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], pose of the inertia frame [m, rad] and ixx, ixy, ixz, iyy, iyz, izz [kg m^2] in it."""

    mass: float
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    moments: tuple[float, ...]

    def scaled(self, mass: float, com: float, inertia: float) -> Inertial:
        """A copy with mass, position of the centre of mass and moments multiplied by factors."""
        xyz, moments = tuple(com * value for value in self.xyz), tuple(inertia * value for value in self.moments)
        return Inertial(mass * self.mass, xyz, self.rpy, moments)

    def round(self, moment: float) -> Inertial:
        """A copy with the same moment of inertia about every axis through the centre of mass [kg m^2]."""
        return Inertial(self.mass, self.xyz, self.rpy, (moment, 0.0, 0.0, moment, 0.0, moment))


@dataclass(frozen=True)
class Link:
    """A rigid body: its name, its inertia if it has one, and its shapes."""

    name: str
    inertial: Inertial | None
    visuals: tuple[Visual, ...]
    sourceline: int | None


def read_link(element: Any, colors: dict[str, tuple[float, ...]]) -> Link:
    """Read and check a ``<link>``.

    Args:
        element: the XML element.
        colors: colours by material name.

    Returns:
        The link.

    Raises:
        InputError: no name, an ``<inertial>`` without mass or inertia, or impossible numbers.
    """
    name = name_of(element, "link")
    key, inertial = f"link '{name}'", element.find("inertial")
    body = None if inertial is None else _inertial(inertial, f"{key}/inertial")
    return Link(name, body, read_visuals(element, f"{key}/visual", colors), element.sourceline)


def _inertial(element: Any, key: str) -> Inertial:
    """Mass, centre of mass and inertia of a link; refuses what no body can have."""
    mass_element, inertia = element.find("mass"), element.find("inertia")
    if mass_element is None:
        raise fail(element, key, "has no <mass>", remedy='add <mass value="..."/> in kg')
    if inertia is None:
        raise fail(element, key, "has no <inertia>", remedy="add <inertia ixx= ixy= ixz= iyy= iyz= izz=/> in kg m^2")
    mass = attribute_number(mass_element, "value", f"{key}/mass")
    if mass < 0.0:
        raise fail(mass_element, f"{key}/mass", "negative mass", mass, "give the mass in kg, 0 or more")
    moments = tuple(attribute_number(inertia, name, f"{key}/inertia/{name}") for name in MOMENTS)
    principal = np.linalg.eigvalsh(_symmetric(moments))
    # Published robots have tiny links whose rounded moments are negative by less than this.
    if principal[0] < -1e-6 * max(1.0, abs(principal[2])):
        remedy = "no body has a negative moment of inertia; check signs and units"
        raise fail(inertia, f"{key}/inertia", "not positive semi-definite", listed_moments(principal), remedy)
    xyz, rpy = pose_of(element, key)
    return Inertial(mass, xyz, rpy, moments)


def _symmetric(moments: tuple[float, ...]) -> np.ndarray:
    """The symmetric matrix of six moments in the order of `MOMENTS`."""
    xx, xy, xz, yy, yz, zz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def listed_moments(principal: np.ndarray) -> str:
    """Principal moments [kg m^2] for a message."""
    return f"principal moments {', '.join(f'{value:.4g}' for value in principal)} kg m^2"


def spatial_inertia(body: Inertial) -> pin.Inertia:
    """Mass, centre of mass and inertia in the axes of the link's frame."""
    rotation = pin.rpy.rpyToMatrix(np.array(body.rpy))
    moments = rotation @ _symmetric(body.moments) @ rotation.T
    return pin.Inertia(body.mass, np.array(body.xyz), moments)
