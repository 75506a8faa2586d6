"""Runs of the two-link arm: joint control at 1 kHz through the encoders, or torques given; what really happened."""

from __future__ import annotations

from dataclasses import dataclass, field

import layout as at
import numpy as np
from cables import NONE, Cables, pull
from compiled import compiled
from layout import Array
from two_link_forces import FORCES, TAU_S, forces
from two_link_motion import advance

PERIOD = 1e-3  # s, of control and of recordings
STEP = 1e-4  # s, of the integration: wrong by less than 1e-7 rad after 1 s, whatever is hidden


@dataclass(frozen=True, eq=False)
class Plant:
    """The true arm.

    Attributes:
        P: the table of `layout` (2, COLUMNS).
        links: FIXED, TURN, OUTER [kg m^2], WEIGHT_1, WEIGHT_2 [N m] (5,).
    """

    P: Array
    links: Array


@dataclass(frozen=True, eq=False)
class Control:
    """Joint PD with feedforward on what the motor encoders say (link encoders on rigid joints).

    Attributes:
        reference: positions wanted (samples, 2) [rad].
        feedforward: torques added (samples, 2) [N m].
        kp: [N m/rad] (2,).
        kd: [N m s/rad] (2,).
        resolution: of the encoders that are fed back (2,) [rad].
        filtered: time constant of the low pass on the differences of positions [s].
    """

    reference: Array
    feedforward: Array
    kp: Array
    kd: Array
    resolution: Array
    filtered: float = 1.5e-3


@dataclass(frozen=True, eq=False)
class Truth:
    """What really happened, one row per sample.

    Attributes:
        t: [s] (samples,).
        y: states as `layout` orders them (samples, STATES).
        tau: torques asked for, held until the next sample (samples, 2) [N m].
        tau_s: torques of the transmissions on the links (samples, 2) [N m].
        cables: torques of the cables, against the links (samples, 2) [N m]; empty: no cables.
    """

    t: Array
    y: Array
    tau: Array
    tau_s: Array
    P: Array = field(repr=False)
    links: Array = field(repr=False)
    cables: Array = field(default_factory=lambda: np.zeros((0, 2)), repr=False)


@compiled
def arrived(tau: Array, k: int, behind: int, j: int) -> float:
    """The torque asked for so many samples before sample k, nothing before the first [N m]."""
    return tau[k - behind, j] if k - behind >= 0 else 0.0


@compiled
def one_period(k: int, period: float, step: float, y: Array, memory: Array, tau: Array, P: Array, links: Array) -> None:
    """From sample k to the next, cut where a late torque arrives."""
    late = np.floor(P[:, at.DELAY] / period + 1e-9)
    cuts = np.zeros(4)
    cuts[1:3] = np.sort(P[:, at.DELAY] - late * period)
    cuts[3] = period
    now = np.zeros(2)
    for piece in range(3):
        begin, end = max(0.0, cuts[piece]), cuts[piece + 1]
        if end - begin < 1e-12:
            continue
        for j in range(2):
            waits = P[j, at.DELAY] - late[j] * period > begin + 1e-12
            now[j] = arrived(tau, k, int(late[j]) + (1 if waits else 0), j)
        advance(k * period + begin, k * period + end, step, y, memory, now, P, links)


