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

    def inertia_and_height(self, q: NDArray[Any]) -> tuple[NDArray[Any], Any]:
        """H of y = [q, theta of elastic joints], and the gravitational energy; q may be complex."""
        n, gain = len(self.own), self.gain
        chain = gain @ q
        R, p = np.eye(3, dtype=chain.dtype), np.zeros(3, dtype=chain.dtype)
        turning, moving = np.zeros((3, n), chain.dtype), np.zeros((3, n), chain.dtype)  # of the parent's frame
        H = np.zeros((n + len(self.elastic),) * 2, chain.dtype)
        potential: Any = 0.0
        for k, link in enumerate(self.links):
            arm, axis = R @ np.array(link.origin), R @ np.array(link.axis)
            p, moving = p + arm, moving - cross(arm) @ turning
            if k in self.own:
                i = self.own.index(k)
                spin = np.zeros(len(H), chain.dtype)
                spin[n + self.elastic.index(i) if i in self.elastic else i] = self.ratio[i]
                riding = np.zeros(len(H), chain.dtype)
                riding[:n] = axis @ turning
                about = self.rotor[i] / self.ratio[i] ** 2
                H += about * (np.outer(spin + riding, spin + riding) - np.outer(riding, riding))
            turning = turning + np.outer(axis, gain[k])
            R = R @ rotation(np.array(link.axis), chain[k])
            centre = R @ np.array(link.centre)
            at = moving - cross(centre) @ turning
            H[:n, :n] += link.mass * at.T @ at + turning.T @ R @ np.diag(link.inertia) @ R.T @ turning
            potential = potential - link.mass * (np.array(self.gravity) @ (p + centre))
        return H, potential

    def derivative(self, x: Array, tau: Sequence[float]) -> Array:
        """X' of x = [q, theta, v, omega], d/dt (dT/dy') - dT/dy + dV/dy = tau."""
        n, half = len(self.own), len(x) // 2
        q, rate = x[:n], x[half:]
        H = self.inertia_and_height(q)[0]
        force = np.zeros(half)
        for k in range(n):
            Hk, Vk = self.inertia_and_height(q + 1j * STEP * np.eye(n)[k])
            force[k] += 0.5 * rate @ (Hk.imag / STEP) @ rate - Vk.imag / STEP
        force -= (self.inertia_and_height(q + 1j * STEP * rate[:n])[0].imag / STEP) @ rate
        for i in range(n):
            if i in self.elastic:
                place = n + self.elastic.index(i)
                spring = self.stiffness[i] * (x[place] - q[i])
                force[i] += spring
                force[place] += tau[i] - spring
            else:
                force[i] += tau[i]
        return np.concatenate([rate, np.linalg.solve(H, force)])

    def energy(self, x: Array) -> float:
        """Kinetic, gravitational and spring energy [J]."""
        n, half = len(self.own), len(x) // 2
        H, potential = self.inertia_and_height(x[:n])
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
    """The matrix of a x."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def rotation(axis: Array, angle: Any) -> NDArray[Any]:
    """Rodrigues' formula; the angle may be complex."""
    K = cross(axis)
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)
