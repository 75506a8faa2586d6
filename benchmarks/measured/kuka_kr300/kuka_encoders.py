"""What the difference between motor and link encoders is made of: term by term, fitted to A, looked at on B and C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd

Array = NDArray[np.float64]
CUTOFF = 8.0
"""Of the filter that positions pass before terms are fitted [Hz]."""
GAIN = 0.03
"""Share by which a term must lower what is left of both check records."""
FASTER = 0.15
"""Speed above which a ripple over position is looked for [rad/s]."""
BANDS = ((0.06, 0.15), (0.15, 0.25), (0.25, 0.5))
"""Speeds at which its size and phase are compared [rad/s]."""
TERMS = {
    "lag": "the link encoder is late: theta - q = delay * velocity",
    "spring": "the gear bends under the links' torque: torque / stiffness",
    "scale": "a gear ratio or encoder scale is wrong: in proportion to the position",
    "hysteresis": "backlash or hysteresis: a step where the velocity changes its sign",
    "inertial": "in proportion to the acceleration: a second-order filter, or torque of a wrong inertia",
}


@dataclass(frozen=True, eq=False)
class Difference:
    """One axis in one record.

    Attributes:
        t: (samples,) [s].
        theta, q: motor and link encoder as recorded (samples,) [rad].
        left: theta - q, smoothed (samples,) [rad].
        columns: terms of `TERMS` (samples,); those of the spring in N m.
        omega: speed (samples,) [rad/s].
    """

    t: Array
    theta: Array
    q: Array
    left: Array
    columns: Mapping[str, Array]
    omega: Array


def differences(model: fd.FlexibleJointModel, recording: fd.Recording, axes: Sequence[int]) -> list[Difference]:
    """The difference theta - q of some axes, and all that it may be made of; torques are the corrected model's."""
    joints = model.joint_names
    seen = fd.derivatives(recording, [f"theta.{joint}" for joint in joints], cutoff=CUTOFF)
    theta, omega, alpha = (
        np.stack([of(f"theta.{joint}") for joint in joints], axis=1) for of in (seen.value, seen.first, seen.second)
    )
    links = fd.LinkSide(model)
    armature = model.resolved().rotor_inertia
    torque = np.einsum("tij,tj->ti", links.mass_matrix(theta), alpha) + links.bias(theta, omega) - armature * alpha
    for effect in model.resolved().effects:
        if isinstance(effect, fd.effects.ParallelSpring):
            j = model.index(effect.joint)
            torque[:, j] += effect.stiffness * (theta[:, j] - effect.rest)
    found = []
    for j in axes:
        columns = {
            "lag": omega[:, j],
            "spring": torque[:, j],
            "scale": theta[:, j],
            "hysteresis": np.tanh(omega[:, j] / 5e-3),
            "inertial": alpha[:, j],
        }
        motor, link = (recording[f"{signal}.{joints[j]}"][seen.smoother.valid] for signal in ("theta", "q"))
        smooth = theta[:, j] - seen.value(f"q.{joints[j]}")
        found.append(Difference(seen.t, motor, link, smooth, columns, omega[:, j]))
    return found


@dataclass(frozen=True)
class Account:
    """What one axis' difference is made of.

    Attributes:
        left: root mean square by record, about its mean, before and after every term, in the order of choice [rad].
        terms: chosen, best first.
        estimates: of all three records by term, all chosen terms together.
        refused: the terms that the check did not want, with what each would be by record beside those that were chosen.
        zeros: mean of theta - q by record [rad].
    """

    left: Sequence[Mapping[str, float]]
    terms: tuple[str, ...]
    estimates: Mapping[str, Mapping[str, float]]
    refused: Mapping[str, Mapping[str, float]]
    zeros: Mapping[str, float]


def account(seen: Mapping[str, Difference]) -> Account:
    """Take in terms one by one, the best on A first, while B and C both get better; zeros are each record's own."""
    chosen: tuple[str, ...] = ()
    left = [_left(seen, chosen)]
    while True:
        trials = {name: _left(seen, (*chosen, name)) for name in TERMS if name not in chosen}
        gains = {name: min(1.0 - after[k] / left[-1][k] for k in ("B", "C")) for name, after in trials.items()}
        good = [name for name in sorted(trials, key=lambda name: trials[name]["A"]) if gains[name] > GAIN]
        if not good:
            break
        chosen = (*chosen, good[0])
        left.append(trials[good[0]])
    estimates = {name: dict(zip(chosen, _fitted(of, chosen).tolist(), strict=True)) for name, of in seen.items()}
    by_term = {term: {name: each[term] for name, each in estimates.items()} for term in chosen}
    refused = {
        term: {name: float(_fitted(of, (*chosen, term))[-1]) for name, of in seen.items()}
        for term in TERMS
        if term not in chosen
    }
    return Account(tuple(left), chosen, by_term, refused, {name: float(of.left.mean()) for name, of in seen.items()})


