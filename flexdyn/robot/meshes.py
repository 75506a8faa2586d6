"""The files of a URDF's meshes: package:// addresses are looked up on disk; and all shapes as a pin.GeometryModel."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pinocchio as pin

from flexdyn.errors import InputError
from flexdyn.robot.joints import RobotJoint
from flexdyn.robot.links import Link, Visual
from flexdyn.robot.mesh_file import Mesh, read_mesh
from flexdyn.robot.names import example_data_dir
from flexdyn.robot.text import urdf_text

MESH_SUFFIXES = frozenset({".stl", ".dae", ".obj", ".ply", ".off", ".3ds", ".glb", ".gltf", ".fbx", ".x"})
MAX_MESH_BYTES = 100_000_000
"""Largest mesh file that is opened [bytes]; published robots have up to 29 MB."""
MAX_MESHES_BYTES = 1_000_000_000
"""Largest size of all mesh files of a robot [bytes]."""
_SHAPES = ("box", "cylinder", "sphere")


class MeshWarning(UserWarning):
    """Meshes of a robot were not found, or could not be read; they are left out of the picture."""


def resolve_meshes(links: Sequence[Link], urdf: Path, package_dirs: Sequence[Path]) -> tuple[Link, ...]:
    """The links with every mesh address replaced by a path on disk; shapes that cannot be shown are left out.

    One MeshWarning gives their number.

    Args:
        links: the links as read.
        urdf: the URDF file; relative addresses start at its folder.
        package_dirs: folders that hold packages, or are packages.

    Returns:
        The same links with shapes that can be drawn.
    """
    roots = list(_package_roots(urdf, package_dirs))
    found: dict[str, Path | None] = {}
    missing: list[str] = []
    shown = []
    for link in links:
        kept = []
        for visual in link.visuals:
            if visual.shape in _SHAPES:
                kept.append(visual)
                continue
            if visual.shape == "mesh" and visual.mesh not in found:
                found[visual.mesh] = find_mesh(visual.mesh, urdf, roots)
            path = found.get(visual.mesh)
            if path is None:
                missing.append(visual.mesh or f"<{visual.shape}> of link '{link.name}'")
            else:
                kept.append(replace(visual, mesh=str(path)))
        shown.append(replace(link, visuals=tuple(kept)))
    if missing:
        total = sum(len(link.visuals) for link in links)
        text = f"{urdf}: {len(missing)} of {total} shapes are left out of the picture, their mesh was not found"
        remedy = f"the first is {missing[0]!r}; name the folder of its package in package_dirs"
        warnings.warn(f"{text}; {remedy}", MeshWarning, stacklevel=3)
    return tuple(shown)


def mesh_path(address: str, urdf: Path, package_dirs: Sequence[Path]) -> Path | None:
    """The file that a mesh address in a URDF means; None where it is not found.

    Args:
        address: as the URDF writes it.
        urdf: the URDF file.
        package_dirs: folders that hold packages, or are packages.
    """
    return find_mesh(address, urdf, _package_roots(urdf, package_dirs))


def find_mesh(address: str, urdf: Path, roots: Iterable[tuple[Path, bool]]) -> Path | None:
    """The file that a mesh address means.

    ``package://name/rest`` stays inside the folder of that package; other addresses are paths, relative to the URDF's
    folder. Nothing is loaded from a network.

    Args:
        address: as the URDF writes it.
        urdf: the URDF file.
        roots: folders to search, each with a flag: whether it may be the package itself under any name.

    Returns:
        The path of an existing mesh file, or None.
    """
    scheme, separator, rest = address.partition("://")
    if not separator:
        return _existing(urdf.parent / address)
    if scheme == "file":
        return _existing(Path(unquote(rest)))
    if scheme not in ("package", "model"):
        return None
    # Some published files write package:///name.
    package, _, inside = rest.lstrip("/").partition("/")
    if package in ("", ".", "..") or not inside:
        return None
    for root, is_package in roots:
        folders = [root / package]
        if is_package or root.name == package:
            folders.append(root)
        for folder in folders:
            path = Path(os.path.normpath(folder / inside))
            # By name, not by link target: in workspaces the files of a package are links to its sources.
            if path.is_relative_to(folder) and (mesh := _existing(path)):
                return mesh
    return None


def _package_roots(urdf: Path, package_dirs: Sequence[Path]) -> Iterable[tuple[Path, bool]]:
    """Folders where packages may be, the most likely first, and whether the user named them."""
    for folder in package_dirs:
        yield Path(os.path.normpath(folder)), True
    for folder in urdf.parents:
        yield folder, False
    for variable, below in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")):
        for entry in os.environ.get(variable, "").split(os.pathsep):
            if entry:
                yield Path(os.path.normpath(Path(entry).absolute() / below)), False
    data = example_data_dir()
    if data is not None:
        yield data.parent, False


def _existing(path: Path) -> Path | None:
    try:
        good = path.suffix.lower() in MESH_SUFFIXES and path.is_file()
    except OSError:
        return None
    return path if good else None


def visual_model(model: pin.Model, links: Sequence[Link], joints: Sequence[RobotJoint]) -> pin.GeometryModel:
    """Build the visual geometry on a normalised model.

    Args:
        model: the model, joints locked or not; a link is found by its frame.
        links: links whose meshes are paths on disk.
        joints: the joints between them.

    Returns:
        The geometry; meshes that cannot be read, or are too large, are left out with one MeshWarning for each kind.
    """
    links, large = _bounded(links)
    if large:
        limits = f"{MAX_MESH_BYTES} bytes, or {MAX_MESHES_BYTES} bytes in all"
        text = f"{len(large)} meshes are larger than {limits}, and are left out of the picture; the first is"
        warnings.warn(f"{text} {large[0]!r}; reduce its triangles", MeshWarning, stacklevel=3)
    if not links:
        return pin.GeometryModel()
    links, shapes, unread = _read(links)
    if unread:
        text = f"{len(unread)} meshes cannot be read and are left out of the picture; the first is {unread[0]}"
        warnings.warn(text, MeshWarning, stacklevel=3)
    # Pinocchio's reader would read the meshes in this process, so it gets a box in the place of each.
    boxed = [replace(link, visuals=tuple(_boxed(visual) for visual in link.visuals)) for link in links]
    geometry = pin.buildGeomFromUrdfString(model, urdf_text(boxed, joints), pin.GeometryType.VISUAL)
    for name, (visual, shape) in shapes.items():
        entry = geometry.geometryObjects[geometry.getGeometryId(name)]
        entry.geometry, entry.meshPath, entry.meshScale = shape, visual.mesh, np.array(visual.size)
    return geometry


def _boxed(visual: Visual) -> Visual:
    return replace(visual, shape="box", size=(1.0, 1.0, 1.0), mesh="") if visual.mesh else visual


def _bounded(links: Sequence[Link]) -> tuple[list[Link], list[str]]:
    """Links without the meshes that are too large, and those meshes."""
    kept, large, left = [], [], MAX_MESHES_BYTES
    for link in links:
        good = []
        for visual in link.visuals:
            size = _file_size(visual.mesh) if visual.mesh else 0
            if size > min(MAX_MESH_BYTES, left):
                large.append(visual.mesh)
                continue
            left -= size
            good.append(visual)
        kept.append(replace(link, visuals=tuple(good)))
    return kept, large


def _file_size(mesh: str) -> int:
    """Bytes of a mesh file; none of one that is gone, which then cannot be read."""
    try:
        return Path(mesh).stat().st_size
    except OSError:
        return 0


def _read(links: Sequence[Link]) -> tuple[list[Link], dict[str, tuple[Visual, Any]], list[str]]:
    """Links with the shapes that can be read; their meshes by Pinocchio's name of the shape; what the others said."""
    known: dict[str, Mesh | InputError] = {}
    kept, shapes, unread = [], {}, []
    for link in links:
        good: list[Visual] = []
        for visual in link.visuals:
            if visual.mesh:
                try:
                    shape = _mesh(visual.mesh, known).scaled(visual.size)
                except InputError as error:
                    unread.append(f"{visual.mesh!r}: {error.problem}")
                    continue
                shapes[f"{link.name}_{len(good)}"] = (visual, shape)
            good.append(visual)
        kept.append(replace(link, visuals=tuple(good)))
    return kept, shapes, unread


def _mesh(path: str, known: dict[str, Mesh | InputError]) -> Mesh:
    """The mesh of a file, which is read once."""
    if path not in known:
        try:
            known[path] = read_mesh(Path(path))
        except InputError as error:
            known[path] = error
        except OSError as error:
            known[path] = InputError(error.strerror or "it cannot be opened")
    found = known[path]
    if isinstance(found, InputError):
        raise found
    return found
