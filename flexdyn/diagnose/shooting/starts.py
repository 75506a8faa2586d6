"""First states of the windows: positions and velocities from the neighbouring samples, the rest from the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexdyn.analysis.jacobian import dry_velocities
from flexdyn.arrays import Array, Flags
from flexdyn.diagnose.data.filters import Filters
from flexdyn.diagnose.data.measured import measured
from flexdyn.diagnose.data.sensors import true_channels
from flexdyn.diagnose.equations.motion import smoothed
from flexdyn.diagnose.shooting.sensing import true_samples
from flexdyn.diagnose.shooting.shooter import Shooter
from flexdyn.effects import DeflectionEffect
from flexdyn.simulation.link_side import LinkSide

REACHES = (0.04, 0.02, 0.01, 0.005)
"""Half widths of the local cubic [s]; the widest one whose error is only noise is used."""
LEAST_REST_TIME = 0.02
"""A joint rests if it stays within its noise for this time before and after [s]."""
INTERNAL_STATE_WIDTH = 0.3
"""Standard deviation of an internal state at a window's start, relative to its reach or the joint's motion, if less."""
DEFLECTION_SHIFTS = (-0.1, 0.1, -0.3, 0.3, -1.0, 1.0)
"""Changes of an unmeasured deflection, in its standard deviations, that are tried where a window strays: while friction
holds the measured side, its linear response says nothing of the deflection."""
START_BOUND_WIDTH = 5.0
"""The width of a first state's prior is this multiple of the smoothing error [1]: the window itself determines it."""
UNMEASURED = (0.0, 0.0, 0.0, 0.1, 0.1, 0.0)
"""Value, two derivatives, errors of value and rate, and whether it rests, where a channel was not recorded."""


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
    found = {name: _at_starts(shooter, name) for name in windows.channels}
    nothing = np.tile(UNMEASURED, (len(windows), 1))

    def side(own: str, other: str) -> Array:
        """Columns of `_at_starts` of one side of all joints (6, windows, n): as measured there, else on the other."""
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
    z, z_std = _memories(shooter)
    first = np.hstack([x, z])
    stuck = first.copy()
    stuck[:, unseen] = 0.0
    deflected = tuple(_shifted(first, own, share * by) for own, _, by in sides for share in DEFLECTION_SHIFTS)
    tied = [(own + at, measured + at) for own, measured, _ in sides for at in (0, x.shape[1] // 2)]
    return Starts(first, _covariances(np.hstack([std, z_std]), tied), stuck if unseen else None, deflected)


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


def _at_starts(shooter: Shooter, name: str) -> Array:
    """One channel at every start (windows, 6): value, two derivatives, errors of value and rate, whether it rests."""
    windows = shooter.windows
    noise = windows.sensor_noise[windows.channels.index(name)]
    table = np.tile(UNMEASURED, (len(windows), 1))
    for k, recording in enumerate(windows.recordings):
        mine = windows.places[:, 0] == k
        if mine.any() and name in recording:
            rows, (t, x) = windows.places[mine, 1], true_samples(shooter.model, recording, name)
            table[mine] = _cubics(t, x, recording.t[rows], rows, noise, windows.period)
    return table


def _cubics(t: Array, x: Array, at: Array, rows: NDArray[np.int64], noise: float, period: float) -> Array:
    """Value, two derivatives, their errors and rest (starts, 6), by the widest cubic that leaves only noise."""
    best = np.full((len(rows), 6), np.nan)
    open_ = np.ones(len(rows), bool)
    for reach in REACHES:
        half = max(4, round(reach / period))
        near = rows[:, None] + np.arange(-half, half + 1)
        inside = (near >= 0) & (near < len(t))
        near = np.clip(near, 0, len(t) - 1)
        u = (t[near] - at[:, None]) / (half * period)
        inside &= np.abs(u) < 1.5  # not across a gap
        inside |= np.arange(2 * half + 1) == half
        weight = inside.astype(float)
        y = x[near]
        basis = weight[:, :, None] * u[:, :, None] ** np.arange(4)
        normal = basis.transpose(0, 2, 1) @ basis + 1e-9 * np.eye(4)
        inverse = np.linalg.inv(normal)
        first = y[:, half]
        fit = (inverse @ (basis.transpose(0, 2, 1) @ (weight * (y - first[:, None]))[:, :, None]))[:, :, 0]
        left = weight * (y - first[:, None]) - (basis @ fit[:, :, None])[:, :, 0]
        size = np.sqrt((left**2).sum(1) / np.maximum(weight.sum(1) - 4, 1.0))
        scale = 1.0 / (half * period)
        error = np.maximum(size, noise)
        value_std, rate_std = (error * np.sqrt(inverse[:, i, i]) for i in (0, 1))
        row = np.stack([
            first + fit[:, 0], fit[:, 1] * scale, 2.0 * fit[:, 2] * scale**2, value_std, rate_std * scale,
            np.zeros(len(rows)),
        ], axis=1)  # fmt: skip
        best[open_] = row[open_]
        open_ &= size > 1.3 * noise
        if not open_.any():
            break
    best[:, 5] = _resting(x, rows, max(3, round(LEAST_REST_TIME / period)), noise)
    return best


def _resting(x: Array, rows: NDArray[np.int64], half: int, noise: float) -> Array:
    y = x[np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(x) - 1)]
    trend = np.abs(y[:, : half + 1].mean(1) - y[:, half:].mean(1))
    still = (y.max(1) - y.min(1) < 8.0 * noise) & (trend < 5.0 * noise / math.sqrt(half) + 1.5 * noise)
    return np.asarray(still, dtype=float)


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


def _memories(shooter: Shooter) -> tuple[Array, Array]:
    """Internal states at the starts, along the measured motion since each recording began."""
    windows = shooter.windows
    z = np.zeros((len(windows), len(shooter.memory)))
    std = np.zeros_like(z)
    for i, effect in enumerate(shooter.memory):
        std[:, i] = INTERNAL_STATE_WIDTH * effect.reach
        for k in range(len(windows.recordings)):
            mine = windows.places[:, 0] == k
            path = _path(shooter, effect, k)
            if path is None or not mine.any():
                continue
            rows = windows.places[mine, 1]
            z[mine, i] = effect.states_along(path[: rows.max() + 1])[rows]
            std[mine, i] = INTERNAL_STATE_WIDTH * min(effect.reach, float(np.ptp(path))) * np.where(rows == 0, 3.0, 1.0)
    return z, std


def _computed_deflection(shooter: Shooter, joint: str, k: int) -> Array | None:
    """Deflection of a joint with one encoder along a recording (samples,); None if the recording is too short."""
    model, recording = shooter.given.resolved(), shooter.windows.recordings[k]
    data = true_channels(measured(model, recording), shooter.given)
    first = Filters.of_rate(data.dt).first
    if len(data.t) <= 4 * first.half:
        return None
    along = smoothed(model, LinkSide(model), data, first)
    delta = along.delta[:, model.joint_names.index(joint)]
    return np.asarray(np.interp(recording.t - recording.t[0], along.t, delta))


def _path(shooter: Shooter, effect: object, k: int) -> Array | None:
    """The smoothed input of an effect with memory: position on its side, or deflection; None if it is unmeasured.

    With one encoder the deflection is that at which the transmission carries what the equations say.
    """
    model, recording = shooter.model, shooter.windows.recordings[k]
    joint = str(getattr(effect, "joint", ""))

    def position(signal: str) -> Array | None:
        name = f"{signal}.{joint}"
        if name not in recording:
            return None
        return np.interp(recording.t, *true_samples(model, recording, name))

    q, theta = position("q"), position("theta")
    path: Array | None
    if getattr(effect, "side", "") == "transmission":
        path = theta - q if q is not None and theta is not None else _computed_deflection(shooter, joint, k)
        rotor = theta if theta is not None else q
        if path is not None and rotor is not None:
            bent = [e for e in model.all_effects if isinstance(e, DeflectionEffect) and e.joint == joint]
            for each in bent:
                path = path if each.is_neutral else each.deflection(path, rotor)
    else:
        both = (q, theta) if getattr(effect, "side", "") == "link" else (theta, q)
        path = next((each for each in both if each is not None), None)  # on its own side, else on the other
    if path is None:  # neither was measured
        return None
    width = max(1, round(0.004 / shooter.windows.period)) * 2 + 1
    padded = np.pad(path, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), "valid")
