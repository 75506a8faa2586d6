"""The shapes of a link: boxes, cylinders, spheres and meshes with a pose and a colour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flexdyn.robot.values import numbers, pose_of

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
        found.append(Visual(str(shape.tag), _size(shape, key), mesh, xyz, rpy, _color(element, colors)))
    return tuple(found)


def _size(shape: Any, key: str) -> tuple[float, ...]:
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
