"""The smoothed motion of one recording, with computed positions for missing link or motor encoders."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.arrays import Array, Flags, Indices
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import Measured
from flexdyn.diagnose.equations.computed_positions import computed_positions, wound_by_torque
from flexdyn.diagnose.equations.held_torque import HeldTorque, centred
from flexdyn.diagnose.equations.rest import Rests
from flexdyn.diagnose.equations.shared import SharedResults
from flexdyn.diagnose.lazy import kept, lazy
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.simulation.link_side import LinkSide
from flexdyn.simulation.prescribed import links_behind

Places = NDArray[np.intp] | slice
DYNAMICS_STEP = 1e-5
"""Step of the differences of h [rad and rad/s, or m and m/s]."""
SHARED_MOTION_SHARE, SHARED_TORQUE_SHARE = 0.01, 0.1
"""Slopes of h are shared if motions, and their torques, differ by less than these shares of their ranges [1]."""


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Signals after the first filter, at the full rate, one column for each joint.

    Attributes:
        t: times since the start of the run (samples,) [s].
        dt: between samples [s].
        q, v, a: of the links (samples, n).
        theta, omega, alpha: of the rotors (samples, n); those of the links on a rigid joint with one encoder.
        tau: commanded torque (samples, n), the mean over each instant's two halves of held samples.
        tau_s: measured in the transmission (samples, n); zero if it was not.
        data: the channels before the filter, without sensor effects.
        lost: number of samples of `data` before the first one here.
        resting: where motors rest whose links are not measured (samples, n).
        held: tau before the filter; None: it was never recorded.
    """

    t: Array
    dt: float
    q: Array
    v: Array
    a: Array
    theta: Array
    omega: Array
    alpha: Array
    tau: Array
    tau_s: Array
    data: Measured
    lost: int
    resting: Flags
    held: HeldTorque | None

    @property
    def delta(self) -> Array:
        """Deflection theta - q (samples, n) [rad or m]."""
        return self.theta - self.q

    @property
    def ddelta(self) -> Array:
        """Rate of the deflection (samples, n) [rad/s or m/s]."""
        return self.omega - self.v


@dataclass(frozen=True, eq=False)
class SmoothedMotion(Smoothed):
    """Smoothed signals, and the dynamics of the links along them.

    Attributes:
        links: the link side.
        inverse_dynamics: M a + h (samples, n) [N m].
        near: a similar motion whose slopes of M a + h are used; None: its own slopes.
    """

    links: LinkSide
    inverse_dynamics: Array
    near: SmoothedMotion | None = None

    @lazy
    def M(self) -> Array:
        """Mass matrices (samples, n, n) [kg m^2]."""
        return self.links.mass_matrix(self.q)

    @kept
    def inertias(self, filters: Filters) -> Array:
        """Mass matrices at the rows of these filters (times, n, n) [kg m^2]."""
        return self.links.mass_matrix(self.q[filters.instants(len(self.t))])

    @lazy
    def ranges(self) -> tuple[float, float, float]:
        """Largest range of a position, of a speed and of a torque M a + h."""
        q, v, torque = (float(np.ptp(x, axis=0).max()) for x in (self.q, self.v, self.inverse_dynamics))
        return q, v, torque

    def dragged(self, j: int, moved: Sequence[Array], at: Places = slice(None)) -> Array:
        """Change of M a + h (samples, n) by changes of a joint's position, speed and acceleration.

        ``dh/dq_j dq + dh/dv_j dv + M_j da``, with the slopes of h by differences.

        Args:
            j: the joint.
            moved: changes of its position, speed and acceleration (samples,).
            at: samples of the motion.
        """
        if self.near is not None and isinstance(at, slice):
            return self.near.dragged(j, moved, at)
        return np.asarray(sum(s * d[:, None] for s, d in zip(self._slopes(j, at), moved, strict=True)))

    def slopes_by(self, joints: Indices) -> tuple[Array, Array, Array]:
        """Slopes of M a + h at some joints by their positions, speeds and accelerations (samples, joints, joints)."""
        each = [self._slopes(j, slice(None)) for j in joints.tolist()]
        place, speed, M = (np.stack([torque[:, joints] for torque in by], axis=2) for by in zip(*each, strict=True))
        return place, speed, M

    def _slopes(self, j: int, at: Places) -> tuple[Array, Array, Array]:
        """Slopes of M a + h by a joint's position, speed and acceleration (samples, n); kept for further columns."""
        place = (j, isinstance(at, slice))
        if place not in self._known:
            q, v = self.q[at], self.v[at]
            ahead, faster = q.copy(), v.copy()
            ahead[:, j] += DYNAMICS_STEP
            faster[:, j] += DYNAMICS_STEP
            given = self.links.bias(q, v)
            by_place, by_speed = self.links.bias(ahead, v) - given, self.links.bias(q, faster) - given
            M = self.M if isinstance(at, slice) else self.links.mass_matrix(q)
            self._known[place] = (by_place / DYNAMICS_STEP, by_speed / DYNAMICS_STEP, M[:, :, j])
        return self._known[place]

    @lazy
    def _known(self) -> dict[tuple[int, bool], tuple[Array, Array, Array]]:
        return {}


