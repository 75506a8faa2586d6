"""flexdyn's models of the reference arms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from tests.effects.reference import NAMES, Arm

Array = NDArray[np.float64]


def model_of(arm: Arm, effects: Iterable[fd.effects.Effect] | None = None, **settings: Any) -> fd.FlexibleJointModel:
    """The arm's model; with its own effects unless others are given."""
    robot = fd.load_robot("scara_two_link", lock={} if arm.n == 2 else {"elbow": 0.0})
    joints = {
        name: {"rotor_inertia": arm.rotor[j], "stiffness": arm.stiffness[j], "damping": arm.damping[j]}
        for j, name in enumerate(NAMES[: arm.n])
    }
    kept = arm.effects if effects is None else tuple(effects)
    return fd.FlexibleJointModel(robot, joints, kept, gravity=[0.0, -arm.gravity, 0.0], **settings)


def states(run: fd.Run) -> Array:
    """[q, theta, v, omega] of a run, rotor columns of elastic joints alone, as the reference orders them."""
    elastic = run.model.elastic
    return np.hstack([run.q, run.theta[:, elastic], run.v, run.omega[:, elastic]])


def catalogue_examples() -> list[Any]:
    """One of every effect, on the joints of the two-link arm."""
    return [kind.example("shoulder", "elbow") for kind in fd.effects.catalogue().values() if own(kind)]


def own(kind: type[fd.effects.Effect]) -> bool:
    """Whether an effect is flexdyn's own and not one that a test defined."""
    return kind.__module__.startswith("flexdyn.")


ELASTIC = Arm((300.0, 200.0), (0.5, 0.3), (0.1, 0.1))
"""Two elastic joints."""
RIGID = Arm((np.inf, np.inf), (0.0, 0.0), (0.1, 0.1))
"""Two rigid joints whose rotors have inertia."""
