"""Laws that users write in Python, over whole motions: with arrays if the law accepts them, else sample by sample."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexdyn.arrays import Array, evenly
from flexdyn.effects import Effect
from flexdyn.errors import InputError

TRIED = 5
"""Number of samples at which a law must give the same result for arrays and for single numbers."""


def torque_of(effect: Effect, x: Array, u: Array, *, t: Array, tau: Array) -> Array:
    """The law of an effect along a motion (samples,) [N m or N], as a simulation would call it.

    Args:
        effect: the catalogue's or a user's own.
        x: position of its side (samples,).
        u: velocity of its side (samples,).
        t: time since the start of the run (samples,) [s].
        tau: torque before the law, for the stage ``actuator``; users' laws of other stages get 0.

    Raises:
        InputError: a user's law raises an error, or gives no finite number.
    """
    if not effect.is_python:
        return effect.torque(x, u, t=t, tau=tau)
    tau = tau if effect.stage == "actuator" else np.zeros_like(x)
    with np.errstate(all="ignore"):
        try:
            torque = _at_once(effect, x, u, t, tau)
            if torque is None:
                columns = zip(*(each.tolist() for each in (x, u, t, tau)), strict=True)
                torque = np.array([_single(effect, *row) for row in columns])
        except Exception as error:  # a user's code may raise anything
            problem = f"its law fails along the measured motion: {type(error).__name__}: {error}"
            raise InputError(problem, key=effect.name) from None
    if not np.isfinite(torque).all():
        raise InputError("its law gives no finite torque along the measured motion", key=effect.name)
    return torque


def _single(effect: Effect, x: float, u: float, t: float, tau: float) -> float:
    return float(effect.torque(x, u, t=t, tau=tau))


def _at_once(effect: Effect, x: Array, u: Array, t: Array, tau: Array) -> Array | None:
    """The law over arrays; None if it does not accept arrays, or if the result differs from that of single numbers."""
    try:
        out: Any = np.asarray(effect.torque(x.copy(), u.copy(), t=t.copy(), tau=tau.copy()), dtype=float)
        whole = np.array(np.broadcast_to(out, x.shape))
    except Exception:  # the error is reported for single numbers
        return None
    for k in evenly(len(x), TRIED):
        alone = _single(effect, float(x[k]), float(u[k]), float(t[k]), float(tau[k]))
        if not np.isclose(alone, whole[k], rtol=1e-9, atol=1e-12, equal_nan=True):
            return None
    return whole
