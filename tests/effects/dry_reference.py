"""One dry contact on one joint, integrated with its events located by SciPy: slide, stop, stick, break away."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
State = Sequence[float] | Array


@dataclass(frozen=True)
class Contact:
    """What the hybrid integration needs to know.

    Args:
        free: x' with a given friction torque on the contact.
        place: of the contact's velocity in x.
        inertia: that the friction torque accelerates [kg m^2].
        level: interval's end in a direction of motion, at (t, x) [N m].
        corner: changes its sign where the level has a corner, at (t, x); None: nowhere.
    """

    free: Callable[[float, State, float], Array]
    place: int
    inertia: float
    level: Callable[[float, State, float], float]
    corner: Callable[[float, State], float] | None = None

    def needed(self, t: float, x: State) -> float:
        """Friction that keeps the contact from accelerating [N m]."""
        return float(self.inertia * self.free(t, x, 0.0)[self.place])

    def next_motion(self, t: float, x: State) -> int:
        """At rest: 0 where friction can hold, else the direction in which the joint leaves."""
        net = self.needed(t, x)
        return 1 if net > self.level(t, x, 1.0) else -1 if net < -self.level(t, x, -1.0) else 0


def _sliding(contact: Contact, motion: int, begin: float) -> tuple[Any, list[Any]]:
    def f(t: float, x: Array) -> Array:
        return contact.free(t, x, motion * contact.level(t, x, motion))

    def stop(t: float, x: Array) -> float:
        # At the instant of breaking away its acceleration is 0 to rounding, of either sign.
        return float(motion * x[contact.place]) if t > begin + 1e-7 else 1.0

    stop.terminal, stop.direction = True, -1.0  # type: ignore[attr-defined]
    return f, [stop]


def _stuck(contact: Contact) -> tuple[Any, list[Any]]:
    def f(t: float, x: Array) -> Array:
        dx = contact.free(t, x, contact.needed(t, x))
        dx[contact.place] = 0.0
        return dx

    def up(t: float, x: Array) -> float:
        return contact.level(t, x, 1.0) - contact.needed(t, x)

    def down(t: float, x: Array) -> float:
        return contact.level(t, x, -1.0) + contact.needed(t, x)

    for event in (up, down):
        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
    return f, [up, down]


def integrate(contact: Contact, x0: State, times: Array, max_step: float = 0.05) -> tuple[Array, list[float]]:
    """States at `times`, and the instants at which the contact stopped, broke away or passed a corner of its level."""
    t, x = 0.0, np.array(x0, dtype=float)
    out: list[Array] = []
    events: list[float] = []
    motion = int(np.sign(x[contact.place])) or contact.next_motion(0.0, x)
    while True:
        f, watched = _sliding(contact, motion, t) if motion else _stuck(contact)
        ends = len(watched)
        if contact.corner is not None:
            watched = [*watched, contact.corner]
        found = solve_ivp(
            f,
            (t, times[-1]),
            x,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=max_step,
            events=watched,
            t_eval=times[times >= t],
        )
        assert found.success, found.message
        over = [(float(at), x) for k in range(ends) for at, x in zip(found.t_events[k], found.y_events[k], strict=True)]
        end = over[0][0] if over else math.inf
        if len(found.t):
            out.append(found.y.T[found.t < end])
        events += [float(at) for passed in found.t_events[ends:] for at in passed if at > t + 1e-9]
        if not over:
            return np.vstack(out), events
        t, x = end, over[0][1].copy()
        events.append(t)
        if motion:
            x[contact.place] = 0.0
            motion = contact.next_motion(t, x)
        else:
            motion = 1 if contact.needed(t, x) > 0.0 else -1
        assert len(events) < 200
