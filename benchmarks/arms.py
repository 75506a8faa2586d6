"""The arms that the benchmarks run: shipped models with the laws that every contestant can solve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm in motion under torques that do not change.

    Attributes:
        model: springs, dampers, viscous friction; Coulomb friction where `dry` was asked for.
        tau: motor torques (n,) [N m].
        q0: first link positions (n,) [rad]; everything starts at rest.
        theta0: first rotor positions (n,) [rad].
        step: of the fixed-step solvers [s].
    """

    model: fd.FlexibleJointModel
    tau: Array
    q0: Array
    theta0: Array
    step: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.model.n

    def coefficients(self, effect: str, side: str) -> Array:
        """The first parameter of an effect, summed by joint (n,)."""
        total = np.zeros(self.n)
        for each in self.model.all_effects:
            if isinstance(each, fd.effects.JointEffect) and (each.name, each.side) == (effect, side):
                total[self.model.index(each.joint)] += each.values[0]
        return total


def two_link(*, dry: bool = False) -> Arm:
    """The paper's two-link arm: soft springs, links at rest, springs strained, a torque on both motors."""
    model = with_laws("scara_two_link", dry=dry)
    return Arm(model, np.array([0.3, -0.1]), np.array([0.0, 0.5 * np.pi]), np.array([0.3, 1.3]), 1e-3)


def six_joints(*, dry: bool = False) -> Arm:
    """The UR5 against gravity, every spring strained by 0.002 rad, 5 N m above the holding torques."""
    model = with_laws("ur5", dry=dry)
    q0 = np.array([model.initial["q"].get(joint, 0.0) for joint in model.joint_names])
    weight = fd.LinkSide(model).bias(q0, np.zeros(model.n))
    return Arm(model, weight + 5.0, q0, q0 + 0.002, 2e-4)


def with_laws(name: str, *, dry: bool = False) -> fd.FlexibleJointModel:
    """A shipped model with its springs, dampers, viscous friction and, if asked for, Coulomb friction only."""
    kept = ("viscous_friction", "coulomb_friction") if dry else ("viscous_friction",)
    model = fd.load_model(name)
    return model.replace(effects=[effect for effect in model.effects if effect.name in kept])
