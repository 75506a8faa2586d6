"""What is written down of a run: encoders with their steps, noise on the torque, sensors that err."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from hidden import Hidden
from layout import Array
from scipy.interpolate import CubicSpline
from two_link_run import PERIOD, Truth

LINK_BITS, MOTOR_BITS = 20, 17
TORQUE_NOISE = 0.002  # of the joint's peak torque, standard deviation


@dataclass(frozen=True)
class Sensors:
    """What is measured and how well.

    Attributes:
        noise: 1: design; 10: ten times coarser encoders and ten times the torque noise.
        positions: "both", "motor" or "link" encoders.
        motor_bits_per_turn_of: "motor": 17 bit per motor turn; "joint": per turn of the joint.
        velocities: v and omega are recorded too, as differences of the encoders.
        torque_sensor: tau_s is recorded.
        actuator_noise: the torque noise is in the motor and not in what is written down.
        every: periods of the controller from one sample to the next; torques are averaged over them, and noisy after.
    """

    noise: float = 1.0
    positions: str = "both"
    motor_bits_per_turn_of: str = "motor"
    velocities: bool = False
    torque_sensor: bool = False
    actuator_noise: bool = False
    every: int = 1

    def link_step(self) -> float:
        """One step of the link encoders [rad]."""
        return self.noise * 2.0 * math.pi / float(2**LINK_BITS)

    def motor_step(self, gear_ratio: float) -> float:
        """One step of the motor encoders, reflected [rad]."""
        turn = 2.0 * math.pi / (gear_ratio if self.motor_bits_per_turn_of == "motor" else 1.0)
        return self.noise * turn / float(2**MOTOR_BITS)


def quantised(x: Array, step: float) -> Array:
    """The greatest whole step not above x."""
    return np.asarray(np.floor(x / step) * step)


def read(truth: Array, effects: Sequence[Hidden]) -> Array:
    """A channel as its sensor reports it, before it is quantised: lag, eccentricity, gain, offset, in this order."""
    x, t = truth, np.arange(len(truth)) * PERIOD
    delay = sum(e.parameters["delay"] for e in effects if e.effect == "channel_lag")
    if delay:
        x = CubicSpline(t, x)(np.maximum(t - delay, 0.0))
    discs = [e.parameters for e in effects if e.effect == "encoder_eccentricity"]
    x = x + sum((p["amplitude"] * np.sin(p["harmonic"] * x + p["phase"]) for p in discs), np.zeros_like(x))
    x = x * (1.0 + sum(e.parameters["gain"] for e in effects if e.effect == "sensor_gain"))
    return np.asarray(x + sum(e.parameters["offset"] for e in effects if e.effect == "sensor_offset"))


def averaged(held: Array, every: int) -> Array:
    """Means of a held torque from each kept sample to the next."""
    if every == 1:
        return held
    starts = np.arange(0, len(held), every)
    return np.asarray(np.add.reduceat(held, starts) / np.diff(np.append(starts, len(held))))


def record(
    run: Truth,
    joints: Sequence[str],
    gear_ratio: Sequence[float],
    hidden: Sequence[Hidden],
    sensors: Sensors,
    rng: np.random.Generator,
) -> dict[str, Array]:
    """Channels by name, `t` first; the run's states are [q, theta, v, omega] of so many joints."""
    n, kept, channels = len(joints), slice(None, None, sensors.every), {"t": run.t[:: sensors.every]}
    for j, joint in enumerate(joints):
        for signal, first, step in (("q", 0, sensors.link_step()), ("theta", n, sensors.motor_step(gear_ratio[j]))):
            if sensors.positions == ("motor" if signal == "q" else "link"):
                continue
            name = f"{signal}.{joint}"
            effects = [e for e in hidden if e.place.get("channel") == name]
            channels[name] = quantised(read(run.y[:, first + j], effects)[kept], step)
            if sensors.velocities:
                rate = np.diff(channels[name], prepend=channels[name][0]) / (sensors.every * PERIOD)
                channels[f"{'v' if signal == 'q' else 'omega'}.{joint}"] = rate
        sigma = TORQUE_NOISE * sensors.noise * float(np.abs(run.tau[:, j]).max())
        noise = 0.0 if sensors.actuator_noise else sigma * rng.normal(size=len(channels["t"]))
        channels[f"tau.{joint}"] = averaged(run.tau[:, j], sensors.every) + noise
        if sensors.torque_sensor:
            sigma = TORQUE_NOISE * sensors.noise * float(np.abs(run.tau_s[:, j]).max())
            channels[f"tau_s.{joint}"] = run.tau_s[kept, j] + sigma * rng.normal(size=len(channels["t"]))
    return channels
