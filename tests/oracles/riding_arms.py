"""Arms of the rotor-coupling tests, as oracle and as flexdyn's model, and the planar two-link arm by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from tests.arms import two_link
from tests.oracles.rotor_lagrangian import Link, RidingRotors
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
SKEW = (
    Link((0.0, 0.0, 1.0), (0.0, 0.0, 0.2), 2.0, (0.1, 0.02, 0.1), (0.05, 0.06, 0.03)),
    Link((0.0, 0.6, 0.8), (0.3, 0.0, 0.1), 1.2, (0.2, 0.03, -0.02), (0.02, 0.05, 0.04)),
    Link((1.0, 0.0, 0.0), (0.35, 0.05, 0.0), 0.7, (0.05, 0.1, 0.12), (0.01, 0.02, 0.015)),
)
"""Three links whose axes neither meet nor are parallel: S depends on q, and rotors have gyroscopic torques."""


def riding_model(arm: RidingRotors, folder: Path, coupling: str = "full") -> fd.FlexibleJointModel:
    """Flexdyn's model of the oracle's arm, from its URDF."""
    joints = {
        f"j{k}": {"gear_ratio": N, "rotor_inertia": J / N**2, "stiffness": K}
        for k, N, J, K in zip(arm.own, arm.ratio, arm.rotor, arm.stiffness, strict=True)
    }
    robot = fd.load_robot(arm.write_urdf(folder / "riding.urdf"))
    return fd.FlexibleJointModel(robot, joints, gravity=arm.gravity, rotor_coupling=coupling)


def skew(stiffness: tuple[float, float, float] = (60.0, 40.0, 30.0)) -> RidingRotors:
    """The three skew links with low gears, so that coupling is large."""
    return RidingRotors(SKEW, (4.0, 3.0, 5.0), (0.2, 0.1, 0.05), stiffness)


def too_light() -> RidingRotors:
    """Links of 0.001 kg m^2 under a rotor of 0.5 kg m^2 without a gear: no arm could be built like this."""
    small = (1e-3, 1e-3, 1e-3)
    axes, places = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), (0.2, 0.1, 0.0)
    links = (Link(axis, (0.0, 0.0, z), 0.01, (0.0,) * 3, small) for axis, z in zip(axes, places, strict=True))
    return RidingRotors(tuple(links), (1.0,) * 3, (0.01, 0.01, 0.5), (60.0, 40.0, 30.0))


@dataclass(frozen=True)
class Planar:
    """The two-link arm with rotor 2 riding on link 1, by hand, both joints elastic.

    L = 1/2 (d11 - i2) v1^2 + d12 v1 v2 + 1/2 d22 v2^2 + 1/2 i1 (N1 omega1)^2 + 1/2 i2 (N2 omega2 + v1)^2 - V: d11
    of the closed form carries rotor 2 as inertia that does not spin, i2 = J2/N2^2. Lagrange's equations then are

        d11 a1 + d12 a2 + N2 i2 alpha2 + h1 = tau_s1,   d12 a1 + d22 a2 + h2 = tau_s2
        J1 alpha1 = tau1 - tau_s1,                      N2 i2 a1 + J2 alpha2 = tau2 - tau_s2
    """

    links: TwoLink
    ratio: float

    @property
    def spin(self) -> float:
        """N2 i2 = J2/N2 [kg m^2]."""
        return self.links.rotor[1] / self.ratio

    def model(self, effects: Any = (), coupling: str = "full") -> fd.FlexibleJointModel:
        """Flexdyn's model of it."""
        model = two_link(self.links, effects)
        gears = {
            name: {"gear_ratio": self.ratio, "rotor_inertia": J / self.ratio**2}
            for name, J in zip(("shoulder", "elbow"), self.links.rotor, strict=True)
        }
        return model.replace(joints=gears, rotor_coupling=coupling)

    def inertia(self, q2: float) -> Array:
        """H of [v1, v2, omega1, omega2] (4, 4)."""
        d11, d22, d12, _ = self.links.inertias(q2)
        J1, J2 = self.links.rotor
        return np.array([[d11, d12, 0, self.spin], [d12, d22, 0, 0], [0, 0, J1, 0], [self.spin, 0, 0, J2]])

    def derivative(self, x: list[float], tau: tuple[float, float]) -> list[float]:
        """X' of x = [q, theta, v, omega]."""
        arm, q, v = self.links, x[0:2], x[4:6]
        spring = [arm.stiffness[j] * (x[2 + j] - x[j]) + arm.damping[j] * (x[6 + j] - x[4 + j]) for j in (0, 1)]
        h1, h2 = arm.bias(q, v)
        right = [spring[0] - h1, spring[1] - h2, tau[0] - spring[0], tau[1] - spring[1]]
        return [*x[4:], *np.linalg.solve(self.inertia(q[1]), right).tolist()]

    def energy(self, x: Array) -> float:
        """Kinetic, spring and gravitational energy [J]."""
        return self.links.energy(x.tolist()) + self.spin * float(x[4] * x[7])


def planar(ratio: float = 3.0, *, gravity: float = 9.81, stiffness: tuple[float, float] = (30.0, 20.0)) -> Planar:
    """The arm that most tests move; rigid joints by an infinite stiffness."""
    return Planar(TwoLink(stiffness=stiffness, rotor=(0.2, 0.1), gravity=gravity), ratio)


RIGID = math.inf
