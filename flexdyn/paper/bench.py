"""The paper's arm on a test bench: a controller moves it, encoders measure it, and the torques are noisy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexdyn.arrays import Array
from flexdyn.control.commands import Controller, State
from flexdyn.paper import equations as eq
from flexdyn.paper.cases import PaperCases, reference, torque_of_fig4
from flexdyn.records import Recording
from flexdyn.simulation.run import Run
from flexdyn.simulation.simulate import simulate

Corners = Sequence[tuple[float, float]]

BENCH_RATE = 1000.0  # Hz, of control and of recordings
LINK_STEP = 2.0 * np.pi / 2**20  # rad: encoders of 20 bit on the links
MOTOR_STEP = 2.0 * np.pi / 2**17 / 100.0  # rad: of 17 bit on the motor shafts, behind gears of 100
TORQUE_NOISE = 0.002  # of the greatest torque, standard deviation
KP, KD = 2.0, 1.0  # N m/rad, N m s/rad: as stiff as the springs allow
FILTERED = 1.5e-3  # s, low pass on the differences of the encoders
LARGEST_ASKED_TORQUE = 0.5  # N m, that the controller asks for: it stays below the actuator line of Table I
BENCH_FIG4_DURATION = 12.0  # s, of the run under the torque of Fig. 4

# Times [s] and angles [rad] at which each joint comes to rest: fast moves, slow sweeps, dwells.
FIT: tuple[Corners, Corners] = (
    (
        *((0.0, 0.0), (4.0, 0.7), (8.0, 0.1), (9.0, 0.1), (15.0, 0.35), (18.5, -0.3), (21.5, 0.1), (22.5, 0.1)),
        *((29.0, -0.1), (32.5, -0.5), (36.0, 0.1), (38.0, 0.1), (40.0, 0.3)),
    ),
    (
        *((0.0, 1.57), (2.0, 1.1), (4.0, 1.9), (10.0, 1.5), (11.5, 1.5), (14.0, 1.95), (15.5, 1.95), (17.0, 1.0)),
        *((19.0, 1.7), (20.5, 1.3), (25.0, 1.5), (26.5, 0.7), (28.5, 1.2), (30.0, 1.2), (36.0, 1.45), (38.0, 0.8)),
        (40.0, 1.5),
    ),
)
CHECK: tuple[Corners, Corners] = (
    ((0.0, 0.3), (4.0, -0.3), (5.0, -0.3), (9.0, 0.0), (12.0, 0.5)),
    ((0.0, 1.2), (5.0, 1.4), (6.0, 1.4), (8.0, 0.6), (10.0, 1.5), (12.0, 1.0)),
)


@dataclass(frozen=True)
class Bench:
    """Runs of the true arm, and their recordings.

    Attributes:
        cases: with the shipped model, which is the truth here.
        seed: of the torque noise.
    """

    cases: PaperCases
    seed: int = 7

    @cached_property
    def runs(self) -> Mapping[str, Run]:
        """The true runs: a controlled motion to fit, another one to test, and the torque of Fig. 4."""
        torque = torque_of_fig4(BENCH_FIG4_DURATION)
        driven = simulate(self.cases.model, torque, BENCH_FIG4_DURATION, reference(), rate=BENCH_RATE)
        return {"fit": self._controlled(FIT), "check": self._controlled(CHECK), "check_fig4": driven}

    @cached_property
    def recordings(self) -> Mapping[str, Recording]:
        """The runs as the sensors report them."""
        noise = np.random.default_rng(self.seed)
        return {name: bench_recording(run.t, run.q, run.theta, run.tau, noise, name) for name, run in self.runs.items()}

    def _controlled(self, corners: tuple[Corners, Corners]) -> Run:
        wanted = corner_motion(corners)
        law = PaperServo(wanted, feedforward(self.cases.arm(), wanted))
        duration = (len(wanted) - 1) / BENCH_RATE
        control = Controller(law, BENCH_RATE)
        return simulate(self.cases.model, control, duration, reference(), q0=wanted[0], rate=BENCH_RATE)


@dataclass
class PaperServo:
    """PD control on the motor encoders, with the torque of the rigid arm as feedforward.

    Attributes:
        wanted: reference positions (samples, 2) [rad].
        forward: torques (samples, 2) [N m].
    """

    wanted: Array
    forward: Array
    _seen: Array | None = field(default=None, init=False)
    _slow: Array = field(default_factory=lambda: np.zeros(2), init=False)

    def __call__(self, t: float, state: State) -> Array:
        """Commanded torques, held to the next sample (2,) [N m]."""
        k = min(round(t * BENCH_RATE), len(self.wanted) - 2)
        seen = quantised(state.theta, MOTOR_STEP)
        last = seen if self._seen is None else self._seen
        share = 1.0 / (1.0 + FILTERED * BENCH_RATE)
        self._slow = self._slow + share * ((seen - last) * BENCH_RATE - self._slow)
        self._seen = seen
        speed = (self.wanted[k + 1] - self.wanted[k]) * BENCH_RATE
        torque = self.forward[k] + KP * (self.wanted[k] - seen) + KD * (speed - self._slow)
        return np.asarray(np.clip(torque, -LARGEST_ASKED_TORQUE, LARGEST_ASKED_TORQUE))


def corner_motion(corners: tuple[Corners, Corners]) -> Array:
    """A motion from corner to corner, with zero velocity and acceleration at each corner (samples, 2) [rad]."""
    t = np.arange(round(corners[0][-1][0] * BENCH_RATE) + 1) / BENCH_RATE
    columns = []
    for each in corners:
        times, angles = np.array(each).T
        k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
        s = (t - times[k]) / np.diff(times)[k]
        columns.append(angles[k] + np.diff(angles)[k] * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
    return np.stack(columns, axis=1)


def feedforward(arm: eq.Arm, wanted: Array) -> Array:
    """Torques that the rigid arm without friction needs for a motion, eq. 12-15 (samples, 2) [N m]."""
    v = np.gradient(wanted, 1.0 / BENCH_RATE, axis=0)
    a = np.gradient(v, 1.0 / BENCH_RATE, axis=0)
    links = np.einsum("tij,tj->ti", eq.mass_matrix(arm, wanted), a) + eq.coriolis(arm, wanted, v)
    return np.asarray(links + arm.J * a)


def bench_recording(
    t: ArrayLike, q: Array, theta: Array, tau: Array, noise: np.random.Generator, name: str = ""
) -> Recording:
    """A recording of both joints by encoders and torque sensors; q, theta and tau are (samples, 2) each."""
    channels = {}
    for j, joint in enumerate(("shoulder", "elbow")):
        level = TORQUE_NOISE * float(np.abs(tau[:, j]).max())
        channels[f"q.{joint}"] = quantised(q[:, j], LINK_STEP)
        channels[f"theta.{joint}"] = quantised(theta[:, j], MOTOR_STEP)
        channels[f"tau.{joint}"] = tau[:, j] + level * noise.normal(size=len(tau))
    return Recording(np.asarray(t, dtype=float), channels, name=name)


def quantised(x: Array, step: float) -> Array:
    """The greatest whole step not above x."""
    return np.asarray(np.floor(x / step) * step)
