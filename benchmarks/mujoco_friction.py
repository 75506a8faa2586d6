"""MuJoCo's dry friction made as hard as it gets."""

from __future__ import annotations

from mujoco_arm import MujocoArm

IMPEDANCE = [0.9999, 0.9999, 0.001, 0.5, 2.0]


def harden(peer: MujocoArm, step: float) -> None:
    """The greatest impedance that MuJoCo takes, and the shortest time constant that it recommends, twice the step."""
    peer.model.dof_solref[:] = [2.0 * step, 1.0]
    peer.model.dof_solimp[:] = IMPEDANCE