@compiled
def loop(
    y: Array, tau: Array, noise: Array, control: tuple[Array, ...], filtered: float, period: float, step: float,
    P: Array, links: Array, cables: tuple[Array, ...], out: Array, out_tau_s: Array, out_cables: Array,
) -> None:  # fmt: skip
    """All samples; tau is filled in where control holds gains, else followed."""
    reference, feedforward, kp, kd, resolution = control
    memory, F = np.zeros((3, 2)), np.zeros(FORCES)
    applied = np.zeros_like(tau)
    before, slow = np.zeros(2), np.zeros(2)
    others, waves, ropes = cables
    bent, last = np.zeros(2), y[:2].copy()
    for k in range(len(tau)):
        for j in range(2):
            if len(kp):
                true = y[j] if P[j, at.RIGID] > 0.0 else y[2 + j]
                seen = np.floor(true / resolution[j]) * resolution[j]
                if k == 0:
                    before[j] = seen
                wanted = (reference[min(k + 1, len(tau) - 1), j] - reference[k, j]) / period
                slow[j] += period / (period + filtered) * ((seen - before[j]) / period - slow[j])
                before[j] = seen
                tau[k, j] = feedforward[k, j] + kp[j] * (reference[k, j] - seen) + kd[j] * (wanted - slow[j])
            applied[k, j] = tau[k, j] + noise[k, j]
        out[k] = y
        if len(out_cables):
            pull(y[:2], last, bent, others, waves, ropes, out_cables[k])
            last[:] = y[:2]
            P[:, at.PULL] = out_cables[k]
        forces(k * period, y, y, memory, applied[k], P, links, F)
        out_tau_s[k] = F[TAU_S : TAU_S + 2]
        one_period(k, period, step, y, memory, applied, P, links)


def start(plant: Plant, q: Array) -> Array:
    """The state at rest at q, springs wound by gravity (STATES,)."""
    y = np.zeros(at.STATES)
    weight = plant.links[at.WEIGHT_2] * np.cos(q[0] + q[1])
    hang = np.array([plant.links[at.WEIGHT_1] * np.cos(q[0]) + weight, weight])
    elastic = plant.P[:, at.RIGID] == 0.0
    y[0:2] = q
    y[2:4] = q + np.where(elastic, hang / np.where(elastic, plant.P[:, at.K], 1.0), 0.0)
    gap = np.where(elastic, plant.P[:, at.HALF_GAP], 0.0)
    y[2:4] += gap * np.sign(hang)
    y[8] = q[0] if plant.P[0, at.MODE_INERTIA] > 0 else q[0] + q[1]
    return y


def controlled(
    plant: Plant, control: Control, noise: Array | None = None, step: float = STEP, cables: Cables = NONE
) -> Truth:
    """A run under control; noise: torque that the motors add unasked, held (samples, 2) [N m]."""
    parts = (control.reference, control.feedforward, control.kp, control.kd, control.resolution)
    tau = np.zeros_like(control.reference)
    return _run(plant, start(plant, control.reference[0]), tau, noise, parts, control.filtered, step, cables)


def replayed(plant: Plant, y0: Array, tau: Array, step: float = STEP) -> Truth:
    """A run under the torques asked for, held (samples, 2) [N m]."""
    nothing = np.zeros((0, 2))
    parts = (nothing, nothing, np.zeros(0), np.zeros(0), np.zeros(0))
    return _run(plant, y0.copy(), tau.copy(), None, parts, 1.0, step, NONE)


def _run(
    plant: Plant, y: Array, tau: Array, noise: Array | None, control: tuple[Array, ...], filtered: float, step: float,
    cables: Cables,
) -> Truth:  # fmt: skip
    out, tau_s = np.zeros((len(tau), at.STATES)), np.zeros_like(tau)
    quiet = np.zeros_like(tau) if noise is None else noise
    pulled = np.zeros_like(tau) if len(cables.others) else np.zeros((0, 2))
    P, ropes = plant.P.copy(), (cables.others, cables.waves, cables.ropes)
    loop(y, tau, quiet, control, filtered, PERIOD, step, P, plant.links, ropes, out, tau_s, pulled)
    if not np.isfinite(out).all():
        raise ArithmeticError("the arm left every bound: an unstable case")
    for j in range(2):
        if plant.P[j, at.RIGID] > 0.0:
            out[:, 2 + j], out[:, 6 + j] = out[:, j], out[:, 4 + j]
    t = np.arange(len(tau), dtype=float) * PERIOD
    return Truth(np.asarray(t), out, tau, tau_s, plant.P, plant.links, pulled)
