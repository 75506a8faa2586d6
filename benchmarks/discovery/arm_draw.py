"""Two-link arms drawn at random: what a maker of small industrial arms would build."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import layout as at
import numpy as np
from layout import Array
from two_link_run import Plant

GRAVITY = 9.81  # m/s^2
JOINTS = ("shoulder", "elbow")
LINKS = ("upper_arm", "forearm")


@dataclass(frozen=True)
class TwoLinkArm:
    """The numbers of an arm as its model file and URDF hold them; every pair is (first joint, second joint).

    Attributes:
        vertical: swings in a vertical plane; else gravity does no work.
        length: [m].
        mass: of the links [kg].
        com: distance of their centres of mass from their joints [m].
        inertia: about these centres, around the joint's axis [kg m^2].
        tool: point mass at the tip [kg].
        gear_ratio: [1].
        rotor_inertia: motor side [kg m^2].
        stiffness: [N m/rad]; inf: rigid.
        damping: across the springs [N m s/rad].
        viscous: friction known, on the motors [N m s/rad]; 0: none.
        coulomb: friction known, on the motors [N m]; 0: none.
        middle: of the motion [rad].
    """

    vertical: bool
    length: tuple[float, float]
    mass: tuple[float, float]
    com: tuple[float, float]
    inertia: tuple[float, float]
    tool: float
    gear_ratio: tuple[float, float]
    rotor_inertia: tuple[float, float]
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    viscous: tuple[float, float] = (0.0, 0.0)
    coulomb: tuple[float, float] = (0.0, 0.0)
    middle: tuple[float, float] = (0.0, 0.0)

    def links(self) -> Array:
        """The links' five numbers of `layout`."""
        (l1, l2), (m1, m2), (c1, c2) = self.length, self.mass, self.com
        outer = m2 * c2**2 + self.inertia[1] + self.tool * l2**2
        turn = l1 * (m2 * c2 + self.tool * l2)
        fixed = outer + m1 * c1**2 + self.inertia[0] + (m2 + self.tool) * l1**2
        g = GRAVITY if self.vertical else 0.0
        weights = g * np.array([m1 * c1 + (m2 + self.tool) * l1, m2 * c2 + self.tool * l2])
        return np.array([fixed, turn, outer, *weights])

    def rotor(self) -> Array:
        """Rotor inertias, reflected (2,) [kg m^2]."""
        return np.asarray(np.array(self.gear_ratio) ** 2 * np.array(self.rotor_inertia))

    def plant(self) -> Plant:
        """The true plant without any hidden effect."""
        P = at.neutral()
        P[:, at.ROTOR] = self.rotor()
        rigid = np.isinf(self.stiffness)
        P[:, at.RIGID] = rigid
        P[:, at.K] = np.where(rigid, 0.0, self.stiffness)
        P[:, at.D] = np.where(rigid, 0.0, self.damping)
        P[:, at.MOTOR + at.VISCOUS] = self.viscous
        P[:, at.MOTOR + at.POSITIVE] = P[:, at.MOTOR + at.NEGATIVE] = self.coulomb
        return Plant(P, self.links())

    def replace(self, **changes: object) -> TwoLinkArm:
        """This arm with other numbers."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]


def inertia_at(arm: TwoLinkArm) -> Array:
    """What each joint turns alone, in the middle of the motion (2,) [kg m^2]."""
    fixed, turn, outer = arm.links()[:3]
    return np.array([fixed + 2.0 * turn * np.cos(arm.middle[1]), outer])


def draw_arm(rng: np.random.Generator) -> TwoLinkArm:
    """An arm of 0.6 to 1.2 m reach whose joints swing at 12 to 40 Hz on their springs."""
    length = rng.uniform(0.3, 0.6, 2)
    mass = np.array([rng.uniform(5.0, 12.0), rng.uniform(3.0, 7.0)])
    com = length * rng.uniform(0.35, 0.6, 2)
    vertical = bool(rng.random() < 0.5)
    arm = TwoLinkArm(
        vertical=vertical,
        length=pair(length),
        mass=pair(mass),
        com=pair(com),
        inertia=pair(mass * length**2 * rng.uniform(0.07, 0.11, 2)),
        tool=float(rng.uniform(0.5, 2.0)),
        gear_ratio=pair(np.round(rng.uniform(50.0, 160.0, 2))),
        rotor_inertia=(1.0, 1.0),
        stiffness=(1.0, 1.0),
        damping=(0.0, 0.0),
        middle=(float(rng.uniform(-0.8, 0.8)), float(rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 1.6))),
    )
    M = inertia_at(arm)
    J = M * rng.uniform(0.4, 1.2, 2)
    both = 1.0 / (1.0 / M + 1.0 / J)
    K = np.clip(both * (2.0 * np.pi * np.exp(rng.uniform(np.log(12.0), np.log(40.0), 2))) ** 2, 1000.0, 30000.0)
    D = 2.0 * rng.uniform(0.005, 0.03, 2) * np.sqrt(K * both)
    ratio = np.array(arm.gear_ratio)
    return arm.replace(rotor_inertia=pair(J / ratio**2), stiffness=pair(K), damping=pair(D))


def pair(values: Array) -> tuple[float, float]:
    """Six figures each: what stands in a file is what is true."""
    return float(f"{values[0]:.6g}"), float(f"{values[1]:.6g}")
