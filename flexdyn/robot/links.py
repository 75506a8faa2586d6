"""A link of a URDF file: its inertia, checked, and its shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from flexdyn.robot.shapes import Visual, read_visuals
from flexdyn.robot.values import fail, name_of, number, pose_of


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
    line: int | None


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
    inertial = element.find("inertial")
    return Link(
        name,
        None if inertial is None else _inertial(inertial, f"link '{name}'/inertial"),
        read_visuals(element, f"link '{name}'/visual", colors),
        element.sourceline,
    )


def _inertial(element: Any, key: str) -> Inertial:
    mass_element, inertia = element.find("mass"), element.find("inertia")
    if mass_element is None:
        raise fail(element, key, "has no <mass>", remedy='add <mass value="..."/> in kg')
    if inertia is None:
        raise fail(element, key, "has no <inertia>", remedy="add <inertia ixx= ixy= ixz= iyy= iyz= izz=/> in kg m^2")
    mass = number(mass_element, "value", f"{key}/mass")
    if mass < 0.0:
        raise fail(mass_element, f"{key}/mass", "negative mass", mass, "give the mass in kg, 0 or more")
    xx, xy, xz, yy, yz, zz = (
        number(inertia, name, f"{key}/inertia/{name}") for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    principal = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    # Published robots have tiny links whose rounded moments are negative by less than this.
    if principal[0] < -1e-6 * max(1.0, abs(principal[2])):
        remedy = "no body has a negative moment of inertia; check signs and units"
        raise fail(inertia, f"{key}/inertia", "not positive semi-definite", listed_moments(principal), remedy)
    xyz, rpy = pose_of(element, key)
    return Inertial(mass, xyz, rpy, (xx, xy, xz, yy, yz, zz))


def listed_moments(principal: np.ndarray) -> str:
    """Principal moments [kg m^2] for a message."""
    return f"principal moments {', '.join(f'{value:.4g}' for value in principal)} kg m^2"


def spatial_inertia(body: Inertial) -> pin.Inertia:
    """Mass, centre of mass and inertia in the axes of the link's frame."""
    xx, xy, xz, yy, yz, zz = body.moments
    rotation = pin.rpy.rpyToMatrix(np.array(body.rpy))
    moments = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T
    return pin.Inertia(body.mass, np.array(body.xyz), moments)
