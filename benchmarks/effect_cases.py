"""One motion for every effect of the catalogue, in flexdyn and integrated by SciPy from equations written by hand."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.effects import Effect, SensorEffect
from tests.effects.arms import ELASTIC, RIGID, model_of, states
from tests.effects.dry_reference import integrate
from tests.effects.reference import LENGTH, Arm, trajectory
from tests.effects.test_sticking import contact_of

Array = NDArray[np.float64]
TORQUE = [0.9, -0.5]
START: dict[str, Any] = {"q0": [-0.4, 0.7], "v0": [0.6, -0.5]}
TIMES = np.linspace(0.0, 1.5, 31)
STICKING_TIMES = np.linspace(0.0, 9.0, 181)
STICKING_START, STICKING_TORQUE = -1.1, 0.2
STICKING_ARM = Arm((40.0,), (0.2,), (0.5,), gravity=9.81)
"""A heavy pendulum on an elastic joint, which stops and breaks away several times."""
EXACT = fd.solvers.DormandPrince(rtol=1e-12, atol=1e-13)
CORNERS = 2e-3
"""SciPy crosses corners in steps this small [s]."""
ACTING: dict[str, dict[str, float]] = {
    "coulomb_friction": {"level": 0.5},
    "asymmetric_friction": {"level_positive": 0.7, "level_negative": 0.3},
    "torque_speed_limit": {"stall_torque": 0.8, "no_load_speed": 1.2},
    "end_stop": {"lower": -0.5, "upper": 0.1},
    "command_delay": {"delay": 0.137},
    "channel_lag": {"delay": 0.023},
}
"""Numbers over those of the example, with which the effect acts in these motions."""


def acting(kind: type[Effect]) -> Any:
    """The effect on the shoulder with numbers that matter."""
    effect: Any = kind.example("shoulder", "elbow")
    return dataclasses.replace(effect, **ACTING.get(kind.name, {}))


def arm_of(effect: Effect) -> Arm:
    """The two-link arm that suits it: its joints are elastic unless the effect makes one so."""
    return RIGID if effect.name == "joint_elasticity" else ELASTIC


class Loaded(Arm):
    """The two-link arm with a payload at its tip."""

    def mass_matrix(self, q: Sequence[float]) -> Array:
        """M(q) + m J'J."""
        J, _ = self._tip(q, [0.0, 0.0])
        return super().mass_matrix(q) + self._mass * J.T @ J

    def bias(self, q: Sequence[float], v: Sequence[float]) -> Array:
        """H(q, v) + m J'(J'v + g)."""
        J, acceleration = self._tip(q, v)
        weight: Array = self._mass * J.T @ (acceleration + np.array([0.0, self.gravity]))
        return super().bias(q, v) + weight

    @property
    def _mass(self) -> float:
        return float(sum(e.mass for e in self.effects if e.name == "payload"))

    def _tip(self, q: Sequence[float], v: Sequence[float]) -> tuple[Array, Array]:
        """The tip's Jacobian and its acceleration at a = 0."""
        (s1, c1), (s2, c2) = ((math.sin(a), math.cos(a)) for a in (q[0], q[0] + q[1]))
        both = v[0] + v[1]
        J = LENGTH * np.array([[-s1 - s2, -s2], [c1 + c2, c2]])
        return J, -LENGTH * np.array([v[0] ** 2 * c1 + both**2 * c2, v[0] ** 2 * s1 + both**2 * s2])


def scipy_difference(effect: Any) -> tuple[float, int]:
    """Largest difference of any state or measured channel from SciPy [rad, rad/s], and the events flexdyn located."""
    if isinstance(effect, SensorEffect):
        return _measured_difference(effect), 0
    if effect.stage == "dry":
        return _sticking_difference(effect)
    arm = dataclasses.replace(arm_of(effect), effects=(effect,), gravity=2.0)
    model = model_of(arm)
    run = fd.simulate(model, TORQUE, TIMES[-1], EXACT, times=TIMES, **START)
    found, expected = states(run), _reference(effect, arm)
    return float(np.abs(found - expected[:, : found.shape[1]]).max()), run.stats["events"]


def _reference(effect: Any, arm: Arm) -> Array:
    """States of SciPy at `TIMES`."""
    if effect.name == "payload":
        arm = Loaded(**{field.name: getattr(arm, field.name) for field in dataclasses.fields(arm)})
    if effect.name == "joint_elasticity":
        arm = dataclasses.replace(arm, stiffness=(effect.stiffness, math.inf), effects=())
    if effect.name == "parameter_error":
        arm = dataclasses.replace(arm, rotor=(effect.factor * arm.rotor[0], arm.rotor[1]), effects=())
    q, v = START["q0"], START["v0"]
    at_rotors = [[signal[j] for j in arm.elastic] for signal in (q, v)]
    x0 = [*q, *at_rotors[0], *v, *at_rotors[1], *[0.0] * isinstance(effect, fd.effects.MemoryEffect)]
    late = effect.delay if effect.name == "command_delay" else 0.0
    rows, x = [np.array(x0)], np.array(x0)
    for begin, end, tau in ((0.0, late, [0.0, TORQUE[1]]), (late, TIMES[-1], TORQUE)):
        inside = np.array([t for t in TIMES if begin < t <= end])
        if begin < end:
            found = trajectory(_right_side(arm, tau), x, np.unique([begin, *inside, end]), CORNERS)
            rows += list(found[1 : 1 + len(inside)])
            x = found[-1]
    return np.array(rows)


def _right_side(arm: Arm, tau: list[float]) -> Callable[[float, Sequence[float]], list[float]]:
    return lambda t, x: arm.derivative(t, x, tau)


def _sticking_difference(effect: Any) -> tuple[float, int]:
    """Set-valued friction on the rotor of a pendulum, against an integration that locates its events itself."""
    effect = dataclasses.replace(effect, side="motor")
    arm = dataclasses.replace(STICKING_ARM, effects=(effect,))
    times = STICKING_TIMES
    run = fd.simulate(model_of(arm), [STICKING_TORQUE], times[-1], EXACT, times=times, q0=[STICKING_START])
    x0 = [STICKING_START, STICKING_START, 0.0, 0.0]
    expected, _ = integrate(contact_of(arm, "motor", STICKING_TORQUE), x0, times)
    return float(np.abs(states(run) - expected).max()), run.stats["events"]


def _measured_difference(effect: Any) -> float:
    """A recording's channel against the sensor's law over the true motion."""
    run = fd.simulate(model_of(ELASTIC, [effect]), TORQUE, TIMES[-1], EXACT, rate=200.0, **START)
    signal, _, joint = effect.channel.partition(".")
    true = getattr(run, signal)[:, run.joint_names.index(joint)]
    laws = {
        "channel_lag": lambda: np.interp(run.t - effect.delay, run.t, true),
        "encoder_eccentricity": lambda: true + effect.amplitude * np.sin(effect.harmonic * true + effect.phase),
        "sensor_offset": lambda: true + effect.offset,
        "sensor_gain": lambda: true + effect.gain * true,
    }
    return float(np.abs(run.to_recording()[effect.channel] - laws[effect.name]()).max())
