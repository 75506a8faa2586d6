"""frequencies_over_path: how eigenfrequencies and anti-resonances change as an arm moves through its poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.analysis.analysed_model import checked_model
from flexdyn.analysis.eigenmodes import Rotors, check_rotors, modes_at, resting_statics
from flexdyn.arrays import Array
from flexdyn.checks import as_numbers
from flexdyn.errors import InputError
from flexdyn.io.locked import Locked
from flexdyn.model.flexible_joint_model import FlexibleJointModel


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PathFrequencies(Locked):
    """Frequencies along a path, ready to plot: ``plt.plot(found.distance, found.frequencies)``.

    Attributes:
        joint_names: in the order of q.
        rotors: ``free`` or ``held``.
        q: poses (samples, n) [rad or m].
        distance: length of the path in joint space up to each pose (samples,) [rad, m mixed in where joints slide].
        frequencies: (samples, m) [Hz], sorted at every pose: lines do not cross.
        damping_ratios: (samples, m) [1]; NaN where the frequency is 0.
        anti_resonances: (samples, n, others) [Hz], by motor.

    Example:
        >>> model = fd.load_model("ur5")
        >>> found = fd.frequencies_over_path(model, np.linspace(np.zeros(6), [0, 0, 1.2, 0, 0, 0], 5))
        >>> found.distance.size
        5
    """

    joint_names: tuple[str, ...]
    rotors: str
    q: Array
    distance: Array
    frequencies: Array
    damping_ratios: Array
    anti_resonances: Array

    def __repr__(self) -> str:
        """A summary in one line."""
        low, high = self.frequencies.min(axis=0), self.frequencies.max(axis=0)
        spans = ", ".join(f"{a:.4g}-{b:.4g}" for a, b in zip(low, high, strict=True))
        return f"<PathFrequencies {len(self.q)} poses, rotors {self.rotors}: {spans} Hz>"


def frequencies_over_path(
    model: FlexibleJointModel, path: ArrayLike | Any, *, rotors: Rotors = "free"
) -> PathFrequencies:
    """Eigenfrequencies at every pose of a path, each as if the arm rested there.

    Args:
        model: the arm.
        path: poses (samples, n) [rad or m], or a `Run`, whose q is used.
        rotors: ``free`` or ``held``, as in `modes`.

    Returns:
        frequencies, damping ratios and anti-resonances by pose.

    Raises:
        InputError: a path that does not fit the model, or an error of `modes`.

    Example:
        >>> model = fd.load_model("ur5")
        >>> path = np.linspace(np.zeros(6), [0, 0, 1.2, 0, 0, 0], 5)
        >>> fd.frequencies_over_path(model, path).frequencies.shape[0]
        5
    """
    model = checked_model(model)
    check_rotors(model, rotors)
    poses = as_numbers("path", getattr(path, "q", path), "poses are numbers")
    if poses.ndim != 2 or poses.shape[1] != model.n or not len(poses) or not np.isfinite(poses).all():
        problem = f"finite positions (samples, {model.n}) are needed"
        raise InputError(problem, key="path", value=poses.shape, remedy="give a row for each pose")
    statics = resting_statics(model)
    found = [modes_at(statics, q, rotors) for q in poses]
    steps = np.linalg.norm(np.diff(poses, axis=0), axis=1)
    return PathFrequencies(
        joint_names=model.joint_names,
        rotors=rotors,
        q=poses,
        distance=np.concatenate([[0.0], np.cumsum(steps)]),
        frequencies=np.array([each.frequencies for each in found]),
        damping_ratios=np.array([each.damping_ratios for each in found]),
        anti_resonances=np.array([each.anti_resonances for each in found]),
    )
