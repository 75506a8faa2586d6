"""What a laboratory has of a robot that it bought: motor encoders, filtered currents, a rate, and a guess of rotors."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from excitation import KINDS
from layout import Array
from recording import quantised
from two_link_run import PERIOD, Truth

Drawn = TypeVar("Drawn")
ROTOR_FACTOR = 2.0  # rotors are guessed: log-uniform between a half and twice
LINK_ERROR = 0.05  # relative standard deviation of masses, centres and inertias of links
TOLERANCE = {"joints.*.rotor_inertia": 0.5, "*": LINK_ERROR}
"""What the model file says of its numbers."""
MARGIN = 10  # samples simulated beyond the end


@dataclass(frozen=True)
class Lab:
    """How a robot is moved and recorded.

    Attributes:
        motion: a kind of `excitation`.
        every: periods of the controller from one recorded sample to the next.
        filtered: time constant of the low pass on the currents [s].
        noise: of the recorded torque, of the joint's peak, standard deviation.
        bits: of the motor encoders, per motor turn.
        cable: root mean square of the cables' torque, of the joint's peak.
    """

    motion: str
    every: int
    filtered: float
    noise: float
    bits: int
    cable: float


def draw_lab(rng: np.random.Generator) -> Lab:
    """Any of the usual ones."""
    return Lab(
        motion=str(rng.choice(KINDS)),
        every=int(rng.choice([1, 2, 4, 8])),
        filtered=float(rng.uniform(2e-3, 8e-3)),
        noise=float(np.exp(rng.uniform(np.log(0.005), np.log(0.02)))),
        bits=int(rng.choice([13, 15, 17])),
        cable=float(rng.uniform(0.01, 0.02)),
    )


def encoder_step(lab: Lab, gear_ratio: float) -> float:
    """One step of a motor encoder, reflected [rad]."""
    return 2.0 * math.pi / gear_ratio / float(2**lab.bits)


def low_pass(tau: Array, time_constant: float) -> Array:
    """The filtered torque at every sample, of one that is held from sample to sample; it begins settled."""
    out, share = np.empty_like(tau), -math.expm1(-PERIOD / time_constant)
    out[0] = tau[0]
    for k in range(1, len(tau)):
        out[k] = out[k - 1] + share * (tau[k - 1] - out[k - 1])
    return out


def record(
    run: Truth, joints: Sequence[str], gear_ratio: Sequence[float], lab: Lab, peak: Array, rng: np.random.Generator
) -> dict[str, Array]:
    """Channels by name, `t` first; peak: torques that the noise is a share of (n,) [N m]."""
    n, kept = len(joints), slice(None, None, lab.every)
    seen = low_pass(run.tau, lab.filtered)
    seen = seen + lab.noise * peak * rng.normal(size=seen.shape)
    channels = {"t": run.t[kept]}
    for j, joint in enumerate(joints):
        channels[f"theta.{joint}"] = quantised(run.y[kept, n + j], encoder_step(lab, gear_ratio[j]))
        channels[f"tau.{joint}"] = seen[kept, j]
    return channels


def cut(run: Truth) -> Truth:
    """The run without its last samples, at which the reference stops dead."""
    kept = slice(None, -MARGIN)
    cables = run.cables[kept] if len(run.cables) else run.cables
    return replace(run, t=run.t[kept], y=run.y[kept], tau=run.tau[kept], tau_s=run.tau_s[kept], cables=cables)


def longer(duration: float) -> float:
    """How long the run must be of which so much is kept [s]."""
    return duration + MARGIN * PERIOD


def rotor_factor(rng: np.random.Generator, n: int) -> Array:
    """Guessed over true rotor inertia (n,)."""
    return np.asarray(np.exp(rng.uniform(-1.0, 1.0, n) * np.log(ROTOR_FACTOR)))


def link_factor(rng: np.random.Generator, n: int) -> Array:
    """Given over true number of a link (n,)."""
    return np.asarray(1.0 + LINK_ERROR * rng.normal(size=n))


def first_that_works(
    family: str, attempts: int, seeds: Sequence[int], draw: Callable[[np.random.Generator], Drawn]
) -> Drawn:
    """The first draw whose arm follows its reference; every attempt has a random stream of its own.

    Args:
        family: of the case, for the error.
        attempts: how many draws are tried.
        seeds: of the case, to which the number of the attempt is added.
        draw: a case from random numbers.

    Raises:
        ArithmeticError: no draw does.
    """
    for attempt in range(attempts):
        with contextlib.suppress(ArithmeticError):
            return draw(np.random.default_rng([*seeds, attempt]))
    seed, _, number = seeds
    raise ArithmeticError(f"{family} {seed} {number}: nothing in {attempts} draws")


def packed(
    family: str,
    seed: int,
    number: int,
    durations: tuple[float, float],
    files: dict[str, str],
    recordings: Sequence[Any],
    answers: dict[str, Any],
) -> dict[str, Any]:
    """Name, files, recordings and truth of one case."""
    name, parts = f"{family}_{seed}_{number:03d}", ("fit", "check")
    truth = {"case": name, "family": family, "seed": seed, "number": number, **dict(zip(parts, durations, strict=True))}
    recorded = dict(zip(parts, recordings, strict=True))
    return {"name": name, "files": files, "recordings": recorded, "truth": truth | answers}
