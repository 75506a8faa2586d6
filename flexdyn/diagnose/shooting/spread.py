"""The propagation of noise through a window: sensitivities to first state and torques along the simulated motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.analysis.jacobian import dry_velocities
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.parallel import in_parallel
from flexdyn.diagnose.shooting.sensing import of_windows, sensors
from flexdyn.diagnose.shooting.shooter import Shooter, SimulatedWindows
from flexdyn.diagnose.shooting.windows import PerWindow, Windows
from flexdyn.effects.channels import slope

Indices = NDArray[np.int64]
GAINS_EVERY = 5
"""Number of blocks over which the effect of torques on accelerations is taken as constant."""
LARGEST_SLOPE = 1e9
"""Bound of slopes and responses: larger ones belong to divergent motions."""
STEEP_FEEDBACK = 20.0
"""Bound of growth rates [1/s]: a larger one, from falling friction near rest, lasts only for an instant."""
SLOW_CONTACT_RATIO = 10.0
"""Noise may decide about sticking if a velocity is below this multiple of its change by noise over a block [1]."""


@dataclass(frozen=True, eq=False)
class Spread(PerWindow):
    """The linear response of every window, from the middle of one block to that of the next.

    Attributes:
        flow: transition to the middle of every block, for the first from the window's start (windows, blocks, nx, nx).
        push: covariance that the torque noise adds in between (windows, blocks, nx, nx).
        seen: derivative of channels by states at the middle of every block, with sensors (windows, blocks, channels,
            nx).
    """

    flow: Array
    push: Array
    seen: Array


def spread(shooter: Shooter, whole: SimulatedWindows, which: Indices) -> Spread:
    """Linear response of windows along their simulated motion.

    The plant's Jacobian is taken as constant over a block; the velocity of a contact that sticks at its beginning is
    removed. The effect of a reversal on a sliding velocity is neglected.

    Args:
        shooter: that simulated them.
        whole: motion of all windows.
        which: windows to use.
    """
    windows, n, motion = shooter.windows, shooter.model.n, whole.part(which)
    A, B = _slopes(shooter, motion, which)
    still = _still(shooter, motion)
    free, A[still], B[still] = B.copy(), 0.0, 0.0
    # The mean of a block belongs to the time (block - 1)/2 samples after its first one.
    to, fro = (0.5 * (windows.block + side) * windows.period for side in (-1, 1))
    (into, pushed_in), (out, pushed_out) = in_parallel(
        lambda h: _over(h, A, B, windows, n + len(shooter.elastic)), (to, fro)
    )
    unsure = _undecided(shooter, motion, free)
    positions = np.arange(unsure.shape[2])
    pushed_out[:, :, positions, positions] += unsure * (to + fro) ** 2
    keep = 1.0 - still[:, :, None, :]
    first = into * keep  # from a state without sticking velocities
    flow, pushed = first.copy(), pushed_in.copy()
    flow[:, 1:] = first[:, 1:] @ out[:, :-1]
    pushed[:, 1:] += first[:, 1:] @ pushed_out[:, :-1] @ first[:, 1:].transpose(0, 1, 3, 2)
    return Spread(flow, pushed, _outputs(shooter) * _gains(shooter, motion, which)[..., None])


def _over(h: float, A: Array, B: Array, windows: Windows, positions: int) -> tuple[Array, Array]:
    """Transition over a time h, and the covariance that white torque noise adds in this time."""
    count, knots, nx, n = B.shape
    if h == 0.0:
        return np.broadcast_to(np.eye(nx), A.shape), np.zeros_like(A)
    both = np.concatenate([np.concatenate([A, B], 3), np.zeros((count, knots, n, nx + n))], 2)
    flow = _exponential(both * h)
    kick = flow[:, :, :nx, nx:] * (windows.noise.tau * np.sqrt(windows.period / h))
    push = kick @ kick.transpose(0, 1, 3, 2)
    # Noise that is held over h/m gives the position variance h^3/3 (1 - 1/4m^2), noise that is held over h only h^3/4.
    x, u = np.arange(positions), np.arange(positions, 2 * positions)
    push[:, :, x, x] += push[:, :, u, u] * max(h**2 - windows.period**2, 0.0) / 12.0
    return flow[:, :, :nx, :nx], push


def _slopes(shooter: Shooter, motion: SimulatedWindows, which: Indices) -> tuple[Array, Array]:
    """A and B at the start of every block; in B all contacts are free, and steeply falling friction is limited."""
    count, knots, nx = motion.x.shape
    n = shooter.model.n
    A, B = np.zeros((count, knots, nx, nx)), np.zeros((count, knots, nx, n))
    for w in np.flatnonzero(motion.written == shooter.windows.rows).tolist():
        place = int(which[w])
        shooter.plants[place].slopes_along(motion.x[w], shooter.torques(place), GAINS_EVERY, A[w], B[w])
    A, B = (np.clip(np.nan_to_num(each), -LARGEST_SLOPE, LARGEST_SLOPE) for each in (A, B))
    half = n + len(shooter.elastic)
    velocities = np.arange(half, 2 * half)
    steep = A[:, :, velocities, velocities] > STEEP_FEEDBACK
    A[:, :, half : 2 * half, half : 2 * half] *= ~steep[:, :, None, :]
    return A, B


def _still(shooter: Shooter, motion: SimulatedWindows) -> Flags:
    """States that are velocities of sticking contacts (windows, blocks, nx)."""
    half = shooter.model.n + len(shooter.elastic)
    still = np.zeros(motion.x.shape, bool)
    for place in dry_velocities(shooter.model):
        still[:, :, half + place] = motion.x[:, :, half + place] == 0.0
    return still


def _undecided(shooter: Shooter, motion: SimulatedWindows, B: Array) -> Array:
    """Variance of velocities where noise decides whether a contact sticks or slides (windows, blocks, positions).

    There the motion is not linear in the noise: the contact may stick, or move like a free one.
    """
    windows, half = shooter.windows, shooter.model.n + len(shooter.elastic)
    h = windows.block * windows.period
    kick = ((B * windows.noise.tau) ** 2).sum(axis=3) * windows.period * h
    found = np.zeros((*motion.x.shape[:2], half))
    for place in dry_velocities(shooter.model):
        speed, spread_ = np.abs(motion.x[:, :, half + place]), np.sqrt(kick[:, :, half + place])
        near = _near_flagged(speed == 0.0) & _near_flagged(speed > 0.0) | (speed > 0.0) & (
            speed < SLOW_CONTACT_RATIO * spread_
        )
        found[:, :, place] = np.where(near, spread_**2, 0.0)
    return found


def _near_flagged(flags: Flags) -> Flags:
    """Whether a block is within two blocks of one with the flag."""
    padded = np.pad(flags, ((0, 0), (2, 2)))
    return np.asarray(np.logical_or.reduce([padded[:, k : k + flags.shape[1]] for k in range(5)]))


def _exponential(A: Array) -> Array:
    """Matrix exponentials of a stack, by scaling, a Taylor series of order 6 and squaring.

    The states are scaled so that rows and columns have similar sizes: then stiff springs need few squarings.
    """
    from scipy.linalg import matrix_balance

    _, (unit, _) = matrix_balance(np.abs(A).max(axis=tuple(range(A.ndim - 2))), permute=False, separate=True)
    ratio = unit / unit[:, None]
    A = A * ratio
    size = float(np.abs(A).sum(axis=-1).max())
    halvings = max(0, int(np.ceil(np.log2(max(size, 1e-9) / 0.5))))
    halvings = min(halvings, 30)
    small, one = A / 2.0**halvings, np.eye(A.shape[-1])
    total = one + small / 6.0
    for order in (5, 4, 3, 2, 1):
        total = one + small @ total / order
    for _ in range(halvings):
        total = np.clip(total @ total, -LARGEST_SLOPE, LARGEST_SLOPE)
    return np.asarray(np.clip(total / ratio, -LARGEST_SLOPE, LARGEST_SLOPE))


def _outputs(shooter: Shooter) -> Array:
    """The state that every channel measures (channels, nx)."""
    model, e = shooter.model, shooter.elastic.tolist()
    C = np.zeros((len(shooter.windows.channels), shooter.size))
    for k, name in enumerate(shooter.windows.channels):
        signal, _, joint = name.partition(".")
        j = model.index(joint)
        C[k, model.n + e.index(j) if signal == "theta" and j in e else j] = 1.0
    return C


def _gains(shooter: Shooter, motion: SimulatedWindows, which: Indices) -> Array:
    """Slope of every sensor (windows, blocks, channels)."""
    windows = shooter.windows
    gain = np.ones((len(which), windows.blocks, len(windows.channels)))
    for k, name in enumerate(windows.channels):
        signal, _, joint = name.partition(".")
        x = getattr(motion, signal)[:, :: windows.block, shooter.model.index(joint)]
        effects = sensors(shooter.model, name)
        if effects:
            made = of_windows(slope, effects, x, windows.t[which, :: windows.block])
            gain[:, :, k] = np.where(np.isfinite(x), made, 1.0)  # a window that failed has no position from there on
    return gain
