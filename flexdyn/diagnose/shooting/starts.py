"""First states of the windows: positions and velocities from the neighbouring samples, the rest from the model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexdyn.analysis.jacobian import dry_velocities
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.equations.computed_positions import acting_on
from flexdyn.diagnose.shooting.internal_states import internal_states
from flexdyn.diagnose.shooting.local_cubics import UNMEASURED, channel_at_starts
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.effects import DeflectionEffect
from flexdyn.simulation.link_side import LinkSide

DEFLECTION_SHIFTS = (-0.1, 0.1, -0.3, 0.3, -1.0, 1.0)
"""Changes of an unmeasured deflection, in its standard deviations, that are tried where a window strays: while friction
holds the measured side, its linear response says nothing of the deflection."""
GAP_PLACES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Deflections within a gap, in half gaps, that are tried likewise: a link in its gap feels nothing of the motor."""
START_BOUND_WIDTH = 5.0
"""The width of a first state's prior is this multiple of the smoothing error [1]: the window itself determines it."""


@dataclass(frozen=True, eq=False)
class Starts:
    """Prior means and covariances of first states.

    Attributes:
        x: means (windows, nx).
        prior: covariances (windows, nx, nx); 0 where a state is certain, as the velocity of a sticking joint.
        stuck: the same states with all contacts at rest on unmeasured sides, where friction may hold them; None without
            such contacts.
        deflected: the same states with other deflections of joints of which one side is unmeasured.
    """

    x: Array
    prior: Array
    stuck: Array | None = None
    deflected: tuple[Array, ...] = ()


