"""Check that the two encoders of a joint tell of the same motion."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.match import WOUND_SPRING_RATIO
from flexdyn.diagnose.equations.mistakes import DEGREE, EXPLAINED_SHARE, SMALLEST_CHECKED_RATIO
from flexdyn.errors import InputError
from flexdyn.model.flexible_joint_model import FlexibleJointModel

ENCODERS_ALIKE_SHARE = 0.9
"""Smallest common share of the variance of the two encoders of a joint [1]."""
DEAD_ENCODER_SHARE = 1e-3
"""An encoder does not work if its range is below this share of the range of the joint's other one [1]."""


def check_encoders(model: FlexibleJointModel, data: Measured) -> None:
    """Check that both positions of a joint are nearly the same: deflections are small.

    If friction or the motor holds one side of a joint, the other side may move by the deflection alone.
    """
    both = np.flatnonzero(data.both)
    for j in both:
        joint = model.joint_names[j]
        wound = WOUND_SPRING_RATIO * float(np.abs(data.tau[:, j]).max()) / float(model.stiffness[j])
        if max(np.ptp(data.q[:, j]), np.ptp(data.theta[:, j])) <= wound:
            continue
        for dead, alive in (("q", "theta"), ("theta", "q")):
            x, y = getattr(data, dead)[:, j], getattr(data, alive)[:, j]
            if np.ptp(x) < DEAD_ENCODER_SHARE * np.ptp(y):
                problem, remedy = f"it rests while {alive}.{joint} moves", f"leave out {dead}.{joint}"
                value = f"a range of {np.ptp(x):.2g} against {np.ptp(y):.2g}"
                raise InputError(problem, file=data.name, key=f"{dead}.{joint}", value=value, remedy=remedy)
        slope, share = _regression_line(data.q[:, j], data.theta[:, j])
        if share > ENCODERS_ALIKE_SHARE and 0.5 < slope < 2.0:
            continue
        for factor, problem, remedy in sorted(_looks(model, int(j)), key=lambda look: abs(slope / look[0] - 1.0)):
            if share > EXPLAINED_SHARE and 0.8 < slope / factor < 1.25:
                value = f"theta = {slope:.4g} q"
                raise InputError(problem, file=data.name, key=f"theta.{joint}", value=value, remedy=remedy)
        for i in both:
            other, alike = _regression_line(data.q[:, i], data.theta[:, j])
            if i != j and share < ENCODERS_ALIKE_SHARE and alike > 0.99 and 0.8 < abs(other) < 1.25:
                there = model.joint_names[i]
                problem = f"theta follows the q of {there}, and not that of its own joint"
                remedy = f"exchange theta.{joint} and theta.{there}, or their q"
                value = f"correlation {np.sqrt(alike):.3f} against {np.sqrt(share):.3f}"
                raise InputError(problem, file=data.name, key=f"theta.{joint}", value=value, remedy=remedy)


def _looks(model: FlexibleJointModel, j: int) -> list[tuple[float, str, str]]:
    """Slopes of theta over q for possible mistakes, with the mistake and the remedy."""
    joint = model.joint_names[j]
    ratio = model.joints[joint].gear_ratio
    small, unit = ("mm", 1e3) if model.robot.kinds[j] == "prismatic" else ("degrees", DEGREE)
    looks = [
        (-1.0, "theta and q have opposite signs", f"change the sign of theta.{joint} or q.{joint}"),
        (unit, f"theta is in {small} and q is not", f"convert theta.{joint}"),
        (1.0 / unit, f"q is in {small} and theta is not", f"convert q.{joint}"),
    ]
    if abs(ratio) <= SMALLEST_CHECKED_RATIO:
        return looks
    remedy = f"divide theta.{joint} by the gear ratio {ratio:g} (side: motor)"
    turned = f"divide theta.{joint} by {-ratio:g}"
    return [
        (ratio, "theta is the motor's angle", remedy),
        (-ratio, "theta is the motor's angle, flipped", turned),
        *looks,
    ]


def _regression_line(x: Array, y: Array) -> tuple[float, float]:
    """Slope of y over x, and their common share of variance."""
    dx, dy = x - x.mean(), y - y.mean()
    xx, yy, xy = float(dx @ dx), float(dy @ dy), float(dx @ dy)
    if xx == 0.0 or yy == 0.0:
        return 0.0, 0.0
    return xy / xx, xy * xy / (xx * yy)
