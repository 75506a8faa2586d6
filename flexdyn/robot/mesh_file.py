"""Corners and triangles of a mesh file, read in another process: Assimp reads it, and may crash on a damaged one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from flexdyn.arrays import Array
from flexdyn.errors import InputError
from flexdyn.records.apart.caller import read_apart
from flexdyn.records.request import Request
from flexdyn.records.table import Table

MAX_COORDINATE = 1e6
"""Largest coordinate of a corner, once the mesh is scaled [m]."""


@dataclass(frozen=True)
class Mesh:
    """A surface.

    Attributes:
        corners: (count, 3), in the units of the file.
        triangles: (count, 3), each the numbers of its corners.
    """

    corners: Array
    triangles: NDArray[np.int64]

    def scaled(self, scale: tuple[float, ...]) -> Any:
        """The mesh as Pinocchio shows it.

        Args:
            scale: along x, y and z [m for a unit of the file].

        Raises:
            InputError: a corner is infinitely far, or farther than any robot reaches.
        """
        corners = self.corners * np.array(scale)
        if not (np.abs(corners) <= MAX_COORDINATE).all():  # NaN is not either
            problem = f"the mesh has a corner that is not finite, or farther than {MAX_COORDINATE:g} m"
            raise InputError(problem, remedy="the file is damaged, or its scale is wrong")
        shape = pin.coal.BVHModelOBBRSS()
        shape.beginModel(len(self.triangles), len(corners))
        shape.addVertices(corners)
        shape.addTriangles(self.triangles)
        shape.endModel()
        return shape


def read_mesh(path: Path) -> Mesh:
    """The mesh of a file.

    Args:
        path: of the file.

    Raises:
        InputError: it cannot be read, or takes too much time or memory.
    """
    table = read_apart(__name__, path, Request())
    try:
        corners, triangles = (np.stack([table.columns[name] for name in names], axis=1) for names in ("xyz", "abc"))
    except (KeyError, ValueError):
        raise InputError("the library that reads it gave no mesh", remedy="the file is damaged") from None
    triangles = triangles.astype(np.int64)
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < len(corners)):
        raise InputError("the mesh has a triangle of corners that it does not have", remedy="the file is damaged")
    return Mesh(corners.astype(float), triangles)


def library() -> Any:
    """What reads meshes."""
    return pin.coal


def read_here(path: Path, request: Request) -> Table:
    """The mesh as a table: corners in columns x, y, z, and triangles in columns a, b, c.

    Args:
        path: of the file.
        request: nothing of it applies.

    Raises:
        InputError: the library refuses the file.
    """
    try:
        shape = library().MeshLoader().load(str(path), np.ones(3))
    except (ValueError, RuntimeError):
        raise InputError("it is no mesh that can be read", remedy="the file is damaged, or of another kind") from None
    corners = np.array(shape.vertices(), dtype=float).reshape(-1, 3)
    triangles = (shape.tri_indices(k) for k in range(shape.num_tris))
    numbers = np.array([[each[0], each[1], each[2]] for each in triangles], dtype=np.int64).reshape(-1, 3)
    table = Table()
    for names, values in (("xyz", corners), ("abc", numbers)):
        for name, column in zip(names, values.T, strict=True):
            table.add(name, column)
    return table