def motion(
    links: LinkSide, signals: Smoothed, base: SmoothedMotion | None = None, shared: SharedResults | None = None
) -> SmoothedMotion:
    """The links' dynamics along smoothed signals.

    Args:
        links: the link side.
        signals: of one recording.
        base: motion of another model in the same recording, whose slopes are used if it is similar.
        shared: what other models may have asked for; None: nothing.
    """
    total = (shared or SharedResults(1)).torques(links, signals.q, signals.v, signals.a)
    made = SmoothedMotion(**vars(signals), links=links, inverse_dynamics=total)
    return dataclasses.replace(made, near=base) if base is not None and _alike(made, base) else made


def _alike(one: SmoothedMotion, base: SmoothedMotion) -> bool:
    """Whether two motions are so similar that the slopes of M a + h can be shared: these enter only small terms."""
    if one.q.shape != base.q.shape:
        return False
    pairs = ((one.q, base.q), (one.v, base.v), (one.inverse_dynamics, base.inverse_dynamics))
    shares = (SHARED_MOTION_SHARE, SHARED_MOTION_SHARE, SHARED_TORQUE_SHARE)
    return all(np.abs(a - b).max() <= s * r for (a, b), s, r in zip(pairs, shares, base.ranges, strict=True))


def smoothed(
    model: FlexibleJointModel,
    links: LinkSide,
    data: Measured,
    kernel: GaussianSmoother,
    rests: Rests | None = None,
    *,
    simulated: bool = False,
    began: Array | None = None,
    shared: SharedResults | None = None,
) -> Smoothed:
    """Smooth a recording.

    Args:
        model: resolved.
        links: its link side.
        data: channels without sensor effects.
        kernel: the first filter.
        rests: where motors rest whose links are not measured; None: nowhere.
        simulated: whether all unmeasured links are simulated along the motion of their motors.
        began: how these links begin, see `replayed`.
        shared: what other models may have asked for; None: nothing.

    A joint with one encoder gets the other position from its own equation (`computed_positions`), or by simulation
    where its motion is prescribed (`replayed`). The whole motion is then filtered once more.
    """
    shared = shared or SharedResults(1)
    q = data.moved
    theta = np.where(data.has_theta, data.theta, q)
    tau = centred(data.tau)
    t, tau_s, lost, inner = data.t, data.tau_s, kernel.half, slice(kernel.half, -kernel.half)
    resting = rests.where if rests else np.zeros((len(t[inner]), model.n), dtype=bool)
    twice = bool((model.elastic & ~data.both).any())
    held = HeldTorque(data.tau, kernel, 1 + twice)
    if twice:
        resting_links = None if simulated else rests
        q, theta = computed_positions(model, links, q, theta, tau, data, kernel, resting_links, shared)
        q = replayed(model, links, q, theta, data, t[inner], simulated, began)
        tau, tau_s = (shared.filtered(kernel, each, 0) for each in (tau, tau_s))
    elif not data.both.all():  # as many samples as for an elastic joint
        q, theta, tau, tau_s = q[inner], theta[inner], tau[inner], tau_s[inner]
    if not data.both.all():
        t, resting, lost = t[inner], resting[inner], lost + kernel.half
    own = {name: shared.filtered(kernel, q, order) for order, name in enumerate(("q", "v", "a"))}
    own |= {name: shared.filtered(kernel, theta, order) for order, name in enumerate(("theta", "omega", "alpha"))}
    own |= {name: shared.filtered(kernel, each, 0) for name, each in (("tau", tau), ("tau_s", tau_s))}
    return Smoothed(t=t[inner], dt=data.dt, **own, data=data, lost=lost, resting=resting, held=held)


def replayed(
    model: FlexibleJointModel,
    links: LinkSide,
    q: Array,
    theta: Array,
    data: Measured,
    t: Array,
    simulated: bool = False,
    began: Array | None = None,
) -> Array:
    """Positions of the links (samples, n), those behind prescribed motors by simulation along the record.

    Args:
        model: resolved.
        links: its link side.
        q: of the links; those behind such motors as the recorded force winds their springs, of which the first sample
            is where the simulation begins.
        theta: of the rotors.
        data: the recording.
        t: times since the start of the run (samples,) [s].
        simulated: whether those behind all other motors are simulated too. They begin where gravity holds them: from
            elsewhere they would vibrate for seconds, and the equations are linear in small vibrations alone.
        began: deflections beyond those by gravity, and rates of deflections, at the first sample (2, n) [rad or m,
            rad/s or m/s]; None: zero.
    """
    hidden = unmeasured_links(model, data) if simulated else hidden_links(model, data)
    joints = np.flatnonzero(hidden).tolist()
    if not joints:
        return q
    course = q.copy()
    course[:, joints] = theta[:, joints]
    first, weight = theta[0].copy(), links.bias(theta[0], np.zeros(model.n))
    wound, winding = np.zeros((2, model.n)) if began is None else began
    for j in joints:
        known = np.isfinite(q[0, j]) and not simulated
        first[j] = q[0, j] if known else theta[0, j] - wound_by_torque(model, j, weight[j : j + 1])[0] - wound[j]
    found = q.copy()
    found[:, joints] = links_behind(model, joints, t, course, first, winding)[:, joints]
    return found


def hidden_links(model: FlexibleJointModel, data: Measured) -> Flags:
    """Elastic joints whose motors are moved as recorded and whose links nobody measures (n,)."""
    return np.asarray(unmeasured_links(model, data) & data.forced)


def unmeasured_links(model: FlexibleJointModel, data: Measured) -> Flags:
    """Elastic joints whose motors have an encoder and whose links have none (n,)."""
    return np.asarray(model.elastic & data.has_theta & ~data.has_q)