def window_starts(shooter: Shooter) -> Starts:
    """First states of every window for a model.

    Positions and velocities come from a local cubic over the samples before and after the start. If one encoder is
    missing, the springs carry the torques that the links need for the measured acceleration: an error of the measured
    side is one of both sides, and the deflection has its own. Contacts that rest within the noise start with velocity
    0, to the last bit. Internal states follow the measured path up to the start.
    """
    windows, model = shooter.windows, shooter.model
    found = {name: channel_at_starts(shooter, name) for name in windows.channels}
    nothing = np.tile(UNMEASURED, (len(windows), 1))

    def side(own: str, other: str) -> Array:
        """Columns of `channel_at_starts` of a side of all joints (6, windows, n): measured there, or on the other."""
        both = ([f"{signal}.{joint}" for signal in (own, other)] for joint in model.joint_names)
        tables = [next((found[name] for name in names if name in found), nothing) for names in both]
        return np.array(tables).transpose(2, 1, 0).copy()

    q, v, bend, q_std, v_std, link_rests = side("q", "theta")
    theta, omega, _, theta_std, omega_std, rotor_rests = side("theta", "q")
    rests = (link_rests > 0) & (rotor_rests > 0)
    both = np.array([f"q.{joint}" in found and f"theta.{joint}" in found for joint in model.joint_names])
    delta = _wound_at_starts(shooter, np.where(both, 0.5 * (q + theta), q), v, bend)
    e, vibration = shooter.elastic, _vibrations(shooter, q)
    sides: list[tuple[int, int, Array]] = []
    for k, j in enumerate(e.tolist()):
        joint = model.joint_names[j]
        if both[j]:
            continue
        spread = 0.3 * np.abs(delta[:, j]) + 0.1 * np.abs(delta[:, j]).mean()
        rate = np.minimum(np.gradient(delta[:, j]).std() + 0.01 * np.abs(v[:, j]), vibration[:, k] * spread)
        if f"q.{joint}" in found:
            theta[:, j], theta_std[:, j] = q[:, j] + delta[:, j], spread
            omega_std[:, j] = rate
            sides.append((model.n + k, j, spread))
        else:
            q[:, j], q_std[:, j] = theta[:, j] - delta[:, j], spread
            v_std[:, j] = rate
            sides.append((j, model.n + k, spread))
    x = np.hstack([q, theta[:, e], v, omega[:, e]])
    std = START_BOUND_WIDTH * np.hstack([q_std, theta_std[:, e], v_std, omega_std[:, e]])
    unseen = _stick(shooter, x, std, rests)
    z, z_std = internal_states(shooter)
    first = np.hstack([x, z])
    stuck = first.copy()
    stuck[:, unseen] = 0.0
    deflected = tuple(_shifted(first, own, share * by) for own, _, by in sides for share in DEFLECTION_SHIFTS)
    deflected += tuple(_within_gaps(shooter, first, delta))
    tied = [(own + at, measured + at) for own, measured, _ in sides for at in (0, x.shape[1] // 2)]
    return Starts(first, _covariances(np.hstack([std, z_std]), tied), stuck if unseen else None, deflected)


def _within_gaps(shooter: Shooter, first: Array, delta: Array) -> Iterator[Array]:
    """First states with a link elsewhere in the gap of its gear, where it has one and a side is not measured."""
    model, n = shooter.model, shooter.model.n
    for k, j in enumerate(shooter.elastic.tolist()):
        joint = model.joint_names[j]
        measured = [f"{signal}.{joint}" in shooter.windows.channels for signal in ("q", "theta")]
        gap = sum(e.gap for e in acting_on(model, j) if isinstance(e, DeflectionEffect))
        for share in GAP_PLACES if gap and not all(measured) else ():
            further = share * gap - delta[:, j]
            yield _shifted(first, n + k, further) if measured[0] else _shifted(first, j, -further)


def _vibrations(shooter: Shooter, q: Array) -> Array:
    """Angular frequency at which each spring vibrates between its rotor and the links (windows, elastic) [rad/s].

    A deflection with an error s may vibrate by s: its rate then has an error of s times this frequency.
    """
    model, e = shooter.model, shooter.elastic
    if not len(e):
        return np.zeros((len(q), 0))
    mobility = np.linalg.inv(LinkSide(model).mass_matrix(q))[:, e, e] + 1.0 / model.rotor_inertia[e]
    return np.asarray(np.sqrt(model.stiffness[e] * mobility))


def _covariances(std: Array, tied: Sequence[tuple[int, int]]) -> Array:
    """Covariances (windows, nx, nx) of independent errors; a tied state has those of another state as well."""
    root = std[:, :, None] * np.eye(std.shape[1])
    for own, other in tied:
        root[:, own, other] = std[:, other]
    return root @ root.transpose(0, 2, 1)


def _shifted(x: Array, place: int, by: Array) -> Array:
    """States with one entry changed."""
    x = x.copy()
    x[:, place] += by
    return x


def _wound_at_starts(shooter: Shooter, q: Array, v: Array, bend: Array) -> Array:
    """Deflection (windows, n) at which the model's links have the measured acceleration."""
    model, elastic = shooter.model, shooter.elastic
    delta = np.zeros_like(q)
    if not len(elastic):
        return delta
    n, half = model.n, model.n + len(elastic)
    M = LinkSide(model).mass_matrix(q)
    stiffness = model.stiffness[elastic]
    tau, out = np.zeros(n), np.empty(shooter.size)
    for w in range(len(q)):
        x = np.zeros(shooter.size)
        x[:n], x[half : half + n], x[half + n : 2 * half] = q[w], v[w], v[w, elastic]
        for _ in range(12):
            x[n:half] = q[w, elastic] + delta[w, elastic]
            shooter.plants[w].derivative(0.0, x, tau, 1e-3, out)
            need = (M[w] @ (bend[w] - out[half : half + n]))[elastic]
            if not np.isfinite(need).all():
                break
            step = need / stiffness
            delta[w, elastic] += step
            if np.abs(step).max() < 1e-9:
                break
    return delta


def _stick(shooter: Shooter, x: Array, std: Array, rests: Flags) -> list[int]:
    """Set the velocities of contacts with dry friction that rest within the noise to 0, without uncertainty.

    This is not done on an unmeasured side: it may move while the other side rests, because the spring deflects. The
    indices of such velocities in the state are returned.
    """
    model, e = shooter.model, shooter.elastic.tolist()
    half, unseen = model.n + len(e), []
    for place in dry_velocities(model):
        j = place if place < model.n else e[place - model.n]
        own = f"{'q' if place < model.n else 'theta'}.{model.joint_names[j]}"
        if own in shooter.windows.channels or not model.elastic[j]:
            x[rests[:, j], half + place] = std[rests[:, j], half + place] = 0.0
        else:
            unseen.append(half + place)
    return unseen
