"""Measured motions of small arms whose truth was computed without flexdyn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.diagnose.equations.covariance import SampleNoise
from tests.arms import slider
from tests.oracles.integrate import held
from tests.oracles.two_link import TwoLink

Array = NDArray[np.float64]
JOINTS = ("shoulder", "elbow")
RATE = 250.0
UNITS = {"q.lift": "m", "tau.lift": "N"}
ARM = TwoLink(stiffness=(400.0, 300.0), damping=(0.8, 0.6), rotor=(0.1, 0.1))


@dataclass(frozen=True)
class Levels:
    """Standard deviations of encoders [rad] and torques [N m]."""

    position: float = 2e-5
    torque: float = 0.01

    def noise(self, n: int = 2) -> SampleNoise:
        """For all joints alike."""
        position = np.full(n, self.position)
        return SampleNoise(position, position, np.full(n, self.torque), np.zeros(n))


@cache
def two_link_motion(seconds: float = 4.0) -> tuple[Array, Array]:
    """States [q, theta, v, omega] of ARM at every sample, and the torques held after each."""
    t = np.arange(round(seconds * RATE)) / RATE
    tau = np.stack([2.0 * np.sin(5.1 * t + 0.5) + np.sin(13.0 * t), np.sin(6.7 * t) + 0.5 * np.sin(17.0 * t)], axis=1)
    rows = iter(tau.tolist())
    states, _ = held(ARM.derivative, [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0], t, lambda _t, _x: next(rows))
    return states, tau


def one_after_the_other(arm: TwoLink, tau: Array) -> Array:
    """States of an arm, its elbow's motor stuck in the first half of the torques and its shoulder's in the second."""
    t = np.arange(len(tau)) / RATE
    middle = len(tau) // 2

    def half(stuck: int, at: slice, start: list[float]) -> Array:
        rows: Iterator[list[float]] = iter(tau[at].tolist())

        def moves(x: Sequence[float], torque: Sequence[float]) -> Sequence[float]:
            rates = list(arm.derivative(x, torque))
            rates[2 + stuck] = rates[6 + stuck] = 0.0
            return rates

        return np.asarray(held(moves, start, t[at], lambda _t, _x: next(rows))[0])

    one = half(1, slice(middle), [0.1, 0.9, 0.1, 0.9, 0, 0, 0, 0])
    begin = one[-1].copy()
    begin[6] = 0.0  # the shoulder's brake closes
    return np.concatenate([one, half(0, slice(middle, None), begin.tolist())])


def two_link_recording(levels: Levels, seed: int, signals: Sequence[str] = ("q", "theta")) -> fd.Recording:
    """ARM's motion as its encoders saw it: rounded to steps as coarse as their noise, with noise on the torques."""
    states, tau = two_link_motion()
    draw = np.random.default_rng(seed)
    step = np.sqrt(12.0) * levels.position
    channels = {}
    for j, joint in enumerate(JOINTS):
        for signal, column in (("q", j), ("theta", 2 + j)):
            if signal in signals:
                channels[f"{signal}.{joint}"] = step * np.round(states[:, column] / step)
        channels[f"tau.{joint}"] = tau[:, j] + levels.torque * draw.standard_normal(len(tau))
    return fd.Recording(np.arange(len(tau)) / RATE, channels)


def sliding(force: Array, dt: float, mass: float, level: float) -> tuple[Array, Array]:
    """Position and velocity of a mass under held forces and Coulomb friction: parabolas and rests, exactly."""
    x, v, xs, vs = 0.0, 0.0, [], []
    for f in force.tolist():
        xs.append(x)
        vs.append(v)
        left = dt
        while left > 0.0:
            way = np.sign(v) if v else np.sign(f)
            if v == 0.0 and abs(f) <= level:
                break
            a = (f - way * level) / mass
            step = -v / a if v * a < 0.0 and -v / a < left else left
            x, v = x + v * step + 0.5 * a * step * step, 0.0 if step < left else v + a * step
            left -= step
    return np.array(xs), np.array(vs)


def slider_model(folder: Path, effects: Sequence[fd.effects.Effect] = ()) -> fd.FlexibleJointModel:
    """2.5 kg on a rigid prismatic joint, weightless."""
    return fd.FlexibleJointModel(slider(folder), {}, effects, gravity=[0.0, 0.0, 0.0])


def slider_recording(x: Array, force: Array, rate: float, levels: Levels, seed: int) -> fd.Recording:
    """What its encoder saw, with white noise."""
    draw = np.random.default_rng(seed)
    q = x + levels.position * draw.standard_normal(len(x))
    tau = force + levels.torque * draw.standard_normal(len(force))
    return fd.Recording(np.arange(len(x)) / rate, {"q.lift": q, "tau.lift": tau}, meta={"units": UNITS})
