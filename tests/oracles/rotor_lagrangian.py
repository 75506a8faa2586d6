"""Arms whose rotors ride on their parent links, from the kinetic energy alone: Lagrange with complex steps.

Nothing here comes from Pinocchio or flexdyn. With rotor i spinning at N_i omega_i about z_i on its parent link:

    T = 1/2 v'M v + sum 1/2 I_i [(N_i omega_i + z_i . w_parent)^2 - (z_i . w_parent)^2]

The rotor's mass, and its inertia when it does not spin, belong to the link that carries it: the URDF has them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
STEP = 1e-30


@dataclass(frozen=True)
class Link:
    """A link and the joint before it: axis and place in the parent's axes, mass, centre, principal inertias."""

    axis: tuple[float, float, float]
    origin: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]
    inertia: tuple[float, float, float]


@dataclass(frozen=True)
class RidingRotors:
    """A chain of revolute joints with a rotor for each joint that is not a mimic.

    Args:
        links: of the chain, from the base.
        ratio: N of every independent joint.
        rotor: J of every independent joint, reflected [kg m^2].
        stiffness: K of every independent joint [N m/rad]; infinite: rigid.
        mimic: (joint, leader, multiplier): q[joint] = multiplier q[leader], counted in the chain.
    """

    links: tuple[Link, ...]
    ratio: tuple[float, ...]
    rotor: tuple[float, ...]
    stiffness: tuple[float, ...]
    mimic: tuple[int, int, float] | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)

    @property
    def own(self) -> list[int]:
        """Place in the chain of every independent joint."""
        return [k for k in range(len(self.links)) if self.mimic is None or k != self.mimic[0]]

    @property
    def elastic(self) -> list[int]:
        """Independent joints with a spring."""
        return [i for i, stiffness in enumerate(self.stiffness) if math.isfinite(stiffness)]

    @property
    def gain(self) -> Array:
        """From independent joints to the chain."""
        gain = np.zeros((len(self.links), len(self.own)))
        gain[self.own, range(len(self.own))] = 1.0
        if self.mimic is not None:
            gain[self.mimic[0]] = self.mimic[2] * gain[self.mimic[1]]
        return gain

    def inertias_and_heights(self, q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """H of y = [q, theta of elastic joints], and the gravitational energy, of every row of q; it may be complex."""
        n, gain = len(self.own), self.gain
        chain = q @ gain.T
        rows, kind = len(chain), chain.dtype
        R, p = np.tile(np.eye(3, dtype=kind), (rows, 1, 1)), np.zeros((rows, 3), kind)
        turning, moving = np.zeros((rows, 3, n), kind), np.zeros((rows, 3, n), kind)  # of the parent's frame
        H = np.zeros((rows, n + len(self.elastic), n + len(self.elastic)), kind)
        potential = np.zeros(rows, kind)
        for k, link in enumerate(self.links):
            arm, axis = R @ np.array(link.origin), R @ np.array(link.axis)
            p, moving = p + arm, moving - cross(arm) @ turning
            if k in self.own:
                i = self.own.index(k)
                spin = np.zeros(H.shape[1])
                spin[n + self.elastic.index(i) if i in self.elastic else i] = self.ratio[i]
                riding = np.zeros((rows, H.shape[1]), kind)
                riding[:, :n] = (axis[:, None, :] @ turning)[:, 0]
                about, both = self.rotor[i] / self.ratio[i] ** 2, spin + riding
                H += about * (both[:, :, None] * both[:, None, :] - riding[:, :, None] * riding[:, None, :])
            turning = turning + axis[:, :, None] * gain[k]
            R = R @ rotation(np.array(link.axis), chain[:, k, None, None])
            centre = R @ np.array(link.centre)
            at = moving - cross(centre) @ turning
            about_axes = R.swapaxes(1, 2) @ turning
            H[:, :n, :n] += link.mass * at.swapaxes(1, 2) @ at
            H[:, :n, :n] += about_axes.swapaxes(1, 2) @ (np.array(link.inertia)[:, None] * about_axes)
            potential -= link.mass * ((p + centre) @ np.array(self.gravity))
        return H, potential

    def derivative(self, x: Array, tau: Sequence[float]) -> Array:
        """X' of x = [q, theta, v, omega], d/dt (dT/dy') - dT/dy + dV/dy = tau."""
        n, half = len(self.own), len(x) // 2
        q, rate = x[:n], x[half:]
        # One complex step along every angle, and one along the motion.
        H, V = self.inertias_and_heights(q + 1j * STEP * np.vstack([np.eye(n), rate[:n]]))
        slopes = H.imag / STEP
        force = np.zeros(half)
        force[:n] = 0.5 * (slopes[:n] @ rate) @ rate - V.imag[:n] / STEP
        force -= slopes[n] @ rate
        for i in range(n):
            if i in self.elastic:
                place = n + self.elastic.index(i)
                spring = self.stiffness[i] * (x[place] - q[i])
                force[i] += spring
                force[place] += tau[i] - spring
            else:
                force[i] += tau[i]
        return np.concatenate([rate, np.linalg.solve(H[n].real, force)])

    def energy(self, x: Array) -> float:
        """Kinetic, gravitational and spring energy [J]."""
        n, half = len(self.own), len(x) // 2
        (H,), (potential,) = self.inertias_and_heights(x[None, :n])
        stretched = [self.stiffness[i] * (x[n + slot] - x[i]) ** 2 for slot, i in enumerate(self.elastic)]
        return float(0.5 * x[half:] @ H @ x[half:] + potential + 0.5 * sum(stretched))

    def motion(self, x0: Array, tau: Sequence[float], times: Array) -> Array:
        """States at `times`, by DOP853 at tight tolerance."""
        found = solve_ivp(
            lambda _, x: self.derivative(x, tau),
            (times[0], times[-1]),
            x0,
            method="DOP853",
            t_eval=times,
            rtol=1e-11,
            atol=1e-12,
        )
        assert found.success, found.message
        return np.asarray(found.y.T)

    def write_urdf(self, path: Path) -> Path:
        """The same chain as a URDF; joints are j0, j1, ..."""
        parts = ['<robot name="riding"><link name="l0"/>']
        for k, link in enumerate(self.links):
            xx, yy, zz = link.inertia
            parts.append(
                f'<link name="l{k + 1}"><inertial><origin xyz="{triple(link.centre)}"/><mass value="{link.mass!r}"/>'
                f'<inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/></inertial></link>'
                f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/>'
                f'<origin xyz="{triple(link.origin)}"/><axis xyz="{triple(link.axis)}"/>'
            )
            if self.mimic is not None and k == self.mimic[0]:
                parts.append(f'<mimic joint="j{self.mimic[1]}" multiplier="{self.mimic[2]!r}"/>')
            parts.append("</joint>")
        path.write_text("".join([*parts, "</robot>"]), encoding="utf-8")
        return path


def triple(numbers: tuple[float, float, float]) -> str:
    """Three numbers as a URDF writes them, to the last digit."""
    return " ".join(map(repr, numbers))


def cross(a: NDArray[Any]) -> NDArray[Any]:
    """The matrices of a x, for every row of a."""
    found = np.zeros((*a.shape, 3), a.dtype)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., i, j], found[..., j, i] = -a[..., k], a[..., k]
    return found


def rotation(axis: Array, angle: Any) -> NDArray[Any]:
    """Rodrigues' formula; the angle may be complex."""
    K = cross(axis)
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)
