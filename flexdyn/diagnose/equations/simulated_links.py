"""Links that nobody measures, simulated behind motors that move as recorded, or behind a rig that moves them."""

from __future__ import annotations

import numpy as np

from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.computed_positions import wound_by_torque
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.prescribed import links_behind


def links_behind_motors(
    model: FlexibleJointModel,
    links: LinkSide,
    q: Array,
    theta: Array,
    data: Measured,
    kernel: GaussianSmoother,
    began: Array | None,
) -> Array:
    """Positions of unmeasured links (samples, n), simulated behind their motors; else NaN.

    They begin where gravity holds them: from elsewhere they would vibrate for seconds, and the equations are linear in
    small vibrations alone. The motors move as recorded, before the filter: waves of the gears pass it as the links do.

    Args:
        model: resolved.
        links: its link side.
        q: measured positions of the links, else those of the rotors (samples, n).
        theta: of the rotors (samples, n).
        data: the recording.
        kernel: the first filter.
        began: deflections beyond those by gravity, and rates of deflections, at the first sample (2, n) [rad or m,
            rad/s or m/s]; None: zero.
    """
    joints = np.flatnonzero(unmeasured_links(model, data)).tolist()
    course = q.copy()
    course[:, joints] = theta[:, joints]
    first, weight = theta[0].copy(), links.bias(theta[0], np.zeros(model.n))
    speeds = kernel.apply(course[: 2 * kernel.half + 1], 1)[0]
    wound, winding = np.zeros((2, model.n)) if began is None else began
    for j in joints:
        first[j] -= wound_by_torque(model, j, weight[j : j + 1])[0] + wound[j]
    found = links_behind(model, joints, data.t, course, first, speeds - winding)
    return np.where(unmeasured_links(model, data), found, np.nan)


def filled(x: Array, other: Array) -> Array:
    """Signals (samples, n) with the columns of others that are not all NaN: a simulation that failed remains NaN."""
    return np.where(np.isnan(other).all(axis=0), x, other)


def replayed(model: FlexibleJointModel, q: Array, theta: Array, data: Measured, t: Array) -> Array:
    """Positions of the links (samples, n), those behind prescribed motors by simulation along the record.

    Args:
        model: resolved.
        q: of the links; those behind such motors as the recorded force winds their springs, of which the first sample
            is where the simulation begins.
        theta: of the rotors.
        data: the recording.
        t: times since the start of the run (samples,) [s].
    """
    joints = np.flatnonzero(hidden_links(model, data)).tolist()
    if not joints:
        return q
    course = q.copy()
    course[:, joints] = theta[:, joints]
    first = np.where(np.isfinite(q[0]), q[0], theta[0])
    found = q.copy()
    found[:, joints] = links_behind(model, joints, t, course, first)[:, joints]
    return found


def hidden_links(model: FlexibleJointModel, data: Measured) -> Flags:
    """Elastic joints whose motors are moved as recorded and whose links nobody measures (n,)."""
    return np.asarray(unmeasured_links(model, data) & data.forced)


def unmeasured_links(model: FlexibleJointModel, data: Measured) -> Flags:
    """Elastic joints whose motors have an encoder and whose links have none (n,)."""
    return np.asarray(model.elastic & data.has_theta & ~data.has_q)