def _centred(of: Difference, terms: Sequence[str]) -> tuple[Array, Array]:
    X = np.stack([of.columns[name] for name in terms], axis=1) if terms else np.zeros((len(of.t), 0))
    return X - X.mean(axis=0), of.left - of.left.mean()


def _fitted(of: Difference, terms: Sequence[str]) -> Array:
    X, y = _centred(of, terms)
    return np.asarray(np.linalg.lstsq(X, y, rcond=None)[0])


def _left(seen: Mapping[str, Difference], terms: Sequence[str]) -> dict[str, float]:
    fitted = _fitted(seen["A"], terms)
    found = {}
    for name, of in seen.items():
        X, y = _centred(of, terms)
        found[name] = float((y - X @ fitted).std())
    return found


@dataclass(frozen=True)
class Ripple:
    """A sine over position in theta - q.

    Attributes:
        harmonic: cycles per turn of the axis.
        size: amplitude by band of speed, over all records [rad].
        own: spread of its phase over bands, directions and records, about each record's mean, where it is counted by
            the link encoder's own angle [rad].
        motor: the same by the motor's angle.
        floor: size of the median harmonic [rad].
    """

    harmonic: float
    size: tuple[float, ...]
    own: float
    motor: float
    floor: float


def ripple(seen: Mapping[str, Difference]) -> Ripple:
    """The strongest sine over position that all records share."""
    harmonics = np.arange(40.0, 1200.0, 0.5)
    fast = {name: _quick(of) for name, of in seen.items()}
    sizes = np.sqrt(np.mean([_spectrum(of, fast[name], harmonics) ** 2 for name, of in seen.items()], axis=0))
    harmonic = float(harmonics[np.argmax(sizes)])
    size = tuple(
        float(np.mean([_sine(of, fast[n], of.q, harmonic, *band)[0] for n, of in seen.items()])) for band in BANDS
    )
    spread = {}
    for which in ("q", "theta"):
        off = []
        for name, of in seen.items():
            turns = [
                np.exp(1j * _sine(of, fast[name], getattr(of, which), harmonic, *band, way)[1])
                for band in BANDS
                for way in (-1.0, 1.0)
            ]
            mean = np.nanmean(turns)
            off += [np.angle(turn / mean) for turn in turns if np.isfinite(turn)]
        spread[which] = float(np.sqrt(np.mean(np.square(off))))
    return Ripple(harmonic, size, spread["q"], spread["theta"], float(np.median(sizes)))


def _quick(of: Difference) -> Array:
    """The difference theta - q less its mean over 0.1 s, zero at the ends."""
    raw = of.theta - of.q
    kernel = np.full(25, 1.0 / 25.0)
    quick = raw - np.convolve(raw, kernel, "same")
    quick[:13], quick[-13:] = 0.0, 0.0
    return np.asarray(quick)


def _spectrum(of: Difference, quick: Array, harmonics: Array) -> Array:
    """Size of the sine over the link encoder's angle at every harmonic, where the axis is fast (harmonics,)."""
    rows = np.abs(of.omega) > FASTER
    turns = np.exp(-1j * np.outer(harmonics, of.q[rows]))
    return np.asarray(2.0 * np.abs(turns @ quick[rows]) / rows.sum())


def _sine(
    of: Difference, quick: Array, x: Array, harmonic: float, slow: float, fast: float, way: float = 0.0
) -> tuple[float, float]:
    """Amplitude and phase of a sine over x at some speeds; NaN where there are too few samples."""
    rows = (np.abs(of.omega) > slow) & (np.abs(of.omega) < fast) & ((way == 0.0) | (np.sign(of.omega) == way))
    if rows.sum() < 60:
        return float("nan"), float("nan")
    X = np.stack([np.sin(harmonic * x[rows]), np.cos(harmonic * x[rows])], axis=1)
    a, b = np.linalg.lstsq(X, quick[rows], rcond=None)[0]
    return float(np.hypot(a, b)), float(np.arctan2(b, a))
