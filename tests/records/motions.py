"""Motions of known truth for tests of filters: independent of the library, with friction's kinks."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]


def sines(t: Array) -> Array:
    """A slow and a fast joint motion [rad]."""
    return np.asarray(0.9 * np.sin(2 * np.pi * 0.4 * t + 0.3) + 0.1 * np.sin(2 * np.pi * 2.3 * t))


def acceleration(t: Array) -> Array:
    """Second derivative of `sines`, in closed form."""
    slow, fast = 2 * np.pi * 0.4, 2 * np.pi * 2.3
    return np.asarray(-0.9 * slow**2 * np.sin(slow * t + 0.3) - 0.1 * fast**2 * np.sin(fast * t))


def chirp(t: Array) -> Array:
    """0.2 to 6 Hz, amplitude falling as 1/f [rad]."""
    frequency = 0.2 + (6.0 - 0.2) * t / t[-1]
    phase = 2 * np.pi * (0.2 * t + 0.5 * (6.0 - 0.2) * t**2 / t[-1])
    return np.asarray(0.3 / frequency * np.sin(phase))


def stick_slip(t: Array) -> Array:
    """A mass with Coulomb friction pulled by a spring whose end swings: it sticks, slips and reverses [rad].

    In closed form between its events: q'' = w^2 (end - q) - sign(v) level with end = A sin(W t) has the solution
    -sign level/w^2 + P sin(W t) + a cos(w s) + b sin(w s), s counted from the last event.
    """
    out, at, q, v = np.empty(len(t)), float(t[0]), 0.0, 0.0
    while at <= t[-1]:
        if v == 0.0 and abs(_pull(at, q)) <= LEVEL:
            leaves = _first_zero(partial(_grip, q), at)
            out[(t >= at) & (t < leaves)] = q
            at = leaves
            continue
        sign = math.copysign(1.0, v if v else _pull(at, q))
        state = _slipping(at, q, v, sign)
        stops = _first_zero(partial(_speed, state, sign), at + 1e-7)
        inside = (t >= at) & (t < stops)
        out[inside] = state(t[inside])[0]
        at, q, v = stops, float(state(np.array(stops))[0]), 0.0
    return out


OWN, DRIVE, AMPLITUDE, LEVEL = 2 * math.pi * 4.0, 2 * math.pi * 0.5, 0.8, 60.0


def _pull(time: Array | float, q: float) -> Array:
    """The spring's acceleration [rad/s^2]."""
    return np.asarray(OWN**2 * (AMPLITUDE * np.sin(DRIVE * np.asarray(time)) - q))


def _grip(q: float, time: Array) -> Array:
    """What friction could still hold beyond the pull; a hair more than its level, so that slipping does start."""
    return np.asarray(LEVEL * 1.000001 - np.abs(_pull(time, q)))


def _speed(state: Callable[[Array], tuple[Array, Array]], sign: float, time: Array) -> Array:
    """Velocity along the direction of slip."""
    return sign * state(time)[1]


def _slipping(at: float, q: float, v: float, sign: float) -> Callable[[Array], tuple[Array, Array]]:
    """Position and velocity over time from an event on."""
    driven, rest = AMPLITUDE * OWN**2 / (OWN**2 - DRIVE**2), -sign * LEVEL / OWN**2
    a = q - rest - driven * math.sin(DRIVE * at)
    b = (v - driven * DRIVE * math.cos(DRIVE * at)) / OWN

    def state(time: Array) -> tuple[Array, Array]:
        s = OWN * (time - at)
        position = rest + driven * np.sin(DRIVE * time) + a * np.cos(s) + b * np.sin(s)
        return position, driven * DRIVE * np.cos(DRIVE * time) + OWN * (b * np.cos(s) - a * np.sin(s))

    return state


def _first_zero(function: Callable[[Array], Array], at: float) -> float:
    """Where a function that is positive just after `at` first falls to zero."""
    time = at + np.linspace(0.0, 4.0, 40001)
    low = int(np.flatnonzero(function(time)[1:] <= 0)[0])
    return float(brentq(function, time[low], time[low + 1])) if function(time[low]) > 0 else float(time[low + 1])


MOTIONS = {"sines": sines, "chirp": chirp, "stick_slip": stick_slip}
